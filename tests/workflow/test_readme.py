"""Every command of the pages for users works: its target or script exists and has the given options."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from snakemake.cli import get_argument_parser

from tests.workflow.conftest import ROOT, copy_planetary, run_snakemake
from tests.workflow.handbook import Command, commands, pages

COMMANDS = [command for page in pages() for command in commands(page)]
PROGRAMS = {"make", "snakemake", "python", "cp", "sed", "source", "git", "cd", "$EDITOR"}
# Contact set of the reader.
STEEL = "config/contacts/steel.yaml"


def commands_of(program: str) -> list[Command]:
    """The commands that call `program`, each once."""
    first = {command.words: command for command in reversed(COMMANDS) if command.words[0] == program}
    return list(first.values())


def targets_by_config() -> dict[tuple[str, ...], list[str]]:
    """The targets that Snakemake is asked for, by the settings on its command line; without --configfile."""
    parser = get_argument_parser()
    found: dict[tuple[str, ...], list[str]] = {}
    for command in commands_of("snakemake"):
        given = parser.parse_args(command.words[1:])
        if given.targets and not given.configfile:
            found.setdefault(tuple(given.config or ()), []).extend(given.targets)
    return found


def test_programs_are_known():
    assert len(commands_of("make")) >= 10 and len(commands_of("snakemake")) >= 20 and len(commands_of("python")) >= 10
    assert {command.words[0] for command in COMMANDS} <= PROGRAMS


@pytest.mark.parametrize("command", commands_of("make"), ids=str)
def test_make_knows_the_target(command):
    done = subprocess.run(["make", "--dry-run", *command.words[1:]], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_snakemake_would_run_every_target(project: Path):
    targets = targets_by_config()[()]
    assert {"chapter3", "ablations"} <= set(targets)
    done = run_snakemake(project, *dict.fromkeys(targets), "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("config", [config for config in targets_by_config() if config], ids=" ".join)
def test_snakemake_would_run_with_your_own_mill_and_powder(project: Path, config):
    copy_planetary(project / "config/mills")
    (project / "config/contacts/mine.yaml").write_text((ROOT / STEEL).read_text().replace("name: steel", "name: mine"))
    (project / "my_experiments.tsv").write_text((ROOT / "config/data/experiments_smoke.tsv").read_text())
    targets = dict.fromkeys(targets_by_config()[config])
    done = run_snakemake(project, *targets, "--config", *config, "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


def options_by_script() -> dict[str, set[str]]:
    """The options that the pages give to each script; a module of the tests (`python -m`) is not a script."""
    found: dict[str, set[str]] = {}
    for command in (each for each in commands_of("python") if each.words[1] != "-m"):
        found.setdefault(command.words[1], set()).update(word for word in command.words[2:] if word.startswith("--"))
    return found


# Shows the help of every script in one process, since most of the time goes into importing the libraries.
SHOW_HELP = """
import contextlib, io, json, runpy, sys
shown = {}
for script in sys.argv[1:]:
    sys.argv = [script, "--help"]
    with contextlib.redirect_stdout(io.StringIO()) as text:
        try:
            runpy.run_path(script, run_name="__main__")
        except SystemExit as ended:
            shown[script] = [ended.code, text.getvalue()]
print(json.dumps(shown))
"""


@pytest.fixture(scope="module")
def shown_help() -> dict[str, tuple[int, str]]:
    """The exit status and the help of every script of the pages."""
    done = subprocess.run(
        [sys.executable, "-c", SHOW_HELP, *options_by_script()],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT / "src"), str(ROOT / "scripts")])},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(("script", "options"), options_by_script().items(), ids=options_by_script())
def test_script_knows_its_options(shown_help, script, options):
    status, text = shown_help[script]
    assert not status
    for option in options:
        assert re.search(rf"{option}\b", text), f"{script} has no option {option}"
