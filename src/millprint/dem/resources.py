"""Time, memory and disk of a simulation, estimated. The Snakefile imports this, so no heavy imports here.

Requests to a cluster exceed the likely cost of a simulation; a plan states the likely cost.
"""

import math
from dataclasses import dataclass

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, ball_count, overridden, threads_of
from millprint.dem.laws.registry import step_scale
from millprint.dem.timestep import requested_step, run_up_step

# A ball-step of many balls takes 60 to 100 ns (benchmarks/timings.tsv) [s].
BALL_STEP_S = 1e-7
# What it is likely to take, from the simulations of the thesis on an Intel Xeon at 2.8 GHz with AVX-512, November 2026:
# 35 to 40 ns for a ball and a step below 80 balls, 50 to 62 ns above; and to import and to write [s].
LIKELY_BALL_STEP_S, LIKELY_START_S = 55e-9, 2.1
# Time to start and to write [min], and factor on the estimate.
START_MIN, MARGIN = 10, 3
# A longer case gets a cluster job of its own; shorter ones share a job [min].
LONG_MIN = 30

# Python with numpy and numba, compiling included [MB].
BASE_MB = 700
# Records are held in pieces, joined, and written.
COPIES = 3
# Numbers of a ball in a snapshot.
SNAPSHOT_COLUMNS = 12
# A row of the table of collisions; a ball's state, contacts and candidates, of a run of 200,000 balls
# (docs/how_to/speed.md) [bytes].
COLLISION_BYTES, BALL_BYTES = 96, 7500
# Collisions per ball and second: more than in any included mill.
COLLISIONS_HZ = 1000
# A run of more collisions keeps no table of them in run.h5.
COLLISION_ROWS_MAX = 3_000_000
# In run.h5: a collision of the table, a ball in a snapshot [bytes].
STORED_COLLISION_BYTES, STORED_SNAPSHOT_BYTES = 32, 38


@dataclass(frozen=True)
class Resources:
    """What one simulation takes.

    runtime_min: MARGIN times balls x steps x BALL_STEP_S, and START_MIN; runtime_max_min: the most of a request;
    memory_mb: of Python, the balls, and what the window records of snapshots and collisions; threads: of the job;
    seconds: balls x steps x BALL_STEP_S; processor_s: what it is likely to take [s], with a window that does not grow;
    processor_max_s: with the longest window;
    disk_mb: size of run.h5 [MB].
    """

    runtime_min: int
    runtime_max_min: int
    memory_mb: int
    threads: int
    seconds: float
    processor_s: float
    processor_max_s: float
    disk_mb: float

    @property
    def needs_own_job(self) -> bool:
        """Whether a cluster should run it apart from other simulations: it takes long, or has several threads."""
        return self.runtime_min > LONG_MIN or self.threads > 1

    def requested_min(self, attempt: int) -> int:
        """Time to request for an attempt, which goes on from the restart file of the one before [min]."""
        return min(attempt * self.runtime_min, self.runtime_max_min)


def resources_of(case: Case, dem: DemConfig, mill: MillConfig, contact: ContactConfig) -> Resources:
    """Estimate a case by its balls, its steps and what it records. Raises ConfigError as `overridden`."""
    _, contact = overridden(case, mill, contact)
    scale = step_scale(contact, min(case.sizes_m) / 2)
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_m)
    window = max(case.window_s, case.window_max_s or 0.0)
    before, step = (case.settle_s + case.discard_s) / run_up_step(case, dem, scale), requested_step(case, dem, scale)
    snapshots = window / case.snapshot_interval_s if case.snapshot_interval_s else 0
    collisions = min(balls * window * COLLISIONS_HZ, COLLISION_ROWS_MAX)
    recorded = balls * snapshots * SNAPSHOT_COLUMNS * 8 + collisions * COLLISION_BYTES
    seconds = balls * (before + window / step) * BALL_STEP_S
    # A table with more collisions than it may have is not written.
    rows = balls * case.window_s * COLLISIONS_HZ
    stored = (rows if rows < COLLISION_ROWS_MAX else 0) * STORED_COLLISION_BYTES
    stored += balls * snapshots * STORED_SNAPSHOT_BYTES
    return Resources(
        runtime_min=runtime_of(seconds),
        runtime_max_min=math.ceil(60 * dem.runtime_max_h),
        memory_mb=BASE_MB + math.ceil((COPIES * recorded + balls * BALL_BYTES) / 1e6),
        threads=threads_of(case, dem),
        seconds=seconds,
        processor_s=LIKELY_START_S + balls * (before + case.window_s / step) * LIKELY_BALL_STEP_S,
        processor_max_s=LIKELY_START_S + balls * (before + window / step) * LIKELY_BALL_STEP_S,
        disk_mb=stored / 1e6,
    )


def runtime_of(seconds: float) -> int:
    """The time to request for a simulation of an estimated length [min]."""
    return START_MIN + math.ceil(MARGIN * seconds / 60)
