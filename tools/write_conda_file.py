"""Writes envs/millprint.yaml, for `snakemake --sdm conda`, from the lock file; run it by `make lock`."""

import re
import tomllib
from importlib.metadata import requires
from pathlib import Path

import yaml
from packaging.requirements import Requirement

from millprint.run.files import whole_file

ROOT = Path(__file__).parent.parent
TORCH_INDEX = "https://download.pytorch.org/whl/cpu"


def _name(text: str) -> str:
    """The normalised name of a package (PEP 503)."""
    return re.sub(r"[-_.]+", "-", text).lower()


def locked() -> dict[str, str]:
    """The line of each package in the lock file, by normalised name."""
    lines = (ROOT / "envs" / "requirements.lock").read_text().splitlines()
    return {line.split("==")[0]: line for line in lines if not line.startswith("#")}


def library_packages() -> list[str]:
    """Lines of the lock file that jobs need, directly or through another package: the core's, the thesis's, torch.

    Snakemake and the tools of developers are not among them: a job of Snakemake needs neither.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    texts = [*project["dependencies"], *extras["thesis"], *extras["surrogate"], "xgboost-cpu"]
    waiting = [Requirement(text) for text in texts if not text.startswith("snakemake")]
    known, found = locked(), set()
    while waiting:
        requirement = waiting.pop()
        name = _name(requirement.name)
        if name in found or name not in known:
            continue
        found.add(name)
        for text in requires(requirement.name) or []:
            inner = Requirement(text)
            if inner.marker is None or inner.marker.evaluate({"extra": ""}):
                waiting.append(inner)
    return [known[name] for name in sorted(found)]


def conda_text() -> str:
    """The text of the environment file: Python and pip from conda-forge, the packages as locked."""
    # pip reads an index among the packages: that of torch without gigabytes for graphics cards.
    packages = ["python=3.11", "pip", {"pip": [f"--extra-index-url {TORCH_INDEX}", *library_packages()]}]
    content = {"channels": ["conda-forge", "nodefaults"], "dependencies": packages}
    return f"# Written from requirements.lock by `make lock`.\n{yaml.safe_dump(content, sort_keys=False, width=500)}"


if __name__ == "__main__":
    with whole_file(ROOT / "envs" / "millprint.yaml") as partial:
        partial.write_text(conda_text())
