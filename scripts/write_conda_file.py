"""Writes envs/millprint.yaml, for `snakemake --sdm conda`, from the lock file; run it by `make lock`."""

from pathlib import Path

import yaml

from millprint.files import whole_file

ENVIRONMENTS = Path(__file__).parent.parent / "envs"


def conda_text() -> str:
    """The lock file as a conda environment: Python and pip from conda-forge, every package as locked."""
    lines = (ENVIRONMENTS / "requirements.lock").read_text().splitlines()
    packages = [line for line in lines if line and not line.startswith("#")]
    content = {"channels": ["conda-forge"], "dependencies": ["python=3.11", "pip", {"pip": packages}]}
    return f"# Written from requirements.lock by `make lock`.\n{yaml.safe_dump(content, sort_keys=False)}"


if __name__ == "__main__":
    with whole_file(ENVIRONMENTS / "millprint.yaml") as partial:
        partial.write_text(conda_text())
