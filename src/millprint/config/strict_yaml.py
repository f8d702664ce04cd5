"""YAML for configuration: plain data, no key twice, a bounded number of aliases and levels.

What YAML 1.1 and 1.2 read differently, as 30:1, 070 and yes, is refused: Snakemake reads `--configfile` by YAML 1.1.
"""

import re
from collections.abc import Hashable
from pathlib import Path

import yaml

from millprint.config.errors import ConfigError

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
            line = node.start_mark.line + 1
            raise _TwoReadings(f"line {line}: {node.value} would be read as {read!r}: {WRITE[kind]}")
        return read


class _TwoReadings(Exception):
    """A value that YAML 1.1 reads as another one than YAML 1.2."""


# Not a number of base 8 or 60, as 070 and 1:30, nor with underscores; not yes, no, on, off; not a date.
ONE_READING = {
    "int": r"[-+]?(0|[1-9]\d*)|0x[0-9a-f]+",
    "float": r"[-+]?(\.\d+|\d+\.\d*)(e[-+]\d+)?|[-+]?\.inf|\.nan",
    "bool": "true|false",
    "timestamp": "",
}
PLAIN_NUMBER = "write a plain number, such as 30 or 0.5, or a text in quotes"
TRUTH = "write true or false, or a text in quotes"
WRITE = {"int": PLAIN_NUMBER, "float": PLAIN_NUMBER, "bool": TRUTH, "timestamp": "write it in quotes"}
for _kind in ONE_READING:
    _StrictLoader.add_constructor(f"tag:yaml.org,2002:{_kind}", _StrictLoader.construct_plain)


def read_yaml(path: str | Path) -> object:
    """Read a YAML file as plain data. Raises ConfigError, in one line, with the position of the fault."""
    try:
        if Path(path).stat().st_size > LARGEST_BYTES:
            raise ConfigError(f"{path}: larger than {LARGEST_BYTES / 1e6:g} MB, which no configuration is")
        text = Path(path).read_text(encoding="utf-8")
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file") from None
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: not valid YAML ({error})") from None
    return parse_yaml(text, path)


def parse_yaml(text: str, path: str | Path) -> object:
    """Plain data from a text in YAML; path: where it is from. Raises ConfigError as `read_yaml`."""
    try:
        _check_depth(text, path)
        content = yaml.load(text, Loader=_StrictLoader)
    except _TwoReadings as error:
        raise ConfigError(f"{path}: {error}") from None
    except LOADER_ERRORS as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise ConfigError(f"{path}: not valid YAML ({what})") from None
    _check_size(content, path)
    return content


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
