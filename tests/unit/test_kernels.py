"""The cache of machine code sees all that is compiled in, and nothing else."""

import ast
import importlib
import inspect
import shutil
from functools import cache
from pathlib import Path

import numba
import pytest

from millprint.config.charge import BallMixture
from millprint.config.sweep import balls_of
from millprint.dem import advance, compilation, simulation
from millprint.run import digest, kernel, machine

ROOT = Path(__file__).parents[2]
LIBRARY = ROOT / "src"


def module_of(file: Path) -> str:
    folder = LIBRARY if file.is_relative_to(LIBRARY) else ROOT
    return ".".join(file.relative_to(folder).with_suffix("").parts)


@cache
def sources() -> dict[Path, str]:
    """The text of every file with code that may call a kernel."""
    return {file: file.read_text() for place in ("src", "scripts", "tests") for file in (ROOT / place).rglob("*.py")}


@pytest.fixture
def library(tmp_path, monkeypatch) -> Path:
    """A copy of the library, of which the digest of the kernels is taken."""
    shutil.copytree(kernel.PACKAGE, tmp_path / "millprint", ignore=shutil.ignore_patterns("__pycache__"))
    for module in (digest, kernel):
        monkeypatch.setattr(module, "PACKAGE", tmp_path / "millprint")
    forget()
    yield tmp_path / "millprint"
    forget()


def forget() -> None:
    """What this process remembers of the files."""
    digest.content_digest.cache_clear()


def append(file: Path, text: str) -> None:
    """Add to a file whose digest this process has taken before."""
    file.write_text(file.read_text() + text)
    forget()


@pytest.mark.parametrize(
    "file", ["mill/kernel_columns.py", "dem/layout.py", "dem/law.py", "dem/state.py", "mill/motion.py", "run/kernel.py"]
)
def test_the_cache_sees_every_number_that_is_compiled_in(library, file):
    before = kernel.kernel_digest()
    append(library / file, "\nADDED = 1\n")
    assert kernel.kernel_digest() != before


@pytest.mark.parametrize(
    "file", ["dem/run.py", "config/sweep.py", "config/contact_set.py", "thesis/surrogate/network.py"]
)
def test_the_cache_stays_where_no_kernel_changes(library, file):
    before = kernel.kernel_digest()
    append(library / file, "\nADDED = 1\n")
    assert kernel.kernel_digest() == before


def test_all_that_a_kernel_file_has_from_the_library_is_seen():
    """Modules, functions, types and constants of its imports, but for settings and digests, are of files of the digest.

    The names are those of the loaded modules, and not of their text.
    """
    seen = {module_of(file) for file in kernel.kernel_files()}
    loaded = {name: vars(importlib.import_module(name)) for name in seen if not name.endswith("__init__")}
    owners = {}
    for own in loaded.values():
        for name, value in own.items():
            owner = value.__name__ if inspect.ismodule(value) else getattr(value, "__module__", None)
            owners[owner] = name
    homes = {name for name in owners if isinstance(name, str) and name.startswith("millprint.")}
    assert "millprint.dem.state" in homes
    settled = {name for name in homes if name.startswith(("millprint.config.", "millprint.run.digest"))}
    assert {name: owners[name] for name in homes - settled if name not in seen} == {}


def test_parts_that_are_compiled_ahead_are_those_that_the_loop_calls():
    """Their types are found by the names of parameters: under other names, the loop would compile them again."""
    called = {}
    for module in (advance, simulation):
        for node in ast.walk(ast.parse(inspect.getsource(module))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                given = [each.attr if isinstance(each, ast.Attribute) else ast.unparse(each) for each in node.args]
                called.setdefault(node.func.id, []).append(given)
    for part in (*compilation.FORCES, *compilation.OTHERS):
        # A time may be an expression.
        names = [name for name in inspect.signature(part.py_func).parameters if name != "time"]
        for given in called[part.__name__]:
            assert [name for name in given if name in names] == names
    # The second process says nothing where it fails.
    compilation.compile_others()


def test_balls_of_several_sizes_need_no_kernels_of_their_own():
    """A row of coefficients in another order of memory was another type: the step loop was compiled again."""
    sizes = BallMixture(name="two", sizes_mm=(3, 2), shares=(0.6, 0.4))
    mixed = compilation.TINY_CASE.model_copy(update=balls_of(sizes))
    one, several = (
        vars(simulation.Simulation(case, compilation.TINY_MILL, compilation.TINY_CONTACT, compilation.TINY_DEM))
        for case in (compilation.TINY_CASE, mixed)
    )
    for part in (*compilation.FORCES, *compilation.OTHERS):
        for name in one.keys() & inspect.signature(part.py_func).parameters:
            assert numba.typeof(one[name]) == numba.typeof(several[name]), name


def test_without_a_cache_that_can_be_written_the_working_folder_has_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "of_the_user"))
    assert machine.user_cache() == tmp_path / "of_the_user/millprint"
    monkeypatch.setattr(machine.os, "access", lambda *of: False)
    assert machine.user_cache() == tmp_path / ".snakemake/cache/millprint"
