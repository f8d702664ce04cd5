"""Every command of the pages for users works: those of the workflow are planned, the quick ones run to their end.

They run in a clone, page by page and in their order, with the files that the page shows.
"""

import re
import shutil
import subprocess
from pathlib import Path

import pandas as pd
import pytest
import trimesh

from millprint.cli import engine
from millprint.cli.commands import COMMANDS as MILLPRINT
from millprint.cli.commands import main as millprint
from tests.workflow.conftest import ROOT, ask_snakemake, copy_project, share_checks, share_kernels
from tests.workflow.handbook import READ_A_CARD, READ_A_RUN, Command, commands, pages, shown_file

COMMANDS = [command for page in pages() for command in commands(page)]
SHELL = {"cp", "sed", "source", "git", "cd", "nano"}
PROGRAMS = SHELL | {"make", "snakemake", "millprint", "python", "pytest", "docker", "pip"}
# What runs to its end here; `new` asks nothing with --yes.
QUICK = {"estimate", "match", "dose", "design", "analyse", "wet-lab", "quantities", "new", "--help"}
# Those that pass further options on to Snakemake.
PASSING = {"fingerprint", "explore", "run", "plan"}
# What a page has its reader write: language and number of the block. The other files are those of the fixture.
WRITTEN = {
    "docs/how_to/lammps.md": {"mine.yaml": ("yaml", 0)},
    "docs/how_to/configuration.md": {"FOLDER/config/config.yaml": ("yaml", 0)},
    "docs/how_to/measurements.md": {"mine.tsv": ("text", 0)},
    "docs/how_to/design.md": {"design.yaml": ("yaml", 0)},
    "docs/how_to/dose.md": {"my_runs.tsv": ("text", 0)},
    "docs/how_to/wet_lab.md": {"readings.tsv": ("text", 0)},
}
# test_first_hour.py has the run of that page; a word that stands for several is in none.
NEEDS_A_RUN = (READ_A_CARD, *READ_A_RUN, "results/first_hour", "CALCULATION")
# Of the atlas: what its whole run leaves, and half a minute for exponents, of which test_atlas.py has the numbers.
NEEDS_A_RUN += ("results/atlas/", "--exponents")


def commands_of(program: str) -> list[Command]:
    """The commands that call `program`, each once."""
    first = {command.words: command for command in reversed(COMMANDS) if command.words[0] == program}
    return list(first.values())


def test_programs_are_known():
    for program, number in {"make": 10, "snakemake": 15, "millprint": 20}.items():
        assert len(commands_of(program)) >= number
    assert {command.words[0] for command in COMMANDS} <= PROGRAMS
    assert all((ROOT / command.words[1]).exists() for command in commands_of("pytest"))
    for command in commands_of("python"):
        assert (ROOT / command.words[1]).is_file() or (ROOT / f"{command.words[2].replace('.', '/')}.py").is_file()


@pytest.mark.parametrize("command", commands_of("make"), ids=str)
def test_make_knows_the_target(command):
    done = subprocess.run(["make", "--dry-run", *command.words[1:]], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="module")
