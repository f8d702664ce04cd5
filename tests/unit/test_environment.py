"""All packages are pinned, and every environment file follows from the lock file."""

import ast
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from tools.write_locks import conda_text, locked_lines

from millprint.run.extras import EXTRAS

ENVIRONMENTS = Path(__file__).parents[2] / "envs"


def locked() -> list[Requirement]:
    return [Requirement(line) for line in locked_lines()]


def version_of(requirement: Requirement) -> str:
    (exact,) = requirement.specifier
    assert exact.operator == "=="
    return exact.version


@pytest.mark.parametrize("python", ["3.11", "3.12", "3.13", "3.14"])
@pytest.mark.parametrize("platform", ["linux", "darwin", "win32"])
def test_every_package_has_one_version(python, platform):
    """On each system with each version of Python."""
    here = {"python_version": python, "python_full_version": f"{python}.5", "sys_platform": platform}
    names = [each.name for each in locked() if each.marker is None or each.marker.evaluate(here)]
    assert len(names) == len(set(names)) > 150 and all(map(version_of, locked()))


def required() -> list[str]:
    """The requirements in pyproject.toml: of the library, the workflow and the developers."""
    project = tomllib.loads((ENVIRONMENTS.parent / "pyproject.toml").read_text())["project"]
    further = [name for names in project["optional-dependencies"].values() for name in names]
    return [*project["dependencies"], *further]


def test_every_required_package_is_locked_in_an_allowed_version():
    versions = {each.name: version_of(each) for each in locked()}
    # The same package without what graphics cards need.
    versions["xgboost"] = versions.pop("xgboost-cpu")
    for requirement in map(Requirement, required()):
        assert versions[requirement.name.lower()] in requirement.specifier, requirement


# Packages whose module has another name; the module of the rest is their name.
OTHER_NAME = {"pillow": "PIL", "pyyaml": "yaml", "salib": "SALib", "scikit-learn": "sklearn"}


def imported(path: Path) -> set[str]:
    nodes = list(ast.walk(ast.parse(path.read_text())))
    plain = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    named = {node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module}
    return {name.split(".")[0] for name in plain | named} - set(sys.stdlib_module_names) - {"millprint"}


@pytest.mark.slow
def test_everything_that_is_imported_is_declared():
    """The mill imports packages of the core only; the thesis also those of its extras."""
    project = tomllib.loads((ENVIRONMENTS.parent / "pyproject.toml").read_text())["project"]
    names = [Requirement(text).name for text in project["dependencies"]]
    core = {OTHER_NAME.get(name, name) for name in names} | {"pydantic_core", "markupsafe"}
    package = ENVIRONMENTS.parent / "src/millprint"
    undeclared = {
        name
        for path in package.rglob("*.py")
        for name in imported(path) - core
        if "thesis" not in path.relative_to(package).parts or name not in EXTRAS["thesis"] + EXTRAS["surrogate"]
    }
    # They come with Snakemake, whose plugin of the log is imported by Snakemake only; types for mypy.
    assert undeclared <= {"snakemake_interface_logger_plugins", "_typeshed"}


def test_every_package_of_an_extra_is_named_where_it_is_missing():
    """The module of a package has its name, but for vtk; tools are not imported."""
    project = tomllib.loads((ENVIRONMENTS.parent / "pyproject.toml").read_text())["project"]
    for extra in ("thesis", "surrogate"):
        names = {Requirement(text).name.replace("-", "_") for text in project["optional-dependencies"][extra]}
        assert names == set(EXTRAS[extra])


@pytest.mark.slow
def test_a_missing_package_of_an_extra_is_named_in_one_line(tmp_path):
    """The environment of this test has them all, so a finder of packages hides one."""
    program = """
import sys
from importlib.machinery import PathFinder
from importlib.util import find_spec
class Without(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name == "xgboost" else super().find_spec(name, path, target)
sys.meta_path[sys.meta_path.index(PathFinder)] = Without
import millprint
assert find_spec("xgboost") is None
import millprint.thesis.yields.estimators
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        "error: no package xgboost, which belongs to the extra `thesis`: pip install 'millprint[thesis]', or "
        "pip install '.[thesis]' in a clone"
    ]


def test_conda_file_follows_the_lock_file():
    assert (ENVIRONMENTS / "millprint.yaml").read_text() == conda_text()


@pytest.mark.parametrize(("platform", "machine"), [("linux", "x86_64"), ("linux", "aarch64"), ("darwin", "arm64")])
def test_the_conda_file_has_each_package_of_the_library_once(platform, machine):
    """On its own Python; a package may have a line for each system and version of Python."""
    python, *_, packages = yaml.safe_load((ENVIRONMENTS / "millprint.yaml").read_text())["dependencies"]
    version = python.removeprefix("python=")
    here = {"python_version": version, "python_full_version": f"{version}.5"}
    here |= {"sys_platform": platform, "platform_machine": machine}
    found = [Requirement(line) for line in packages["pip"] if not line.startswith("--")]
    names = [each.name for each in found if each.marker is None or each.marker.evaluate(here)]
    assert len(names) == len(set(names))
    wanted = {Requirement(text).name.lower() for text in required()} & {each.name for each in found}
    assert {"torch", "shap", "numpy"} <= wanted <= set(names)


@pytest.mark.parametrize("lock", sorted(ENVIRONMENTS.glob("*.lock")), ids=lambda path: path.name)
def test_every_locked_package_has_the_hashes_of_its_files_and_is_installed_with_them(lock):
    entries = re.findall(r"^[\w.-]+==.*(?:\n .*)*", lock.read_text(), re.MULTILINE)
    assert entries and all(re.search(r"--hash=sha256:[0-9a-f]{64}$", entry) for entry in entries)
    makefile, image = ((ENVIRONMENTS.parent / name).read_text() for name in ("Makefile", "Dockerfile"))
    (variable,) = re.findall(rf"^(\w+) := envs/{lock.name}$", makefile, re.MULTILINE)
    lines = [*makefile.splitlines(), *image.replace("\\\n", " ").split("&&")]
    installs = [line for line in lines if re.search(rf"--requirement (\$\({variable}\)|envs/{lock.name})", line)]
    assert installs and all("--require-hashes" in line for line in installs)
