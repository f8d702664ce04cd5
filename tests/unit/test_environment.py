"""The environment is pinned, and written once."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from scripts.write_conda_file import conda_text

ENVIRONMENTS = Path(__file__).parents[2] / "envs"


def locked() -> dict[str, str]:
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def test_every_package_has_one_version():
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines if not line.startswith("#"))


def needed() -> list[str]:
    """What pyproject.toml asks for: by the library, by the workflow and by developers."""
    project = tomllib.loads((ENVIRONMENTS.parent / "pyproject.toml").read_text())["project"]
    further = [name for names in project["optional-dependencies"].values() for name in names]
    return [*project["dependencies"], *further]


def test_what_is_needed_is_locked_in_a_version_that_will_do():
    versions = {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in locked().items()}
    for requirement in map(Requirement, needed()):
        assert versions[requirement.name.lower()] in requirement.specifier, requirement


def test_jobs_need_neither_snakemake_nor_the_tools_of_developers():
    text = (ENVIRONMENTS / "millprint.yaml").read_text()
    assert "numba==" in text and "torch==" in text
    assert not re.search(r"- (snakemake|pytest|ruff|mypy|snakefmt)", text)


def test_torch_is_the_cpu_build():
    assert locked()["torch"] == "2.13.0"


def test_conda_file_follows_the_lock_file():
    assert (ENVIRONMENTS / "millprint.yaml").read_text() == conda_text()
