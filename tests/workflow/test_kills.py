"""Kill -9 at random moments, and damaged files: after `make verify` the next run ends with the same, bit for bit.

MILLPRINT_KILLS sets the number of kills, MILLPRINT_KILL_SEED the moments.
"""

import hashlib
import json
import os
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import psutil
import pytest

from millprint.files import read_json
from tests.workflow.conftest import copy_project, run_snakemake

KILLS = int(os.environ.get("MILLPRINT_KILLS", "20"))
SEED = int(os.environ.get("MILLPRINT_KILL_SEED", "0"))
CASES = [
    "emax/calibrated/d10_f0.10_n600_s0",
    "emax/calibrated/d10_f0.17_n600_s0",
    "emax/steel/d10_f0.17_n600_s0",
    "emax/calibrated/d5_f0.08_n600_s0",
]
TARGETS = [
    *(f"results/dem/{case}/summary.json" for case in CASES),
    "results/surrogate/thesis/weights.pt",
    "results/yield/models/gpr_two_step.json",
    "results/yield/models/xgb_primary.json",
    "results/doe/anova_printed.tsv",
]
CONFIGURATION = ("--configfile", "config/smoke.yaml", "tests/data/faults.yaml")
ARGUMENTS = (*CONFIGURATION, "--", *TARGETS)
RUNS = ".snakemake/millprint/runs"

# What says how long something took, and nothing else, differs between two runs.
CLOCKS = {
    "summary.json": ["wall_clock_s", "processor_s", "ns_per_ball_step"],
    "kernels.json": ["seconds"],
    "loss.tsv": ["elapsed_s"],
}
NO_RESULTS = ("logs", "benchmarks")


def fingerprint(path: Path) -> str:
    """A digest of a result, its clocks left out."""
    clocks = CLOCKS.get(path.name, [])
    if path.suffix == ".json" and clocks:
        content = {key: value for key, value in read_json(path).items() if key not in clocks}
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    if clocks:
        return pd.read_csv(path, sep="\t", dtype=str).drop(columns=clocks).to_csv()
    return hashlib.sha256(path.read_bytes()).hexdigest()


def results_of(project: Path) -> dict[str, str]:
    """Every file below results/ with its digest."""
    folder = project / "results"
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != ".gitkeep"]
    return {
        str(path.relative_to(folder)): fingerprint(path)
        for path in sorted(files)
        if path.relative_to(folder).parts[0] not in NO_RESULTS
    }


def jobs_run(output: str) -> dict[str, int]:
    """Rule to number of jobs of a run, from Snakemake's table of them."""
    return {rule: int(count) for rule, count in re.findall(r"^(\w+) +(\d+)$", output, re.MULTILINE) if rule != "total"}


def verify(
    project: Path, *options: str, arguments: tuple[str, ...] = (), timeout: float = 600
) -> subprocess.CompletedProcess:
    """`make verify` with its own `options` and more `arguments` of Snakemake, nobody at the terminal."""
    return subprocess.run(
        [sys.executable, "scripts/verify_results.py", *options, "--", "--cores", "2", *arguments, *CONFIGURATION],
        cwd=project,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=timeout,
    )


@pytest.fixture(scope="module")
def workplace(tmp_path_factory) -> tuple[Path, dict[str, str]]:
    """A project, and the results of a run of it that nothing disturbed."""
    project = copy_project(tmp_path_factory.mktemp("kills") / "millprint")
    done = run_snakemake(project, *ARGUMENTS, timeout=1800)
    assert done.returncode == 0, done.stdout[-4000:]
    undisturbed = results_of(project)
    shutil.rmtree(project / "results")
    shutil.rmtree(project / ".snakemake")
    return project, undisturbed


