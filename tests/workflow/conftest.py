"""A copy of the working tree to run the pipeline in, and one smoke run that the workflow tests share."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# As `make smoke` and `make thesis` ask for it.
REPORT = (
    *("--report", "results/report/report.html", "--report-after-run"),
    *("--report-stylesheet", "workflow/report/report.css"),
)


def copy_project(folder: Path) -> Path:
    """Copy every file that git tracks or would track, as a clean clone of the working tree."""
    listing = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    for name in filter(None, listing.stdout.split("\0")):
        source, target = ROOT / name, folder / name
        if source.is_file():
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(source, target)
    return folder


def run_snakemake(project: Path, *arguments: str, timeout: float = 120) -> subprocess.CompletedProcess:
    """Run Snakemake in `project`, both streams in `stdout`."""
    environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "2", *arguments],
        cwd=project,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=timeout,
    )


def ask_snakemake(folder: Path, *arguments: str, timeout: float = 180) -> subprocess.CompletedProcess:
    """Run Snakemake with nothing but `arguments`, no --cores either; its two streams apart."""
    command = [sys.executable, "-m", "snakemake", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=timeout)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return copy_project(tmp_path / "millprint")


@pytest.fixture(scope="session")
def smoke_project(tmp_path_factory) -> Path:
    """A clean copy in which the smoke workflow has run from nothing."""
    folder = copy_project(tmp_path_factory.mktemp("smoke") / "millprint")
    done = run_snakemake(folder, "--configfile", "config/smoke.yaml", *REPORT, timeout=1200)
    assert done.returncode == 0, done.stdout[-6000:]
    return folder
