"""Words of a command line as values: each has the range of the key that it stands for, and the words of its faults."""

from argparse import ArgumentTypeError
from collections.abc import Callable, Sequence
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

from millprint.config.errors import ConfigError, readable
from millprint.config.section import Section
from millprint.config.wording import in_words

# The names of options of Snakemake that set keys.
NAMES = {"--configfile": ("--configfile", "--configfiles"), "--config": ("--config", "-C")}
# Simulations or jobs at a time.
Cores = Annotated[int, Field(ge=1, le=100_000)]


def value_of(key: str, kind: Any) -> Callable[[str], Any]:
    """What reads a word, for `type` of argparse; key: names the unit, as speed_rpm does; kind: an annotated type."""
    adapter = TypeAdapter(kind, config=ConfigDict(allow_inf_nan=False))

    def read(word: str) -> Any:
        try:
            return adapter.validate_python(word)
        except ValidationError as error:
            words = in_words(error.errors()[0], key)
            raise ArgumentTypeError(readable(words if repr(word) in words else f"{word!r}: {words}")) from None

    # What argparse calls the value.
    read.__name__ = key
    return read


def value_of_key(section: type[Section], key: str) -> Callable[[str], Any]:
    """What reads a word that stands for a key of a section, as `value_of`."""
    field = section.model_fields[key]
    return value_of(key, Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation)


def card_folder(word: str) -> Path:
    """The folder of a card, for `type` of argparse."""
    if not Path(word).exists():
        raise ArgumentTypeError(f"{word}: no such card; give the folder that `millprint card` wrote")
    return Path(word)


def check_written(written: str | Path | None, *read: str | Path) -> None:
    """Raise ConfigError if a file that is to be written is one of those that are read, and would be lost."""
    for path in read if written else ():
        if Path(path).exists() and Path(written or "").exists() and Path(path).samefile(written or ""):
            raise ConfigError(f"{written}: is read and would be lost; give what is written another name")


def values_of(words: Sequence[str], option: str) -> list[list[str]]:
    """What follows each time that an option of Snakemake is given, by any of its names: words to the next option."""
    groups: list[list[str]] = []
    within = False
    for word in words:
        name, equals, value = word.partition("=")
        if name in NAMES[option]:
            groups.append([value] if equals else [])
        elif within and not word.startswith("-"):
            groups[-1].append(word)
        within = name in NAMES[option] or (within and not word.startswith("-"))
    return groups


def check_configfiles(words: Sequence[str]) -> None:
    """Raise ConfigError for a file after --configfile that is not there; Snakemake ends with a traceback."""
    for path in chain.from_iterable(values_of(words, "--configfile")):
        if path and not Path(path).is_file():
            raise ConfigError(f"--configfile {path}: no such file")