class Session:
    """Snakemake in a group of processes of its own."""

    def __init__(self, project: Path, log: Path, arguments: tuple[str, ...] = ARGUMENTS):
        environment = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
        self.project, self.log = project, log.open("a")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "snakemake", "--cores", "2", "--keep-going", *arguments],
            cwd=project,
            env=environment,
            stdout=self.log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def jobs(self) -> list[psutil.Process]:
        """The scripts that run."""
        found = []
        for child in psutil.Process(self.process.pid).children(recursive=True):
            try:
                # Not the shell around it, which has the script's name in its words too.
                words = child.cmdline()
                if len(words) == 2 and "/.snakemake/scripts/" in words[1]:
                    found.append(child)
            except psutil.Error:
                continue
        return found

    def wait_for_a_job(self) -> bool:
        """Whether a script was seen to run before the session ended."""
        while self.process.poll() is None:
            if self.jobs():
                return True
            time.sleep(0.05)
        return False

    def wait_for_progress(self) -> bool:
        """Whether there is something that a job can go on from, before the session ended."""
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
    session, kills, resumable, said = Session(project, log), 0, 0, ""
    while kills < KILLS:
        # While Snakemake begins, while a job begins, or in the middle of one.
        moment = rng.choices([lambda: True, session.wait_for_a_job, session.wait_for_progress], [1, 4, 5])[0]
        if session.process.poll() is not None or not moment():
            if results_complete(project):
                # All is done before the last kill: the rest hits it anew.
                shutil.rmtree(project / "results")
            said += verified(project)
            session = Session(project, log)
            continue
        time.sleep(rng.uniform(0, 2))
        resumable += bool(left_behind(project))
        session.kill(rng.choice(["job", "job", "Snakemake", "everything"]), rng)
        kills += 1
    session.process.kill()
    session.process.wait()
    # What users type next: nothing to unlock by hand, no further option.
    said += verified(project)
    done = run_snakemake(project, *ARGUMENTS, timeout=1800)
    assert done.returncode == 0, done.stdout[-4000:]
    assert "Traceback" not in done.stdout
    assert results_of(project) == undisturbed
    assert "found: a run that was killed" in said
    assert "its locks are removed" in said
    sessions = log.read_text() + done.stdout
    assert "cannot be locked" not in sessions
    assert "IncompleteFilesException" not in sessions
    assert not list((project / RUNS).iterdir())
    # Some job went on from where it was.
    logs = "".join(path.read_text() for path in (project / "results/logs").rglob("*.log"))
    assert resumable
    assert "going on from" in logs
    assert not left_behind(project)


def verified(project: Path) -> str:
    """What `make verify` says after a kill, which it must mend without a question."""
    done = verify(project)
    assert done.returncode == 0, done.stdout
    return done.stdout


def left_behind(project: Path) -> list[Path]:
    """Restart files and checkpoints of jobs that have not come to their end."""
    return [path for name in ("restart.h5", "*.checkpoint.pt") for path in (project / "results").rglob(name)]


def results_complete(project: Path) -> bool:
    return all((project / target).is_file() for target in TARGETS)


