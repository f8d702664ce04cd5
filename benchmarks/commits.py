"""Times two commits of millprint in turns, in processor seconds: kernel, start of a job, a match, and a dry run.

    python -m benchmarks.commits fd50e33c HEAD --turns 5

Each turn runs every part once with the one commit and once with the other, so that both see the same machine; a first
turn, in which kernels are compiled and files are read, does not count. Ratios are of the two runs of a turn, with
Student's 95 % interval of their mean. The commits are checked out into a temporary folder. A part that a commit does
not have is left out, with its last line of error.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.physics import half_width
from millprint.run.files import write_table

SIMULATE = """
import sys
import yaml
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
mill, diameter_mm, fill, speed_rpm, window_s = sys.argv[1], *map(float, sys.argv[2:])
sizes = {"ball_diameter_m": diameter_mm / 1e3, "speed_hz": speed_rpm / 60, "ball_diameter_mm": diameter_mm,
         "speed_rpm": speed_rpm}  # older commits have rpm and mm
case = Case(mill=mill, contact="calibrated", fill_ratio=fill, seed=0, time_step_s=2e-6, settle_s=1e-3, discard_s=0.0,
            window_s=window_s, **{key: value for key, value in sizes.items() if key in Case.model_fields})
records = [kind(**yaml.safe_load(open(f"config/{folder}/{name}.yaml"))) for folder, kind, name in
           (("mills", MillConfig, mill), ("contacts", ContactConfig, "calibrated"))]
print(simulate(case, *records, DemConfig(closure_max=0.5))["ns_per_ball_step"])
"""
MATCH = "import sys; from millprint.cli.commands import main; sys.exit(main(sys.argv[1:]))"


def python(code: str, *words: str) -> list[str]:
    """A command that runs code with arguments."""
    return [sys.executable, "-c", code, *words]


# Each part: its command, and whether it prints the number that counts, in place of the processor time of all of it.
PARTS: dict[str, tuple[list[str], bool]] = {
    "kernel, 24 balls (ns a ball-step)": (python(SIMULATE, "emax", "10", "0.1", "600", "0.5"), True),
    "kernel, 191 balls (ns a ball-step)": (python(SIMULATE, "emax", "5", "0.1", "600", "0.1"), True),
    "kernel, 764 balls (ns a ball-step)": (python(SIMULATE, "emax", "3.15", "0.1", "600", "0.03"), True),
    "kernel, planetary, 48 balls (ns a ball-step)": (python(SIMULATE, "planetary", "10", "0.1", "300", "0.4"), True),
    "start of a simulation (s)": (python(SIMULATE, "emax", "10", "0.1", "600", "0.001"), False),
    "match of two mills (s)": (python(MATCH, "match", "planetary", "--like", "emax", "900", "10", "0.1"), False),
    "dry run of the thesis (s)": ([sys.executable, "-m", "snakemake", "-n", "--quiet", "all"], False),
}


@contextmanager
def checked_out(commits: list[str]) -> Iterator[list[Path]]:
    """A folder with the files of each commit; removed at the end."""
    with tempfile.TemporaryDirectory() as folder:
        places = [Path(folder) / str(number) for number in range(len(commits))]
        try:
            for commit, place in zip(commits, places, strict=True):
                subprocess.run(["git", "worktree", "add", "-q", "--detach", place, commit], check=True)
            yield places
        finally:
            for place in places:
                subprocess.run(["git", "worktree", "remove", "--force", place], check=False)


def timed(command: list[str], place: Path, prints: bool) -> float:
    """What a command takes in a folder. Raises RuntimeError, with its last line of error, where it fails."""
    own = os.environ | {"PYTHONPATH": str(place / "src"), "OMP_NUM_THREADS": "1"}
    before = os.times()
    done = subprocess.run(command, cwd=place, env=own, capture_output=True, text=True, check=False)
    after = os.times()
    if done.returncode:
        raise RuntimeError((done.stderr or done.stdout).strip().splitlines()[-1])
    if prints:
        return float(done.stdout.split()[-1])
    return after.children_user + after.children_system - before.children_user - before.children_system


def compared(places: list[Path], command: list[str], prints: bool, turns: int) -> dict[str, float]:
    """Medians of both commits, and the mean ratio of the second to the first with the half-width of its interval."""
    found = np.array([[timed(command, place, prints) for place in places] for _ in range(turns + 1)])[1:]
    ratios = found[:, 1] / found[:, 0]
    width = half_width([float(ratios.std(ddof=1)) / turns**0.5], turns) if turns > 1 else float("nan")
    first, second = np.median(found, axis=0)
    return {"first": float(first), "second": float(second), "ratio": float(ratios.mean()), "ratio_95": width}


def main() -> None:
    """Print a line for each part, and write them to results/bench/commits.tsv."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commits", nargs=2, metavar="COMMIT")
    parser.add_argument("--turns", type=int, default=5)
    parser.add_argument("--parts", nargs="+", default=[""], help="beginnings of names; all if left out")
    given = parser.parse_args()
    rows = []
    with checked_out(given.commits) as places:
        for name, (command, prints) in PARTS.items():
            if not name.startswith(tuple(given.parts)):
                continue
            try:
                row = compared(places, command, prints, given.turns)
            except RuntimeError as error:
                print(f"{name}: left out: {error}", flush=True)
                continue
            rows.append({"part": name, **row})
            told = "{first:.3g}, {second:.3g}; {ratio:.3f} +- {ratio_95:.3f} times".format(**row)
            print(f"{name}: {told}", flush=True)
    table = pd.DataFrame(rows).assign(commits=" ".join(given.commits), turns=given.turns)
    write_table(table, Path("results/bench/commits.tsv"))


if __name__ == "__main__":
    main()
