"""Reads YAML into models, and turns every fault into one line.

YAML for configuration: plain data, no key twice, a bounded number of aliases and levels.

What YAML 1.1 and 1.2 read differently, as 30:1, 070 and yes, is refused: Snakemake reads `--configfile` by YAML 1.1.

The files that a configuration names: where they are searched, and a check that they stay inside the project.
"""

import difflib
import re
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from millprint.config.errors import ConfigError
from millprint.config.section import PLAIN_VALUE, TRUTH, InProject, NamedSection, Section, kind_of, nested_models
from millprint.config.wording import close_to, in_words, number_meant, unit_of

# Far above any configuration: config/config.yaml has 20 kB, 1500 values and 7 levels.
LARGEST_BYTES = 4_000_000
MOST_VALUES = 200_000
DEEPEST = 60

YAML = (".yaml", ".yml")

# What the loader raises: its own errors, and others for a wrong text after a tag such as !!int.
LOADER_ERRORS = (yaml.YAMLError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError, RecursionError)

try:
    from yaml import CSafeLoader as _Parser
except ImportError:
    from yaml import SafeLoader as _Parser


class _StrictLoader(_Parser):
    """The safe loader, which refuses a key that is given twice: otherwise the first one is silently lost."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        seen = set()
        for key_node, _ in node.value:
            if key_node.tag == "tag:yaml.org,2002:merge":
                continue
            key = self.construct_object(key_node, deep=True)
            if isinstance(key, Hashable):
                if key in seen:
                    raise yaml.constructor.ConstructorError(None, None, f"key {key!r} twice", key_node.start_mark)
                seen.add(key)
        return super().construct_mapping(node, deep)

    def construct_plain(self, node: yaml.ScalarNode) -> object:
        """A number or a truth value, if every version of YAML reads the same."""
        read, kind = _Parser.yaml_constructors[node.tag](self, node), node.tag.rpartition(":")[2]
        if node.value and not re.fullmatch(ONE_READING[kind], node.value, re.IGNORECASE):
            meant = number_meant(node.value)
            write = f"write {meant}" if meant else WRITE[kind]
            raise _TwoReadings(f"{node.value} would be read as {read!r}; {write}", node.start_mark.line)
        return read


class _TwoReadings(Exception):
    """A value that YAML 1.1 reads as another one than YAML 1.2, and the number of its line, from 0."""


# Not a number of base 8 or 60, as 070 and 1:30, nor with underscores; not yes, no, on, off; not a date.
ONE_READING = {
    "int": r"[-+]?(0|[1-9]\d*)|0x[0-9a-f]+",
    "float": r"[-+]?(\.\d+|\d+\.\d*)(e[-+]\d+)?|[-+]?\.inf|\.nan",
    "bool": "true|false",
    "timestamp": "",
}
PLAIN_NUMBER = "write a plain number, such as 30 or 0.5, or a text in quotes"
PLAIN_TRUTH = "write true or false, or a text in quotes"
WRITE = {"int": PLAIN_NUMBER, "float": PLAIN_NUMBER, "bool": PLAIN_TRUTH, "timestamp": "write it in quotes"}
for _kind in ONE_READING:
    _StrictLoader.add_constructor(f"tag:yaml.org,2002:{_kind}", _StrictLoader.construct_plain)


def read_yaml(path: str | Path) -> object:
    """Read a YAML file as plain data. Raises ConfigError, in one line, with the position of the fault."""
    try:
        if Path(path).stat().st_size > LARGEST_BYTES:
            raise ConfigError(f"{path}: larger than {LARGEST_BYTES / 1e6:g} MB, which no configuration is")
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    return parse_yaml(decoded(content, path), path)


def decoded(content: bytes, path: str | Path) -> str:
    """The text of a file in UTF-8. Raises ConfigError, in one line, for another encoding and for what is not a text."""
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ConfigError(f"{path}: is in UTF-16; save it as UTF-8")
    if found := re.search(rb"[\x00-\x08\x0e-\x1f]", content):
        raise ConfigError(f"{path}: is not a text file (byte {found[0][0]} at {found.start()})")
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        letter = content[error.start : error.start + 1].decode("cp1252", errors="replace")
        raise ConfigError(
            f"{path}: line {line}: is not in UTF-8; in Windows-1252 it has {letter!r} there: save it as UTF-8"
        ) from None


def parse_yaml(text: str, path: str | Path) -> object:
    """Plain data from a text in YAML; path: where it is from. Raises ConfigError as `read_yaml`."""
    try:
        _check_depth(text, path)
        _check_commas(text, path)
        content = yaml.load(text, Loader=_StrictLoader)
    except _TwoReadings as error:
        what, number = error.args
        line = text.split("\n")[number].partition(" #")[0].strip()
        raise ConfigError(f"{path}: line {number + 1}: {line}: {what}") from None
    except LOADER_ERRORS as error:
        raise ConfigError(f"{path}: {_in_words(error, text)}") from None
    _check_size(content, path)
    return content


# The first that is found in the lines of a fault tells its cause.
CAUSES = {
    r"^[ ]*\t|^\t": "a tab; indent with blanks",
    "\u00a0": "a blank that does not break (no. 160), as of a web page; write a usual one",
    r"^\s*<": "HTML: a page of the web was saved, not the file",
    r"^\s*[\w.]+:[^\s]": "a colon without a blank; write `key: value`",
    r"^\s*[\w.]+\s*=": "an equals sign; write `key: value`",
    r"^[^{]*:[^{]*: ": "a second colon; put the value in quotes",
}


def _in_words(error: Exception, text: str) -> str:
    """What the loader refuses: its line, the cause where that is plain, otherwise what the loader says."""
    lines = [line.partition(" #")[0] for line in text.split("\n")]
    marks = [getattr(error, name, None) for name in ("problem_mark", "context_mark")]
    problem = getattr(error, "problem", None) or " ".join(str(error).split()) or type(error).__name__
    if marks[0] is None:
        return f"not valid YAML ({problem})"
    # The end of a file without its last line break is a line further than its lines.
    at, begin = (min((mark or marks[0]).line, len(lines) - 1) for mark in marks)
    # A key that is given twice, and a tag, are not faults of the form.
    causes = {} if isinstance(error, yaml.constructor.ConstructorError) else CAUSES
    # The parser stops at the line of a fault, or at the first one after it that has no place there.
    for number in (at, max(at - 1, 0), begin):
        cause = next((cause for shape, cause in causes.items() if re.search(shape, lines[number])), None)
        if cause:
            return f"line {number + 1}: {lines[number].strip()!r}: {cause}"
    words = f"{problem}; each key of a section begins in the same column" if "expected key" in problem else problem
    return f"line {at + 1}: {lines[at].strip()!r}: not valid YAML ({words})"


def _check_commas(text: str, path: str | Path) -> None:
    """Refuse numbers with decimal commas in brackets or braces, which YAML reads as two whole numbers each."""
    for number, line in enumerate(text.split("\n"), start=1):
        text_of = line.partition(" #")[0]
        found = re.search(r"\[ *-?\d+,\d+(, +-?\d+,\d+)+ *\]", text_of)
        if found := found or re.search(r"(?<=: )-?\d+,\d+(?= *[,}])", text_of if "{" in text_of else ""):
            meant = re.sub(r"(\d),(\d)", r"\1.\2", found[0])
            raise ConfigError(f"{path}: line {number}: {line.strip()}: has decimal commas; write {meant}")


def _check_depth(text: str, path: str | Path) -> None:
    depth = 0
    for event in yaml.parse(text, Loader=_Parser):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > DEEPEST:
            line = event.start_mark.line + 1
            raise ConfigError(f"{path}: line {line}: nested more than {DEEPEST} levels deep")


def _check_size(content: object, path: str | Path) -> None:
    """Refuse aliases (&a, *a) that multiply the content without bound, or contain themselves."""
    sizes: dict[int, int] = {}
    pending: set[int] = set()

    def size(value: object) -> int:
        if not isinstance(value, dict | list | tuple | set):
            return 1
        if id(value) in pending:
            raise ConfigError(f"{path}: an alias (*name) stands inside what it repeats")
        if id(value) not in sizes:
            pending.add(id(value))
            inner = [*value.keys(), *value.values()] if isinstance(value, dict) else value
            sizes[id(value)] = 1 + sum(map(size, inner))
            pending.discard(id(value))
        return sizes[id(value)]

    if size(content) > MOST_VALUES:
        raise ConfigError(f"{path}: its aliases (*name) make more than {MOST_VALUES} values")


Kept = TypeVar("Kept", bound=Section)

# Of the project: a file for each mill and for each contact set.
MILL_FOLDER, CONTACT_FOLDER = "config/mills", "config/contacts"

PACKAGE = Path(__file__).parents[1]
# setup.py copies folders of the project there; a checkout has them once, at its root.
COPY = PACKAGE / "included"


def shipped(path: str) -> str | None:
    """The location of a file or folder of this project, by its path from the project's root; None if it is not there.

    An installed library has the folders that setup.py copies.
    """
    place = (COPY if COPY.is_dir() else PACKAGE.parents[1]) / path
    return str(place) if place.exists() else None


@dataclass(frozen=True)
class Sources:
    """Finds files by their path from the project's root, such as config/mills/emax.yaml.

    shipped: the location of the workflow's own file of that path, None if it has none. So mills, contact sets
    and tables of the workflow serve a run in any folder, and a user's file takes precedence.
    """

    shipped: Callable[[str], str | None] = lambda path: None

    def find(self, path: str) -> str:
        """The path itself, or that of the workflow's file if the working folder has no such file."""
        return path if Path(path).exists() else self.shipped(path) or path

    def names(self, folder: str | Path) -> list[str]:
        """Names of the YAML files of a folder, the user's and the workflow's."""
        folders = [folder, self.shipped(str(folder))]
        return sorted({file.stem for place in folders if place for file in Path(place).glob("*.yaml")})

    def resolve(self, section: Kept) -> Kept:
        """The section with the location of every file that it names; see `find`."""
        changes: dict = {}
        for name, field in type(section).model_fields.items():
            value = getattr(section, name)
            if isinstance(value, str) and is_marked(field):
                changes[name] = self.find(value)
            elif isinstance(value, Section):
                changes[name] = self.resolve(value)
            elif isinstance(value, list):
                changes[name] = [self.resolve(item) if isinstance(item, Section) else item for item in value]
        changed = {name: value for name, value in changes.items() if value != getattr(section, name)}
        return section.model_copy(update=changed) if changed else section


