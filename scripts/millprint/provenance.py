"""Provenance of a run: commit, machine, Python and packages."""

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

PACKAGES = ("snakemake", "numpy", "numba", "scipy", "pandas", "statsmodels", "scikit-learn", "torch", "torch-geometric")


def package_versions() -> dict[str, str]:
    """Versions of the packages that results depend on, by name."""
    return {name: version(name) for name in PACKAGES}


def commit(folder: str | Path = Path(__file__).parent) -> str:
    """The commit of a working tree, by default the library's own, with a word where files differ from it.

    `unknown` outside a repository, such as for an installed library.
    """
    command = ["git", "-C", str(folder), "describe", "--always", "--dirty= with changes", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def provenance() -> dict[str, str]:
    """Commit, machine and versions as text, by name."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "commit": commit(),
        "Python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}, {cores} cores",
        **package_versions(),
    }
