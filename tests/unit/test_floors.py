"""Imports of the library point down: whatever runs a mill never needs the thesis."""

import ast
from collections import Counter
from pathlib import Path

import pytest

from tests.conftest import ROOT

PACKAGE = ROOT / "src/millprint"
# Rooms that others stand on, and what each may import besides itself.
BELOW = {
    "observables": set(),
    "config": {"observables"},
    "estimate": set(),
    "run": {"config"},
    "mill": {"config", "run"},
    "dem": {"observables", "config", "run", "estimate", "mill"},
    "cases": {"config", "run", "mill", "dem"},
    "fingerprint": {"observables", "config", "run", "estimate", "mill", "dem", "cases"},
}


def imported_by(path: Path) -> set[str]:
    """The modules of the package that a file imports, anywhere in it."""
    tree = ast.parse(path.read_text())
    named = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    plain = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    names = {name for node in named for name in (node.module, *(f"{node.module}.{each.name}" for each in node.names))}
    return {name for name in names.union(plain) if name.startswith("millprint.")}


def files_of(room: str) -> list[Path]:
    return [PACKAGE / f"{room}.py"] if (PACKAGE / f"{room}.py").exists() else sorted((PACKAGE / room).rglob("*.py"))


@pytest.mark.slow
def test_nothing_of_the_mill_imports_the_thesis():
    others = [path for path in PACKAGE.rglob("*.py") if "thesis" not in path.relative_to(PACKAGE).parts]
    assert len(others) > 150
    assert not [path for path in others if any(name.startswith("millprint.thesis") for name in imported_by(path))]


@pytest.mark.slow
@pytest.mark.parametrize("room", BELOW)
def test_imports_point_down(room):
    found = {name.split(".")[1] for path in files_of(room) for name in imported_by(path)}
    rooms = {path.stem for path in PACKAGE.iterdir() if path.suffix in ("", ".py")}
    assert found & rooms - {room} <= BELOW[room]


def test_no_file_name_occurs_twice():
    """A traceback or an editor's tab shows the name of a file, and it says which file."""
    names = Counter(path.name for path in PACKAGE.rglob("*.py") if path.name != "__init__.py")
    assert not [name for name, count in names.items() if count > 1]


def assigned_in(path: Path) -> list[str]:
    """The names that a module assigns at its top level, one for each time; those of ifs and loops are not counted."""
    lines = [line for line in ast.parse(path.read_text()).body if isinstance(line, ast.Assign | ast.AnnAssign)]
    targets = [each for line in lines for each in (line.targets if isinstance(line, ast.Assign) else [line.target])]
    names = [node for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)]
    return [name.id for name in names if isinstance(name.ctx, ast.Store)]


@pytest.mark.slow
def test_a_constant_is_assigned_once():
    """The format of a file took over that of another, when two modules became one; no rule of ruff sees it."""
    folders = [ROOT / name for name in ("src", "scripts", "tools", "tests", "benchmarks")]
    paths = [path for folder in folders for path in folder.rglob("*.py")]
    twice = {str(path): [name for name, times in Counter(assigned_in(path)).items() if times > 1] for path in paths}
    assert len(paths) > 400
    assert not {path: names for path, names in twice.items() if names}


def test_modules_belong_to_a_package():
    """Only what `import millprint` offers is outside of a package."""
    assert {path.stem for path in PACKAGE.glob("*.py")} == {"__init__", "api"}