# Only the files of the working folder.
WORKING_FOLDER = Sources()


def is_marked(field: FieldInfo) -> bool:
    """Whether a field holds the path of a file inside the project."""
    marks = [*field.metadata, *(mark for item in get_args(field.annotation) for mark in get_args(item))]
    return any(isinstance(mark, InProject) for mark in marks)


def named_files(section: Section, place: str = "") -> Iterator[tuple[str, str]]:
    """Dotted key and value of every path in a section and in those nested in it."""
    for name, field in type(section).model_fields.items():
        value, key = getattr(section, name), f"{place}.{name}".lstrip(".")
        if isinstance(value, str) and is_marked(field):
            yield key, value
        for index, item in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(item, Section):
                yield from named_files(item, f"{key}.{index}" if isinstance(value, list) else key)


def check_paths(section: Section, source: str) -> None:
    """Raise ConfigError for the first text that is not a path inside the working directory."""
    root = Path.cwd().resolve()
    for key, value in named_files(section):
        try:
            inside = bool(value.strip()) and (root / value).resolve().is_relative_to(root) and Path(value).parts != ()
        except (OSError, ValueError):
            inside = False
        if not inside:
            raise ConfigError(f"{source}: {key} = {value!r}: must be the path of a file inside the project")


# How alike a key is to the one that it is a slip of.
SAME_WORD = 0.85
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
        field = current.model_fields.get(step) if current else None
        choices = nested_models(field.annotation) if field else []
        current = choices[0] if len(choices) == 1 else None
    return current, tuple(kept)


def _known_keys(model: type[BaseModel] | None) -> list[str]:
    return list(model.model_fields) if model else []


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
    # What differs by a letter or two is meant before the only key that is missing.
    close = close or difflib.get_close_matches(key, known, n=1, cutoff=SAME_WORD)
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


def check_at(content: object, model: type[BaseModel], source: str, place: tuple) -> None:
    """Raise ConfigError with the first fault of the value at a path of keys, whatever else is wrong."""
    try:
        model.model_validate(content)
    except ValidationError as error:
        for fault in error.errors():
            if _follow(model, fault["loc"])[1][: len(place)] == place:
                raise ConfigError(_line(source, model, fault, [])) from None


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
