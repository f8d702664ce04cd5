"""Reads YAML into models, and turns every fault into one line."""

import difflib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from millprint.config.errors import ConfigError
from millprint.config.section import PLAIN_VALUE, TRUTH, NamedSection, kind_of, nested_models
from millprint.config.sources import WORKING_FOLDER, Sources
from millprint.config.strict_yaml import read_yaml
from millprint.config.wording import close_to, in_words, unit_of

# Faults that are shown: a list of a wrong type has one for each of its items.
MOST_FAULTS = 20
# The value of a key that is missing.
NOT_THERE = object()

Model = TypeVar("Model", bound=BaseModel)
Named = TypeVar("Named", bound=NamedSection)


def _follow(model: type[BaseModel], place: tuple) -> tuple[type[BaseModel] | None, tuple]:
    """The model at `place` (the path of a fault), None if it is not one, and the path as the YAML file has it.

    Where a section is one of several kinds, or stands in place of a plain value, the path of a fault also names the
    kind, which the file does not.
    """
    current: type[BaseModel] | None = model
    choices: list[type[BaseModel]] = []
    kept = []
    for step in place:
        if step == PLAIN_VALUE:
            current, choices = None, []
            continue
        if step in map(kind_of, choices):
            current = next(item for item in choices if kind_of(item) == step)
            choices = []
            continue
        kept.append(step)
        if isinstance(step, int):
            continue
        fields = current.model_fields.items() if current else ()
        field = next((f for name, f in fields if step in (name, f.alias)), None)
        choices = nested_models(field.annotation) if field else []
        current = choices[0] if len(choices) == 1 else None
    return current, tuple(kept)


def _known_keys(model: type[BaseModel] | None) -> list[str]:
    return [field.alias or name for name, field in model.model_fields.items()] if model else []


def _where_it_belongs(model: type[BaseModel], place: tuple) -> str:
    """A hint if an unknown key belongs to an enclosing section; empty otherwise."""
    for depth in reversed(range(len(place) - 1)):
        section, outer = _follow(model, place[:depth])
        if place[-1] in _known_keys(section):
            return f"; it belongs {'into ' + '.'.join(map(str, outer)) if outer else 'to the top level'}"
    return ""


def file_of_key(files: Sequence[str], place: tuple, value: Any = NOT_THERE) -> str:
    """The last of some YAML files, each merged over the one before, that sets the longest part of a key's path.

    value: of the key; a file with another one is not its place, since --config says something else. A fault of the
    whole has an empty path; it is reported for the last file.
    """
    if not place and files:
        return files[-1]
    best, depth = "--config", 0
    for file in files:
        content: Any = read_yaml(file)
        reached = 0
        with suppress(KeyError, IndexError, TypeError):
            for step in place:
                content = content[step]
                reached += 1
        replaced = value is not NOT_THERE and reached == len(place) and content != value
        if reached and reached >= depth and not replaced:
            best, depth = file, reached
    return best


def _line(source: str | Sequence[str], model: type[BaseModel], error: ErrorDetails, missing: Sequence[tuple]) -> str:
    """A fault in words; missing: the paths of all keys that are not there."""
    if error["type"] == TRUTH:
        error = {**error, "loc": (*error["loc"], error["ctx"]["key"]), "input": error["ctx"]["value"]}
    if error["type"] in ("union_tag_invalid", "union_tag_not_found"):
        kind = error["ctx"]["discriminator"].strip("'")
        error = {**error, "loc": (*error["loc"], kind), "input": error["input"].get(kind)}
    section, _ = _follow(model, error["loc"][:-1])
    _, place = _follow(model, error["loc"])
    absent = error["type"] in ("missing", "union_tag_not_found")
    if not isinstance(source, str):
        source = file_of_key(source, place, NOT_THERE if absent else error["input"])
    key = ".".join(str(step) for step in place)
    last = next((step for step in reversed(place) if isinstance(step, str)), key)
    begin = f"{source}: {key}" if key else source
    if error["type"] == "union_tag_not_found":
        return f"{begin}: this key is missing"
    if error["type"] == "union_tag_invalid":
        known = error["ctx"]["expected_tags"].replace("'", "").split(", ")
        return f"{begin} = {error['input']!r}: unknown{close_to(str(error['input']), known)}"
    if error["type"] == "extra_forbidden":
        beside = [str(other[-1]) for other in missing if other[:-1] == place[:-1]]
        hint = _nearest(last, beside, _known_keys(section)) or _where_it_belongs(model, error["loc"])
        return f"{begin} = {error['input']!r}: unknown key{hint}"
    if absent:
        return f"{begin}: this key is missing"
    if error["type"] == "value_error":
        return f"{begin}: {error['msg'].removeprefix('Value error, ')}"
    words = in_words(error, last)
    if error["type"] == "model_type":
        words += _nearest(last, [], [other for other in _known_keys(section) if other != last])
    return f"{begin} = {error['input']!r}: {words}"


