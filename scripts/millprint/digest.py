"""A digest of the library files that a script uses, so that an edit reruns only the rules that depend on it.

The Snakefile asks for that of every script, so each file is looked up, read and searched for imports once.
"""

import hashlib
import os
import re
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent
# Files that a module reads from its own folder: parts of pages, and lists.
TEMPLATES = (".html", ".css", ".js", ".yaml")

# An import anywhere in a file. A docstring that looks like an import only adds a dependency.
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(millprint[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|.+)|import[ \t]+(millprint[\w.]*))", re.M
)


@cache
def _folders() -> dict[str, frozenset[str]]:
    """The names of the files in each folder of the package, by its path from there; the package itself is "."."""
    return {os.path.relpath(folder, PACKAGE): frozenset(files) for folder, _, files in os.walk(PACKAGE)}


@cache
def _module_files(module: str) -> list[str]:
    """The file of `millprint.a.b` and those of the packages that contain it; empty if there is no such module."""
    parts = module.split(".")[1:]
    files = ["/".join([*parts[:depth], "__init__.py"]) for depth in range(len(parts) + 1)]
    if parts:
        files.append("/".join(parts) + ".py")
    return [file for file in files if os.path.basename(file) in _folders().get(os.path.dirname(file) or ".", ())]


@cache
def _content(file: str) -> bytes:
    return (PACKAGE / file).read_bytes()


def _imports(text: str) -> frozenset[str]:
    """The millprint files that a Python file imports, also inside functions."""
    found: set[str] = set()
    for package, names, module in IMPORT.findall(text):
        modules = [module] if module else [package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))]
        for name in modules:
            found.update(_module_files(name))
    return frozenset(found)


@cache
def _imports_of(file: str) -> frozenset[str]:
    return _imports(_content(file).decode())


def _used(script: str | Path) -> list[str]:
    """`library_files` by their paths from the package, sorted by folder and name."""
    seen: set[str] = set()
    waiting = list(_imports(Path(script).read_text()))
    while waiting:
        file = waiting.pop()
        if file not in seen:
            seen.add(file)
            waiting.extend(_imports_of(file))
    for folder in {os.path.dirname(file) for file in seen}:
        names = _folders()[folder or "."]
        seen.update(os.path.join(folder, name) for name in names if name.endswith(TEMPLATES))
    return sorted(seen, key=lambda file: file.split("/"))


def library_files(script: str | Path) -> list[Path]:
    """Every library file that `script` imports, directly or indirectly, with their templates, sorted."""
    return [PACKAGE / file for file in _used(script)]


@cache
def library_digest(script: str | Path) -> str:
    """A short hash of the contents of `library_files(script)`."""
    total = hashlib.sha256()
    for file in _used(script):
        total.update(file.encode())
        total.update(_content(file))
    return total.hexdigest()[:16]
