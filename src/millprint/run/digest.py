"""A digest of what a script computes: a change of the code reruns the jobs of the script, a comment does not.

The digest covers the syntax tree (`ast`) of the script and of every millprint module that it imports, directly or
indirectly, without comments, docstrings, lines for the log, progress bars and texts of errors. A module may be renamed
or moved. Other files in the folders of these modules, such as parts of pages, count with their content.

Parsing all files takes half of a dry run. So what a file computes is remembered on disk by the digest of its bytes.
"""

import ast
import atexit
import hashlib
import json
import os
import re
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

from millprint.run.machine import CACHE_ROOT

PACKAGE = Path(__file__).parents[1]
TEMPLATES = (".html", ".css", ".js", ".yaml")

# A simulation begins in SIMULATION. OUTSIDE are modules that it imports and that do not affect its numbers: files and
# messages, and settings that it gets by value. If a change there does affect numbers, raise millprint.dem.PHYSICS.
SIMULATION = "dem/run.py"
OUTSIDE = {
    *(f"run/{name}.py" for name in ("digest", "files", "hdf5", "machine", "progress")),
    *("config/errors.py", "config/fingerprint.py", "config/mill_sweep.py", "config/section.py"),
}

# An import anywhere in a file. A docstring that looks like an import only adds a dependency.
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(millprint[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|.+)|import[ \t]+(millprint[\w.]*))", re.M
)


@cache
def program_digest(script: str | Path) -> str:
    """The digest of a script of scripts/ and of what it imports from millprint."""
    return _digest_of([Path(script)], _imports(Path(script)), set())


@cache
def simulation_digest() -> str:
    """The digest of the code that decides the numbers of a simulation; its configuration is not included."""
    return _digest_of([], {SIMULATION}, OUTSIDE)


def _digest_of(files: list[Path], modules: set[str] | frozenset[str], outside: set[str]) -> str:
    """The digest of files, and of modules with all their imports except `outside`; both by paths in the package."""
    seen: set[str] = set()
    waiting = set(modules)
    while waiting := waiting - seen - outside:
        seen |= waiting
        waiting = {name for module in waiting for name in _imports(PACKAGE / module)}
    for folder in {os.path.dirname(module) for module in seen}:
        seen.update(os.path.join(folder, name) for name in os.listdir(PACKAGE / folder) if name.endswith(TEMPLATES))
    contents = [content_digest(file) for file in [*files, *(PACKAGE / name for name in seen)]]
    return hashlib.sha256(b"".join(sorted(contents))).hexdigest()[:16]


@cache
def _imports(file: Path) -> frozenset[str]:
    """The millprint files that a Python file imports, also inside functions, with the packages that contain them."""
    modules: set[str] = set()
    for package, names, module in IMPORT.findall(file.read_text()):
        modules |= {module} if module else {package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))}
    parts = {tuple(name.split(".")[1:]) for name in modules}
    folders = {part[:depth] for part in parts for depth in range(len(part) + 1)}
    found = {"/".join([*part, "__init__.py"]) for part in folders} | {"/".join(part) + ".py" for part in parts if part}
    return frozenset(name for name in found if (PACKAGE / name).is_file())


@cache
def content_digest(file: Path, without: str = "/") -> bytes:
    """The digest of a file; for a Python file, of what it computes, wherever it is and whatever its modules are called.

    An import counts with its names and with the content of their module, unless that lies in the folder `without`.
    """
    if file.suffix != ".py":
        return hashlib.sha256(file.read_bytes()).digest()
    computed, imports = _parsed(file)
    origins = sorted(dump + _origin(module, name, without) for module, name, dump in imports)
    return hashlib.sha256("".join([computed, *origins]).encode()).digest()


# What a file computes, as a digest, and its imports from millprint: module, name, and the syntax tree of the name.
Parsed = tuple[str, list[tuple[str, str, str]]]


@cache
def _parsed(file: Path) -> Parsed:
    """The digest of the syntax tree of a file without texts and without imports from millprint, and these imports."""
    content = file.read_bytes()
    key = hashlib.sha256(content).hexdigest()
    if key not in _remembered():
        tree = ast.parse(content)
        found = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and _is_own_import(node)]
        imports = [(node.module or "", alias.name, ast.dump(alias)) for node in found for alias in node.names]
        _drop_texts(tree)
        if not _new:
            atexit.register(remember)
        _new[key] = hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports
        _remembered()[key] = _new[key]
    return _remembered()[key]


# Another Python writes another tree, and another version of this file another digest of it.
MEMORY = (
    CACHE_ROOT / f"parsed-{hashlib.sha256(sys.version.encode() + Path(__file__).read_bytes()).hexdigest()[:16]}.json"
)
# Files in all their versions that are kept, of which the library has 350.
KEPT = 3000
_new: dict[str, Parsed] = {}


@cache
def _remembered() -> dict[str, Parsed]:
    """What earlier processes have parsed, by the digest of a file's bytes."""
    try:
        return json.loads(MEMORY.read_text())
    except (OSError, ValueError):
        return {}


def remember() -> None:
    """Write what this process has parsed, for the next ones; where nothing can be written, they parse again."""
    with suppress(OSError):
        MEMORY.parent.mkdir(parents=True, exist_ok=True)
        draft = MEMORY.with_suffix(f".{os.getpid()}")
        draft.write_text(json.dumps(dict([*_remembered().items()][-KEPT:])))
        draft.replace(MEMORY)


@cache
def _origin(module: str, name: str, without: str) -> str:
    """What the module computes that an import takes a name from; nothing for one that no number comes from."""
    module = "/".join(module.split(".")[1:])
    for path in (f"{module}/{name}.py".lstrip("/"), f"{module}.py", f"{module}/__init__.py".lstrip("/")):
        if (PACKAGE / path).is_file():
            return "" if path in OUTSIDE or path.startswith(without) else _parsed(PACKAGE / path)[0]
    return ""


def _is_own_import(node: ast.AST) -> bool:
    return isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "millprint"


def _drop_texts(node: ast.AST) -> None:
    """Remove statements that do not change results from a block of code and the blocks in it."""
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        block = [each for each in getattr(node, name, []) if not _is_text(each)]
        for each in block:
            _drop_texts(each)
        if block or hasattr(node, name):
            setattr(node, name, block)
    if isinstance(node, ast.With):
        node.items = [each for each in node.items if not _calls(each.context_expr, "progress")]
    if isinstance(node, ast.Raise):
        for part in ast.walk(node):
            if isinstance(part, ast.Call):
                part.args = [each for each in part.args if not _is_string(each)]


def _is_text(statement: ast.AST) -> bool:
    """Whether a statement is a docstring, writes to the log or imports from millprint."""
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) or _calls(value, "logger") or _is_own_import(statement)


def _is_string(value: ast.expr) -> bool:
    return isinstance(value, ast.JoinedStr) or (isinstance(value, ast.Constant) and isinstance(value.value, str))


def _calls(value: ast.AST | None, name: str) -> bool:
    """Whether an expression is a call of `name` or of a method of it."""
    if not isinstance(value, ast.Call):
        return False
    called = value.func.value if isinstance(value.func, ast.Attribute) else value.func
    return isinstance(called, ast.Name) and called.id == name