def _nearest(key: str, missing: Sequence[str], known: Sequence[str]) -> str:
    """A hint to the key that was meant: the only one that is missing, or one of a similar name; empty otherwise."""
    # A key without its unit, such as speed, is nearer to speed_rpm than to seeds.
    close: Sequence[str] = [name for name in known if name.startswith(f"{key}_")]
    close = close or (missing if len(missing) == 1 else difflib.get_close_matches(key, known, n=1))
    if not close:
        return ""
    unit, hint = unit_of(close[0]), f"; did you mean {close[0]}?"
    if "diameter" in key and "radius" in close[0]:
        hint += " It is half of the diameter"
    return hint + (f" Its value is in {unit}" if unit and unit != unit_of(key) else "")


def _told(errors: Sequence[ErrorDetails], source: str | Sequence[str], model: type[BaseModel]) -> list[str]:
    """A line for each fault. A key that an unknown one means is not also told to be missing."""
    missing = [_follow(model, error["loc"])[1] for error in errors if error["type"] == "missing"]
    lines = [_line(source, model, error, missing) for error in errors]
    meant = [line.partition("; did you mean ")[2].partition("?")[0] for line in lines]
    return [
        line
        for line, error in zip(lines, errors, strict=True)
        if error["type"] != "missing" or error["loc"][-1] not in meant
    ]


def check_model(content: object, model: type[Model], source: str | Sequence[str]) -> Model:
    """Validate a mapping read from `source`, or from several files merged over each other.

    Raises ConfigError with a line for each fault.
    """
    if not isinstance(content, dict):
        what = "is empty" if content is None else f"is a {type(content).__name__}"
        raise ConfigError(f"{source}: must be a mapping, with lines `key: value`; it {what}")
    try:
        return model.model_validate(content)
    except ValidationError as error:
        faults = error.errors()
        lines = _told(faults[:MOST_FAULTS], source, model)
        if len(faults) > MOST_FAULTS:
            lines.append(f"... and {len(faults) - MOST_FAULTS} more")
        raise ConfigError("\n".join(lines)) from None


def read_part(path: str | Path, section: str, model: type[Model], whole: type[BaseModel] | None = None) -> Model:
    """Read a model from a YAML file of its own, or from the `section` of a configuration, whose other keys it leaves.

    A file of its own may hold the further keys of a `whole` that the model is a part of. Raises ConfigError as
    `check_model`.
    """
    content = read_yaml(path)
    if isinstance(content, dict) and section in content:
        inner = content[section]
        if not isinstance(inner, dict):
            raise ConfigError(f"{path}: {section}: must be a section with the keys {', '.join(model.model_fields)}")
        content = {key: value for key, value in inner.items() if key in model.model_fields}
    elif isinstance(content, dict) and whole is not None:
        beside = set(whole.model_fields) - set(model.model_fields)
        content = {key: value for key, value in content.items() if key not in beside}
    return check_model(content, model, str(path))


def check_names_differ(folder: str | Path, names: Sequence[str], what: str) -> None:
    """Raise ConfigError where another file of a folder has one of the `names`: a copy with its key `name` unchanged."""
    for path in sorted(Path(folder).glob("*.y*ml")):
        content = None
        # A file that no run uses may have faults.
        if path.name not in {f"{name}.yaml" for name in names}:
            with suppress(ConfigError):
                content = read_yaml(path)
        name = content.get("name") if isinstance(content, dict) else None
        if isinstance(name, str) and name in names:
            raise ConfigError(
                f"{path}: name = {name!r}: also the name of {Path(folder) / name}.yaml; give this {what} the name of "
                f"its file, {path.stem!r}"
            )


def load_named(
    folder: str | Path, name: str, model: type[Named], what: str, sources: Sources = WORKING_FOLDER
) -> Named:
    """Load `folder/name.yaml`; raises ConfigError for an unknown name or a file whose key `name` differs from it."""
    path = sources.find(f"{folder}/{name}.yaml")
    if not Path(path).is_file():
        for other in Path(folder).glob("*.[yY]*ml"):
            if other.stem.lower() == name:
                raise ConfigError(f"{other}: the file of the {what} {name!r} must be called {name}.yaml; rename it")
        raise ConfigError(f"{path}: unknown {what} {name!r}{close_to(name, sources.names(folder))}")
    loaded = check_model(read_yaml(path), model, path)
    if loaded.name != name:
        raise ConfigError(f"{path}: name = {loaded.name!r}: must equal the file's name, {name!r}")
    return loaded
