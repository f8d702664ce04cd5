"""All packages are pinned, and every environment file follows from the lock file."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from tools.write_conda_file import conda_text

ENVIRONMENTS = Path(__file__).parents[2] / "envs"


def locked() -> dict[str, str]:
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def test_every_package_has_one_version():
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines if not line.startswith("#"))


def required() -> list[str]:
    """The requirements in pyproject.toml: of the library, the workflow and the developers."""
    project = tomllib.loads((ENVIRONMENTS.parent / "pyproject.toml").read_text())["project"]
    further = [name for names in project["optional-dependencies"].values() for name in names]
    return [*project["dependencies"], *further]


def test_every_required_package_is_locked_in_an_allowed_version():
    versions = {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in locked().items()}
    for requirement in map(Requirement, required()):
        assert versions[requirement.name.lower()] in requirement.specifier, requirement


def test_every_package_runs_on_the_python_of_debian_12():
    """Where the installed version is that of the lock file, its own metadata says which versions of Python it takes."""
    wanted = {name: metadata.metadata(name)["Requires-Python"] for name, version in locked().items()
              if metadata.version(name) == version}  # fmt: skip
    assert len(wanted) > 150
    assert not {name: text for name, text in wanted.items() if text and "3.11.2" not in SpecifierSet(text)}


def test_the_environment_of_jobs_has_no_snakemake_and_no_developer_tools():
    text = (ENVIRONMENTS / "millprint.yaml").read_text()
    assert "numba==" in text and "torch==" in text
    assert not re.search(r"- (snakemake|pytest|ruff|mypy|snakefmt)", text)


def test_torch_is_the_cpu_build():
    assert locked()["torch"] == "2.13.0"


def test_conda_file_follows_the_lock_file():
    assert (ENVIRONMENTS / "millprint.yaml").read_text() == conda_text()
