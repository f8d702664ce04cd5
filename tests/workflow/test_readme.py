"""Every command of the pages for users works: its target or script exists and has the given options."""

import re
import subprocess
from pathlib import Path

import pytest
from snakemake.cli import get_argument_parser

from millprint.cli.commands import COMMANDS as MILLPRINT
from millprint.cli.commands import main as millprint
from tests.workflow.conftest import ROOT, copy_planetary, run_snakemake
from tests.workflow.handbook import Command, commands, pages

COMMANDS = [command for page in pages() for command in commands(page)]
PROGRAMS = {"make", "snakemake", "millprint", "python", "cp", "sed", "source", "git", "cd", "nano", "pip"}
# Contact set of the reader.
STEEL = "config/contacts/steel.yaml"
SMOKE = ("--configfile", "config/smoke.yaml")


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
    for program, number in {"make": 10, "snakemake": 15, "millprint": 20}.items():
        assert len(commands_of(program)) >= number
    assert {command.words[0] for command in COMMANDS} <= PROGRAMS


@pytest.mark.parametrize("command", commands_of("make"), ids=str)
def test_make_knows_the_target(command):
    done = subprocess.run(["make", "--dry-run", *command.words[1:]], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_snakemake_would_run_every_target(project: Path):
    targets = targets_by_config()[()]
    assert {"chapter3", "ablations"} <= set(targets)
    done = run_snakemake(project, *dict.fromkeys(targets), *SMOKE, "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("config", [config for config in targets_by_config() if config], ids=" ".join)
def test_snakemake_would_run_with_your_own_mill_and_powder(project: Path, config):
    copy_planetary(project / "config/mills")
    (project / "config/contacts/mine.yaml").write_text((ROOT / STEEL).read_text().replace("name: steel", "name: mine"))
    (project / "my_experiments.tsv").write_text((ROOT / "config/data/experiments_smoke.tsv").read_text())
    page = (ROOT / "docs/how_to/measurements.md").read_text()
    (project / "mine.tsv").write_text(page.split("```text\n")[1].split("```")[0])
    targets = dict.fromkeys(targets_by_config()[config])
    done = run_snakemake(project, *targets, "--config", *config, "--dry-run", "--quiet", "all")
    assert done.returncode == 0, done.stdout[-3000:]


def options_by_command() -> dict[str, set[str]]:
    """The options that the pages give to each command of `millprint`; those of Snakemake are not its own."""
    found: dict[str, set[str]] = {}
    for command in commands_of("millprint"):
        found.setdefault(command.words[1], set()).update(word for word in command.words[2:] if word.startswith("--"))
    return found


# Those that pass further options on to Snakemake.
PASSING = {"fingerprint", "explore", "run", "plan"}


@pytest.mark.parametrize(("name", "options"), options_by_command().items(), ids=options_by_command())
def test_millprint_knows_the_command_and_its_options(capsys, name, options):
    if name.startswith("-"):
        assert millprint([name]) == 0
        return
    assert name in {*MILLPRINT, "COMMAND"}
    if name == "COMMAND" or name in PASSING:
        return
    with pytest.raises(SystemExit):
        millprint([name, "--help"])
    text = capsys.readouterr().out
    for option in options:
        assert re.search(rf"{option}\b", text), f"millprint {name} has no option {option}"
