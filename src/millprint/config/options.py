"""Options of Snakemake that replace each other where they are given twice. The Snakefile imports this."""

from collections.abc import Sequence

from millprint.config.errors import ConfigError

# The option that is meant by each name of it.
OPTIONS = {"--configfile": "--configfile", "--configfiles": "--configfile", "--config": "--config", "-C": "--config"}


def check_given_once(words: Sequence[str]) -> None:
    """Raise ConfigError where a command line gives --configfile or --config twice: Snakemake reads the last only."""
    given: dict[str, list[list[str]]] = {}
    current: list[str] | None = None
    for word in words:
        name, equals, value = word.partition("=")
        if name in OPTIONS:
            current = [value] if equals else []
            given.setdefault(OPTIONS[name], []).append(current)
        elif word.startswith("-"):
            current = None
        elif current is not None:
            current.append(word)
    for option, groups in given.items():
        lost, kept = [word for group in groups[:-1] for word in group], groups[-1]
        if lost:
            raise ConfigError(
                f"{option} is given {len(groups)} times, and Snakemake takes only the last, {' '.join(kept)}: "
                f"{' '.join(lost)} would be left out; write {option} {' '.join([*lost, *kept])}"
            )