def damage(path: Path, how: str) -> None:
    content = bytearray(path.read_bytes())
    if how == "truncated":
        path.write_bytes(content[: len(content) // 2])
    else:
        middle = len(content) // 2
        content[middle : middle + 16] = bytes(byte ^ 0xFF for byte in content[middle : middle + 16])
        path.write_bytes(content)


@pytest.mark.parametrize(
    ("file", "how", "rule"),
    [
        (f"results/dem/{CASES[0]}/run.h5", "truncated", "run_dem_case"),
        ("results/surrogate/dataset.h5", "changed", "build_surrogate_dataset"),
        ("results/surrogate/thesis/weights.pt", "truncated", "train_surrogate"),
    ],
)
def test_a_damaged_result_is_found_and_it_alone_made_again(workplace, file, how, rule):
    project, undisturbed = workplace
    assert run_snakemake(project, *ARGUMENTS, timeout=1800).returncode == 0
    dates = dates_of(project)
    damage(project / file, how)
    damaged = results_of(project)
    done = verify(project)
    assert done.returncode == 1, done.stdout
    assert re.search(rf"^found: {re.escape(file)}: {how}", done.stdout, re.MULTILINE), done.stdout
    assert "nothing was changed; choose one of two:" in done.stdout
    assert results_of(project) == damaged
    done = verify(project, "--repair")
    assert done.returncode == 0, done.stdout[-4000:]
    assert jobs_run(done.stdout) == {rule: 1}
    assert f"made again: {file}, bit for bit as it was written" in done.stdout
    (project / f"{file}.damaged").unlink()
    assert results_of(project) == undisturbed
    # Of all results, only this one is younger, and Snakemake sees that it is the same.
    now = dates_of(project)
    assert {name for name in now if now[name] != dates.get(name)} == {file}
    assert "Nothing to be done" in run_snakemake(project, *ARGUMENTS).stdout


def dates_of(project: Path) -> dict[str, int]:
    """Every result with its date."""
    return {f"results/{name}": (project / "results" / name).stat().st_mtime_ns for name in results_of(project)}


def test_a_file_that_was_edited_on_purpose_stays_until_its_owner_decides(workplace):
    project, undisturbed = workplace
    file = "results/doe/anova_printed.tsv"
    assert run_snakemake(project, *ARGUMENTS, timeout=1800).returncode == 0
    edited = (project / file).read_text() + "# a remark of mine\n"
    (project / file).write_text(edited)
    # Another job to do, so that a run begins, and says what it found.
    (project / "results/yield/models/xgb_primary.json").unlink()
    done = run_snakemake(project, *ARGUMENTS, timeout=600)
    assert done.returncode == 0, done.stdout[-4000:]
    assert re.search(rf"^found: {re.escape(file)}: changed .*; make verify tells more$", done.stdout, re.MULTILINE)
    assert verify(project).returncode == 1
    assert (project / file).read_text() == edited
    assert verify(project, "--keep").returncode == 0
    assert verify(project).returncode == 0
    assert (project / file).read_text() == edited
    assert "Nothing to be done" in run_snakemake(project, *ARGUMENTS).stdout
    # Made again only when it is no longer there.
    (project / file).unlink()
    assert run_snakemake(project, *ARGUMENTS, timeout=600).returncode == 0
    assert results_of(project) == undisturbed


def test_a_lock_stays_where_a_run_is_alive_or_nothing_is_known_of_one(workplace):
    project, _ = workplace
    (project / TARGETS[0]).unlink(missing_ok=True)
    session, held = Session(project, project / "sessions.log"), []
    other = project / RUNS / "another-host-12"
    try:
        assert session.wait_for_a_job()
        # It must not end before the second run has begun.
        held = session.jobs()
        for job in held:
            job.suspend()
        done = verify(project)
        assert done.returncode == 0, done.stdout
        assert f"found: a run that is alive: process {session.process.pid} on this machine" in done.stdout
        second = run_snakemake(project, *ARGUMENTS)
        assert second.returncode == 1
        assert "cannot be locked" in second.stdout
        other.write_text("of another machine")
    finally:
        for job in held:
            job.kill()
        session.kill("everything", random.Random(0))
    # The run here is dead, but the locks could be those of the other machine's.
    done = verify(project)
    assert done.returncode == 0, done.stdout
    assert "process 12 on machine another-host; its locks stay" in done.stdout
    assert f"snakemake --unlock; rm {RUNS}/another-host-12" in done.stdout
    assert "cannot be locked" in run_snakemake(project, *ARGUMENTS).stdout
    assert other.read_text() == "of another machine"
    assert (project / RUNS / f"{socket.gethostname()}-{session.process.pid}").exists()
    # Its owner has looked after it.
    other.unlink()
    done = verify(project)
    assert "its locks are removed: snakemake --cores 2 --configfile" in done.stdout
    assert run_snakemake(project, *ARGUMENTS, timeout=600).returncode == 0


def test_locks_in_a_database_are_removed_too(workplace):
    project, _ = workplace
    backend = ("--persistence-backend", "db")
    shutil.rmtree(project / "results/doe")
    arguments = (*backend, *CONFIGURATION, "--", "results/doe/anova_printed.tsv")
    session = Session(project, project / "sessions.log", arguments)
    assert session.wait_for_a_job()
    session.kill("everything", random.Random(0))
    assert "cannot be locked" in run_snakemake(project, *arguments).stdout
    done = verify(project, arguments=backend)
    assert done.returncode == 0, done.stdout
    done = run_snakemake(project, *arguments)
    assert done.returncode == 0, done.stdout
