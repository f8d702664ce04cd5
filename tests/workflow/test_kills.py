"""Kill -9 at random moments: once unlocked, the next run gives the same results bit for bit. Damaged files too.

MILLPRINT_KILLS sets the number of kills, MILLPRINT_KILL_SEED the moments: `make kills` has 50 of them.
"""

import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import pandas as pd
import psutil
import pytest

from millprint.run.files import read_json
from tests.workflow.conftest import (
    active_environment,
    copy_project,
    jobs_of,
    run_snakemake,
    share_checks,
    share_kernels,
)

KILLS = int(os.environ.get("MILLPRINT_KILLS", "2"))
SEED = int(os.environ.get("MILLPRINT_KILL_SEED", "0"))
CASES = ["emax/calibrated/d10_f0.10_n600_s0", "emax/calibrated/d10_f0.17_n600_s0"]
TARGETS = [
    *(f"results/dem/{case}/summary.json" for case in CASES),
    "results/surrogate/thesis/weights.pt",
    "results/doe/anova_printed.tsv",
]
CONFIGURATION = ("--configfile", "config/smoke.yaml", "tests/data/faults.yaml")
EVERYTHING = (*CONFIGURATION, "--", *TARGETS)

# Only measured times differ between two runs.
CLOCKS = {
    "summary.json": ["wall_clock_s", "processor_s", "ns_per_ball_step"],
    "kernels.json": ["seconds"],
    "loss.tsv": ["elapsed_s"],
}
NO_RESULTS = ("logs", "benchmarks")


def digest_of(path: Path) -> str:
    """A digest of a result without its measured times."""
    clocks = CLOCKS.get(path.name, [])
    if path.suffix == ".json" and clocks:
        content = {key: value for key, value in read_json(path).items() if key not in clocks}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    if clocks:
        return pd.read_csv(path, sep="\t", dtype=str).drop(columns=clocks).to_csv()
    return hashlib.sha256(path.read_bytes()).hexdigest()


def results_of(project: Path) -> dict[str, str]:
    """The digest of every file in results/, except NO_RESULTS."""
    folder = project / "results"
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != ".gitkeep"]
    return {
        str(path.relative_to(folder)): digest_of(path)
        for path in sorted(files)
        if path.relative_to(folder).parts[0] not in NO_RESULTS
    }


def unlock(project: Path) -> None:
    """What a user types after a kill, if no other run works there."""
    done = run_snakemake(project, *CONFIGURATION, "--unlock")
    assert done.returncode == 0, done.stdout


def changed_files(project: Path) -> list[str]:
    """The lines of `make verify`."""
    command = [sys.executable, "-m", "millprint.cli", "verify"]
    done = subprocess.run(command, cwd=project, env=active_environment(), capture_output=True, text=True, timeout=60)
    assert (done.returncode == 1) == bool(done.stderr), done.stderr
    return done.stderr.splitlines()


class Workplace(NamedTuple):
    """A project without results, and the results of an undisturbed run with their digests."""

    project: Path
    undisturbed: dict[str, str]


@pytest.fixture(scope="module")
def workplace(tmp_path_factory) -> Workplace:
    """A project to disturb."""
    project = copy_project(tmp_path_factory.mktemp("kills") / "millprint")
    share_kernels(project)
    share_checks(project)
    done = run_snakemake(project, *EVERYTHING, timeout=1800)
    assert done.returncode == 0, done.stdout[-4000:]
    undisturbed = results_of(project)
    shutil.rmtree(project / "results")
    shutil.rmtree(project / ".snakemake")
    share_checks(project)
    return Workplace(project, undisturbed)


def complete(project: Path) -> None:
    """Run the workflow if a target is missing, as it is where this test runs before the others."""
    if not all((project / target).is_file() for target in TARGETS):
        assert run_snakemake(project, *EVERYTHING, timeout=1800).returncode == 0


