"""Every command of the handbooks works: its target or script exists and has the given options."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
from snakemake.cli import get_argument_parser

from tests.workflow.conftest import ROOT, copy_planetary, run_snakemake

HANDBOOKS = ("README.md", "config/README.md", "CONTRIBUTING.md")
# For MILL/CONTACT/CASE of the handbooks: a case of config/config.yaml with snapshots.
CASE = "emax/calibrated/d10_f0.10_n600_s2"


def commands(handbook: str) -> list[list[str]]:
    """The commands of a handbook's `sh` blocks, each as a list of words, without comments."""
    blocks = re.findall(r"^```sh\n(.*?)^```", (ROOT / handbook).read_text(), re.MULTILINE | re.DOTALL)
    lines = "".join(blocks).replace("\\\n", " ").replace("MILL/CONTACT/CASE", CASE).splitlines()
    return [words for line in lines if (words := shlex.split(line, comments=True))]


COMMANDS = [words for handbook in HANDBOOKS for words in commands(handbook)]


def commands_of(program: str) -> list[list[str]]:
    """The arguments of every command that calls `program`."""
    return [words[1:] for words in COMMANDS if words[0] == program]


def test_programs_are_known():
    assert len(commands_of("make")) >= 3 and len(commands_of("snakemake")) >= 5 and len(commands_of("python")) >= 4
    assert {words[0] for words in COMMANDS} <= {"make", "snakemake", "python", "cp", "sed", "$EDITOR"}


@pytest.mark.parametrize("words", commands_of("make"), ids=" ".join)
def test_make_knows_the_target(words):
    done = subprocess.run(["make", "--dry-run", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_snakemake_would_run_every_target(project: Path):
    parser = get_argument_parser()
    parsed = [parser.parse_args(words) for words in commands_of("snakemake")]
    targets = [target for arguments in parsed if not arguments.config for target in arguments.targets]
    assert {"chapter3", "ablations"} <= set(targets)
    done = run_snakemake(project, *dict.fromkeys(targets), "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("words", [words for words in commands_of("snakemake") if "mill=mine" in words], ids=" ".join)
def test_snakemake_would_run_your_own_mill(project: Path, words):
    copy_planetary(project / "config/mills")
    done = run_snakemake(project, *words, "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("words", commands_of("python"), ids=" ".join)
def test_script_knows_its_options(words):
    script, *rest = words
    done = subprocess.run(
        [sys.executable, script, "--help"], cwd=ROOT, capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    for word in rest:
        if word.startswith("--"):
            assert re.search(rf"{word}\b", done.stdout), f"{script} has no option {word}"
