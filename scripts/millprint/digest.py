"""A digest of the library files that a script uses, so that an edit reruns only the rules that depend on it."""

import hashlib
import re
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent
# Files that a module reads from its own folder: parts of pages, and lists.
TEMPLATES = (".html", ".css", ".js", ".yaml")


@cache
def _module_files(module: str) -> list[Path]:
    """The file of `millprint.a.b` and those of the packages that contain it; empty if there is no such module."""
    parts = module.split(".")[1:]
    files = [PACKAGE.joinpath(*parts[:depth], "__init__.py") for depth in range(len(parts) + 1)]
    if parts:
        files.append(PACKAGE.joinpath(*parts[:-1], parts[-1] + ".py"))
    return [file for file in files if file.is_file()]


# An import anywhere in a file. A docstring that looks like an import only adds a dependency.
IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+(millprint[\w.]*)[ \t]+import[ \t]+(\([^)]*\)|.+)|import[ \t]+(millprint[\w.]*))", re.M
)


@cache
def _imports(file: Path) -> frozenset[Path]:
    """The millprint files that `file` imports, also inside functions."""
    found: set[Path] = set()
    for package, names, module in IMPORT.findall(file.read_text()):
        modules = [module] if module else [package, *(f"{package}.{name}" for name in re.findall(r"\w+", names))]
        for name in modules:
            found.update(_module_files(name))
    return frozenset(found)


def library_files(script: str | Path) -> list[Path]:
    """Every library file that `script` imports, directly or indirectly, with their templates, sorted."""
    seen: set[Path] = set()
    waiting = list(_imports(Path(script).resolve()))
    while waiting:
        file = waiting.pop()
        if file not in seen:
            seen.add(file)
            waiting.extend(_imports(file))
    folders = {file.parent for file in seen}
    return sorted(seen | {file for folder in folders for file in folder.iterdir() if file.suffix in TEMPLATES})


@cache
def library_digest(script: str | Path) -> str:
    """A short hash of the contents of `library_files(script)`."""
    total = hashlib.sha256()
    for file in library_files(script):
        total.update(file.relative_to(PACKAGE).as_posix().encode())
        total.update(file.read_bytes())
    return total.hexdigest()[:16]