class Session:
    """Snakemake in a process group of its own."""

    def __init__(self, project: Path, log: Path, arguments: tuple[str, ...]):
        self.project, self.log = project, log.open("a")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "snakemake", "--cores", "2", "--keep-going", *arguments],
            cwd=project,
            env=active_environment(),
            stdout=self.log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def jobs(self) -> list[psutil.Process]:
        """The running scripts."""
        children = psutil.Process(self.process.pid).children(recursive=True)
        return [child for child in children if is_job(child, self.project)]

    def wait_for_a_job(self) -> bool:
        """Wait until a script runs; False if the session ends first."""
        while self.process.poll() is None:
            if self.jobs():
                return True
            time.sleep(0.05)
        return False

    def wait_for_progress(self) -> bool:
        """Wait until there is a restart file or checkpoint; False if the session ends first."""
        while self.process.poll() is None:
            if left_behind(self.project):
                return True
            time.sleep(0.05)
        return False

    def kill(self, what: str, rng: random.Random) -> None:
        if what == "job":
            jobs = self.jobs()
            if jobs:
                rng.choice(jobs).kill()
                return
        if what == "everything":
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.wait()


def test_kills_at_random_moments_change_nothing(workplace):
    project, undisturbed = workplace
    rng, log = random.Random(SEED), project / "sessions.log"
    session, kills = Session(project, log, EVERYTHING), 0
    while kills < KILLS:
        # While Snakemake starts, while a job starts, or in the middle of a job.
        moment = rng.choices([lambda: True, session.wait_for_a_job, session.wait_for_progress], [1, 4, 5])[0]
        if session.process.poll() is not None or not moment():
            if all((project / target).is_file() for target in TARGETS):
                # Everything is done before the last kill: start again for the others.
                shutil.rmtree(project / "results")
            unlock(project)
            session = Session(project, log, EVERYTHING)
            continue
        time.sleep(rng.uniform(0, 2))
        session.kill(rng.choice(["job", "job", "Snakemake", "everything"]), rng)
        kills += 1
    session.process.kill()
    session.process.wait()
    wait_for_orphans(project)
    # A user removes the lock, and needs no further option.
    unlock(project)
    done = run_snakemake(project, *EVERYTHING, timeout=1800)
    assert done.returncode == 0, done.stdout[-4000:]
    assert "Traceback" not in done.stdout
    assert results_of(project) == undisturbed
    assert changed_files(project) == []
    assert "IncompleteFilesException" not in log.read_text() + done.stdout
    assert not left_behind(project)


