"""Time, memory and disk of a job: a simulation from its balls and steps, every other one from a measured run.

`measured.tsv` has a row for each job of a run of the thesis and of a smoke run; `scripts/measure_costs.py` writes it.
"""

import csv
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from statistics import mean, median

from millprint.dem.resources import BALL_BYTES, COLLISION_BYTES, SNAPSHOT_COLUMNS
from millprint.plan.jobs import PlannedCase, PlannedJob

TABLE = Path(__file__).with_name("measured.tsv")

# Of the simulations of the thesis, on an Intel Xeon at 2.8 GHz with AVX-512, in November 2026. Processor time of a ball
# and a step [s]: 35 to 40 ns below 80 balls, 50 to 62 ns above.
BALL_STEP_S = 55e-9
# Fewer finished simulations say nothing about this machine.
CASES_MIN = 5
# Processor time for Snakemake to start a job, and for a simulation to import and write [s].
JOB_START_S, CASE_START_S = 2.0, 2.1
# Resident memory of a simulation: of Python and compiled code, and of a ball [MB]; the records come on top.
CASE_MB, BALL_MB = 260, BALL_BYTES * 1e-6
# run.h5: a collision of the table, a ball in a snapshot [bytes]; collisions of a ball in a second.
STORED_COLLISION_BYTES, STORED_SNAPSHOT_BYTES, COLLISIONS_HZ = 37, 38, 900
# Of a job that no run has measured: a figure or a table.
UNKNOWN_S, UNKNOWN_MB, UNKNOWN_DISK_MB = 4.0, 300.0, 0.1


@dataclass(frozen=True)
class Cost:
    """Processor time [s] with that of starting the job, largest resident memory [MB], size of what it writes [MB]."""

    processor_s: float
    memory_mb: float
    disk_mb: float
    measured: bool = True


@dataclass(frozen=True)
class Row:
    """A job of a measured run."""

    run: str
    rule: str
    job: str
    processor_s: float
    memory_mb: float
    disk_mb: float


@cache
def measured_rows(path: Path = TABLE) -> tuple[Row, ...]:
    """The rows of the table of measured runs."""
    with path.open(newline="") as file:
        rows = csv.DictReader((line for line in file if not line.startswith("#")), delimiter="\t")
        return tuple(
            Row(
                row["run"], row["rule"], row["job"],
                float(row["processor_s"]), float(row["memory_MB"]), float(row["disk_MB"]),
            )
            for row in rows
        )  # fmt: skip


def measured_when(path: Path = TABLE) -> str:
    """The comment at the head of the table: machine and date."""
    with path.open() as file:
        return file.readline().lstrip("# ").strip()


def own_ball_step(summaries: Iterable[Path]) -> float | None:
    """The processor time of a ball and a step in finished simulations [s]; None for fewer than CASES_MIN."""
    found = []
    for path in summaries:
        try:
            found.append(float(json.loads(path.read_text())["ns_per_ball_step"]))
        except (OSError, ValueError, KeyError):
            continue
    return median(found) * 1e-9 if len(found) >= CASES_MIN else None


def simulation_cost(cases: Sequence[PlannedCase], ball_step_s: float = BALL_STEP_S) -> Cost:
    """Simulations that run one after another in a job."""
    seconds = sum(each.balls * each.steps * ball_step_s for each in cases)
    return Cost(
        processor_s=JOB_START_S + CASE_START_S + seconds,
        memory_mb=CASE_MB + max(map(held_mb, cases), default=0.0),
        disk_mb=sum(map(run_size_mb, cases)),
    )


def recorded(planned: PlannedCase) -> tuple[float, float]:
    """Rows of the table of collisions, and balls in snapshots; with more collisions than a table may have, no rows."""
    case, balls = planned.case, planned.balls
    collisions = balls * COLLISIONS_HZ * case.window_s
    snapshots = case.window_s / case.snapshot_interval_s if case.snapshot_interval_s else 0.0
    return (collisions if collisions <= planned.rows_max else 0.0), balls * snapshots


def held_mb(planned: PlannedCase) -> float:
    """What a simulation holds in memory beside its code [MB]: balls, collisions up to the largest table, snapshots."""
    rows = min(planned.balls * COLLISIONS_HZ * planned.case.window_s, planned.rows_max)
    snapshots = recorded(planned)[1] * SNAPSHOT_COLUMNS * 8
    return BALL_MB * planned.balls + (COLLISION_BYTES * rows + snapshots) * 1e-6


def run_size_mb(planned: PlannedCase) -> float:
    """The size of the run.h5 of a simulation [MB]."""
    collisions, snapshots = recorded(planned)
    return (STORED_COLLISION_BYTES * collisions + STORED_SNAPSHOT_BYTES * snapshots) * 1e-6


def other_cost(job: PlannedJob, run: str, rows: Sequence[Row]) -> Cost:
    """A job by the same job of a measured run, or by the mean job of its rule.

    run: the name of the run that is planned; a measured run of this name counts first, then that of the thesis.
    """
    of_rule = [row for row in rows if row.rule == job.rule]
    for name in dict.fromkeys([run, "thesis", *(row.run for row in of_rule)]):
        own = [row for row in of_rule if row.run == name]
        chosen = [row for row in own if row.job == job.name] or own
        if chosen:
            return Cost(
                processor_s=JOB_START_S + mean(row.processor_s for row in chosen),
                memory_mb=max(row.memory_mb for row in chosen),
                disk_mb=mean(row.disk_mb for row in chosen),
            )
    return Cost(JOB_START_S + UNKNOWN_S, UNKNOWN_MB, UNKNOWN_DISK_MB, measured=False)


def cost_of(job: PlannedJob, run: str, rows: Sequence[Row], ball_step_s: float = BALL_STEP_S) -> Cost:
    """What a job takes that is going to run."""
    return simulation_cost(job.cases_to_run, ball_step_s) if job.cases else other_cost(job, run, rows)
