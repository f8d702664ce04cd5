"""YAML for configuration: plain data, no key twice, a bounded number of aliases and levels.

What YAML 1.1 and 1.2 read differently, as 30:1, 070 and yes, is refused: Snakemake reads `--configfile` by YAML 1.1.
"""

import re
from collections.abc import Hashable
from pathlib import Path

import yaml

from millprint.config.errors import ConfigError
from millprint.config.wording import number_meant

# Far above any configuration: config/config.yaml has 20 kB, 1500 values and 7 levels.
LARGEST_BYTES = 4_000_000
MOST_VALUES = 200_000
DEEPEST = 60

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
    """Refuse a list of numbers with decimal commas, which YAML reads as twice as many whole numbers."""
    for number, line in enumerate(text.split("\n"), start=1):
        if found := re.search(r"\[ *-?\d+,\d+(, +-?\d+,\d+)+ *\]", line.partition(" #")[0]):
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
