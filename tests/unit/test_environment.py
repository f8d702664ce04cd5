"""The environment is pinned, and written once."""

import re
from pathlib import Path

from scripts.write_conda_file import conda_text

ENVIRONMENTS = Path(__file__).parents[2] / "envs"


def locked() -> dict[str, str]:
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    return dict(line.split("==") for line in lines if not line.startswith("#"))


def test_every_package_has_one_version():
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", line) for line in lines if not line.startswith("#"))


def test_what_is_needed_is_locked():
    names = {re.sub(r"[-_.]+", "-", name).lower() for name in locked()}
    needed = (ENVIRONMENTS / "requirements.in").read_text().splitlines()
    assert {line.split("==")[0].lower() for line in needed if not line.startswith("#")} <= names


def test_torch_is_the_cpu_build():
    assert locked()["torch"] == "2.13.0"


def test_conda_file_follows_the_lock_file():
    assert (ENVIRONMENTS / "millprint.yaml").read_text() == conda_text()