def clone(tmp_path_factory) -> Path:
    """A clone with a mill and a run of a reader, tables, a surface, and the fingerprint of a mill."""
    folder = copy_project(tmp_path_factory.mktemp("readme") / "millprint")
    share_kernels(folder)
    share_checks(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert millprint(["new", "planetary", "--name", "mine", "--yes", "--no-picture"]) == 0
    for source, target in {
        "config/data/experiments_smoke.tsv": "my_experiments.tsv",
        "config/fingerprints/planetary.json": "results/mills/planetary/fingerprint.json",
    }.items():
        (folder / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / source, folder / target)
    turn = "\n".join(f"{0.01 * n}\t{x}\t0\t0" for n, x in enumerate([0.01, 0, -0.01, 0, 0.01]))
    (folder / "motion.tsv").write_text(f"time_s\tx_m\ty_m\tz_m\n{turn}\n")
    trimesh.creation.cylinder(radius=20, height=40, sections=24).export(folder / "jar_in_mm.stl")
    # The folder of an installed millprint, of a run, and that of a reader's workflow.
    for name in ("MILLPRINT", "FOLDER"):
        (folder / name).mkdir()
    for name in ("workflow", "scripts", "src", "config", "envs"):
        (folder / "MILLPRINT" / name).symlink_to(folder / name)
    return folder


def arguments_of(words: list[str], monkeypatch) -> list[list[str]]:
    """The arguments with which a command of the workflow would start Snakemake."""
    if words[0] == "snakemake":
        return [words[1:]]
    started = []

    def run(given: list[str]) -> int:
        started.append(given[given.index("snakemake") + 1 :])
        return 0

    # First, since it imports Snakemake, whose plugins start programs.
    monkeypatch.setattr("snakemake.cli.main", lambda given: run(["snakemake", *given]))
    monkeypatch.setattr(engine, "run_python", run)
    assert millprint(words[1:]) == 0
    monkeypatch.undo()
    return started


def targets_and_options(arguments: list[str]) -> tuple[list[str], tuple[str, ...]]:
    """The targets among the arguments of Snakemake, and the other words but for --cores and --dry-run."""
    targets, options, option = [], [], ""
    for word in arguments:
        if option == "--cores":
            option = ""
        elif word.startswith("-"):
            option = word
            options += [word] if word not in ("--cores", "--dry-run", "-n") else []
        else:
            (options if option not in ("", "--dry-run", "-n") else targets).append(word)
    return targets, tuple(options)


def measure(folder: Path) -> None:
    """Do what a page says between a design and its analysis: a yield for each run, and terms in the file of factors."""
    runs = pd.read_csv(folder / "my_design/design.tsv", sep="\t", dtype=str)
    runs["yield_percent"] = [20 + 7 * place % 11 + 2 * float(time) for place, time in enumerate(runs["time_h"])]
    runs.to_csv(folder / "my_runs.tsv", sep="\t", index=False)
    with (folder / "design.yaml").open("a") as file:
        file.write("model: [A, B, C, D]\n")


def plan(folder: Path, wanted: list[list[str]]) -> None:
    """One plan for all commands that differ only in their targets."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for arguments in wanted:
        targets, options = targets_and_options(arguments)
        groups.setdefault(options, []).extend(targets)
    for options, targets in groups.items():
        more = [] if "--unlock" in options else ["--dry-run"]
        # Options last, since they may end with `--` and targets.
        done = ask_snakemake(folder, *sorted(set(targets)), *more, "--cores", "2", *options)
        assert done.returncode == 0, f"{targets} {options}: {done.stdout[-2000:]}{done.stderr[-2000:]}"


# Commands of two pages are planned once, and those of pages without files of their own all together, at the end.
SEEN: set[tuple[str, ...]] = set()
AT_THE_END: list[list[str]] = []


# test_first_hour.py runs the commands of its page to their end.
def status_of(words: list[str]) -> int:
    """The exit status of `millprint`, also where --help ends it."""
    try:
        return millprint(words)
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.mark.parametrize("page", [str(page) for page in pages() if page.stem != "first_hour"])
def test_the_commands_of_a_page_run(clone, page, monkeypatch):
    run_of_mine = (clone / "mine.yaml").read_text()
    for name, place in WRITTEN.get(page, {}).items():
        (clone / name).parent.mkdir(parents=True, exist_ok=True)
        (clone / name).write_text(shown_file(page, *place))
    wanted: list[list[str]] = [] if page in WRITTEN else AT_THE_END
    for command in commands(Path(page)):
        words = list(command.words)
        monkeypatch.chdir(clone)
        needs_a_run = any(each in str(command) for each in NEEDS_A_RUN)
        if words[0] in ("cp", "sed") and not needs_a_run:
            subprocess.run(words, cwd=clone, check=True)
        elif (command.words in SEEN and page not in WRITTEN) or "--report" in words:
            # The smoke run makes the report.
            continue
        elif words[0] == "snakemake" or (words[0] == "millprint" and words[1] in PASSING and len(words) > 2):
            for arguments in arguments_of(words, monkeypatch):
                # Nothing that a page writes changes the plan of the thesis.
                (wanted if targets_and_options(arguments)[1] else AT_THE_END).append(arguments)
        elif words[0] == "millprint" and words[1] in QUICK and not needs_a_run:
            if "--any" in words and "--balls" not in words:
                # Of one size, since a search takes a second for each.
                words += ["--balls", "10"]
            if words[1] == "new" and "--name" in words:
                words += ["--yes", "--no-picture"]
                for name in ("mine.yaml", "config/mills/mine.yaml"):
                    (clone / name).unlink(missing_ok=True)
            if words[1] == "analyse":
                measure(clone)
            assert len(words) == 2 or status_of(words[1:]) == 0, words
        SEEN.add(command.words)
    if page in WRITTEN:
        plan(clone, wanted)
    (clone / "mine.yaml").write_text(run_of_mine)


def test_snakemake_plans_the_commands_of_all_pages(clone):
    """Among them every target of the thesis, in one plan."""
    found = {target for arguments in AT_THE_END for target in targets_and_options(arguments)[0]}
    assert {"chapter3", "ablations", "calibration", "mills", "uncertainty"} <= found
    plan(clone, AT_THE_END)


def options_by_command() -> dict[str, set[str]]:
    """The options that the pages give to each command of `millprint`; those of Snakemake are not its own."""
    found: dict[str, set[str]] = {}
    for command in commands_of("millprint"):
        found.setdefault(command.words[1], set()).update(word for word in command.words[2:] if word.startswith("--"))
    return found


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