def test_a_killed_job_continues_where_it_stopped(workplace):
    project, undisturbed = workplace
    complete(project)
    target = (*CONFIGURATION, "--", TARGETS[0])
    shutil.rmtree(project / "results/dem" / CASES[0])
    session = Session(project, project / "sessions.log", target)
    assert session.wait_for_progress()
    # Snakemake and its jobs at once, so that no job comes to its end.
    session.kill("everything", random.Random(0))
    assert left_behind(project)
    unlock(project)
    done = run_snakemake(project, *target, timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    assert "continuing from" in (project / f"results/logs/dem/{CASES[0]}.log").read_text()
    assert results_of(project) == undisturbed
    assert not left_behind(project)


def wait_for_orphans(project: Path) -> None:
    """Wait for the jobs that outlive a Snakemake that was killed: they have no lock, and take cores from the others."""
    end = time.monotonic() + 300
    while any(is_job(process, project) for process in psutil.process_iter()):
        assert time.monotonic() < end
        time.sleep(0.2)


def is_job(process: psutil.Process, project: Path) -> bool:
    """Whether a process is a script of a job in this project, not the shell that runs it."""
    try:
        words = process.cmdline()
        return len(words) == 2 and "/.snakemake/scripts/" in words[1] and Path(process.cwd()) == project.resolve()
    except psutil.Error:
        return False


def left_behind(project: Path) -> list[Path]:
    """Restart files and checkpoints of unfinished jobs."""
    return [path for name in ("restart.h5", "*.checkpoint.pt") for path in (project / "results").rglob(name)]


def damage(path: Path, how: str) -> None:
    content = bytearray(path.read_bytes())
    if how == "truncated":
        path.write_bytes(content[: len(content) // 2])
    else:
        middle = len(content) // 2
        content[middle : middle + 16] = bytes(byte ^ 0xFF for byte in content[middle : middle + 16])
        path.write_bytes(content)


# A result of a job, how it is damaged, and the rule that makes it.
DAMAGED = [
    (f"results/dem/{CASES[0]}/run.h5", "truncated", "run_dem_case"),
    ("results/surrogate/dataset.h5", "not as its job wrote it", "build_surrogate_dataset"),
    ("results/surrogate/thesis/weights.pt", "truncated", "train_surrogate"),
]


def test_only_damaged_results_are_found_and_made_again(workplace):
    project, undisturbed = workplace
    complete(project)
    dates = dates_of(project)
    for file, how, _ in DAMAGED:
        damage(project / file, how)
    damaged = results_of(project)
    lines = changed_files(project)
    assert len(lines) == len(DAMAGED)
    for file, how, _ in DAMAGED:
        (line,) = (line for line in lines if line.startswith(f"changed: {file}: {how}"))
        assert "delete it, and a run makes it again" in line
    assert results_of(project) == damaged
    files = [file for file, _, _ in DAMAGED]
    for file in files:
        (project / file).unlink()
    done = run_snakemake(project, *CONFIGURATION, "--", *files, timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    assert jobs_of(done.stdout) == {rule: 1 for _, _, rule in DAMAGED}
    assert results_of(project) == undisturbed
    # Only the files of their jobs have other dates; Snakemake sees that the content is the same.
    now = dates_of(project)
    changed = {name for name in now if now[name] != dates.get(name)}
    assert {Path(name).parent for name in changed} == {Path(file).parent for file in files}
    same = [run_snakemake(project, *EVERYTHING, timeout=600) for _ in range(2)]
    assert "Nothing to be done" in same[1].stdout
    assert results_of(project) == undisturbed


def dates_of(project: Path) -> dict[str, int]:
    """The modification time of every result [ns]."""
    return {f"results/{name}": (project / "results" / name).stat().st_mtime_ns for name in results_of(project)}


MADE = "here/mills/planetary"
TARGET = f"{MADE}/motion.png"
AS_MODULE = """
configfile: "mine.yaml"

module millprint:
    snakefile: {snakefile!r}
    config: config

use rule * from millprint as mill_*
"""
# The words before the target and after it, by which people run millprint: by the command of the wheel, which
# test_wheel.py kills, and as a module. A clone is killed by the tests above.
COMMAND = ["-m", "millprint.cli", "run"], ["mine.yaml"]
MODULE = ["-m", "snakemake", "--cores", "2"], []


def kill_and_remark(folder: Path, python: Path, words: tuple[list[str], list[str]], variables: dict, script: Path):
    """A run in `folder` is killed in its job and mended by a second one; then the script gets a comment.

    words: before the target and after it. A run ends by itself in the time that communicate() is given: neither a
    server nor a timer of Snakemake keeps it.
    """
    (folder / "mine.yaml").write_text("mill: planetary\nresults: here\n")
    before, after = words

    def started(*further: str) -> subprocess.Popen:
        return subprocess.Popen(
            [python, *before, TARGET, *after, *further], cwd=folder, env=variables, start_new_session=True, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip

    session = started()
    while not (folder / MADE / "geometry.svg").exists():
        assert session.poll() is None, session.stdout.read()
        time.sleep(0.01)
    os.killpg(session.pid, signal.SIGKILL)
    assert not (folder / TARGET).exists()
    for further in (["--unlock"], []):
        done = started(*further)
        said, _ = done.communicate(timeout=120)
        assert done.returncode == 0, said
    assert (folder / TARGET).exists()
    script.write_text(f"{script.read_text()}# a remark\n")
    assert "Nothing to be done" in started("--dry-run").communicate(timeout=120)[0]


def test_as_a_module_a_kill_is_mended_and_a_comment_runs_nothing_again(project, tmp_path):
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "Snakefile").write_text(AS_MODULE.format(snakefile=str(project / "workflow/Snakefile")))
    # As docs/how_to/module.md says.
    shutil.copytree(project / "workflow/profiles", folder / "profiles")
    share_checks(folder)
    variables = active_environment() | {"PYTHONPATH": str(project / "src")}
    kill_and_remark(folder, Path(sys.executable), MODULE, variables, project / "scripts/draw_mill.py")
