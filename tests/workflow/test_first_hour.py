"""The first hour of docs/first_hour.md: its commands do what it says."""

import contextlib
import io
import re
import shlex
import shutil
from pathlib import Path
from unittest.mock import patch

import pytest

from millprint.cli import engine
from millprint.cli.commands import main as millprint
from tests.conftest import ROOT
from tests.workflow.conftest import copy_project, edit_yaml, run_snakemake, share_checks, share_kernels
from tests.workflow.handbook import block_lines

FIRST_HOUR = (ROOT / "docs/first_hour.md").read_text()
# Installing has been done where a test runs; test_readme.py looks whether make knows the target.
DONE_BEFORE = ["make install", "source .venv/bin/activate"]


# Its jobs are those of the planetary mill, so it is only planned; the match finds the fingerprint that is shipped.
MIXER = "millprint fingerprint config/first_hour/mixer.yaml"


@pytest.fixture(scope="module")
def beginner(tmp_path_factory) -> Path:
    """A project whose kernels are compiled."""
    folder = copy_project(tmp_path_factory.mktemp("first_hour") / "millprint")
    share_kernels(folder)
    share_checks(folder)
    return folder


def run_line(line: str, project: Path) -> str:
    """What a line prints. Snakemake runs in a fork of a process that has imported it, whatever command starts it."""
    program, *words = shlex.split(line)
    if program == "snakemake":
        done = run_snakemake(project, *words, timeout=300)
        assert done.returncode == 0, f"{line}\n{done.stdout[-3000:]}"
        return done.stdout

    def forked(command: list[str]) -> int:
        return run_snakemake(project, *command[2:], timeout=300).returncode

    printed = io.StringIO()
    with contextlib.chdir(project), patch.object(engine, "run_python", forked), contextlib.redirect_stdout(printed):
        assert program == "millprint" and millprint(words) == 0, line
    return printed.getvalue()


@pytest.fixture(scope="module")
def first_hour(beginner) -> dict[str, str]:
    """What each command of the first hour prints. They run in order."""
    planetary = beginner / "config/first_hour/planetary.yaml"
    # One new simulation for the coverage of the bands, instead of eight, and windows of 3 turns that do not grow.
    edit_yaml(planetary, "mills", "held_out", value=1)
    edit_yaml(planetary, "sweep", "window_turns", value=3)
    lines = block_lines(FIRST_HOUR)
    assert lines[:2] == DONE_BEFORE and MIXER in lines
    printed = {}
    for line in lines[2:]:
        printed[line] = run_line(f"{line} --dry-run" if line == MIXER else line, beginner)
        if line == MIXER:
            place = beginner / "results/first_hour/mills/mixer"
            place.mkdir()
            shutil.copy(beginner / "config/fingerprints/mixer.json", place / "fingerprint.json")
    return printed


def test_the_first_hour_writes_the_files_that_it_names(first_hour, beginner):
    folder = beginner / "results/first_hour/mills/planetary"
    named = set(re.findall(r"`(?:results/first_hour/mills/planetary/)?(\w+\.(?:png|pdf|tsv))`", FIRST_HOUR))
    assert {"geometry.png", "motion.png", "fingerprint.pdf", "descriptors.tsv"} <= named
    assert all((folder / name).stat().st_size > 0 for name in named)


def test_the_match_of_the_first_hour_has_the_columns_that_the_page_explains(first_hour):
    *_, printed = first_hour.values()
    explained = re.findall(r"^\| (`.*?) \|", FIRST_HOUR, re.MULTILINE)
    columns = [column for cell in explained for column in re.findall(r"`([^`]+)`", cell)]
    assert len(columns) == 8 and all(column in printed for column in columns), printed
    rows = [line for line in printed.splitlines() if re.match(r"\s*\d+\s+10\b", line)]
    assert rows, printed
