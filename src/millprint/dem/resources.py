"""The step of a case, and its time, memory and disk, estimated. The Snakefile imports this, so no heavy imports here.

Requests to a cluster exceed the likely cost of a simulation; a plan states the likely cost.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations_with_replacement

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import SimulationError
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, ball_count, overridden, threads_of
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import law_of, step_scale

# The skin over the smallest ball's radius and the root of the step over the Rayleigh time [-].
SKIN_SHARE = 1.5
# The longest step of which nothing is recorded, over the recorded one.
LONGEST_RUN_UP = 4
# Side of the square cells of the grid of occupancy [m], and the time between its samples [s].
OCCUPANCY_CELL_M, OCCUPANCY_INTERVAL_S = 0.002, 5e-4


def aligned_step(longest_s: float, interval_s: float) -> tuple[float, int]:
    """The largest step [s] up to `longest_s` of which a whole number makes `interval_s`, and that number."""
    steps = max(1, math.ceil(interval_s / longest_s - 1e-9))
    return interval_s / steps, steps


def requested_step(case: Case, dem: DemConfig, scale_s: float) -> float:
    """The requested step of a case [s]: its own, its fraction of the law's scale, or that of `dem`."""
    if case.time_step_s:
        return case.time_step_s
    if case.rayleigh_fraction:
        return case.rayleigh_fraction * scale_s
    return dem.time_step_s


def run_up_step(case: Case, dem: DemConfig, scale_s: float) -> float:
    """The requested step while balls settle and until the window begins [s], of which nothing is recorded.

    `dem.run_up_fraction` of the law's scale, and one to LONGEST_RUN_UP times the recorded one: where balls are so soft
    or fast that this has to be short, a far longer one is too long. A case with snapshots has one step: its motion,
    which other runs go on from, does not depend on when its window begins.
    """
    recorded = requested_step(case, dem, scale_s)
    if case.snapshot_interval_s:
        return recorded
    longer = min(dem.run_up_fraction, dem.rayleigh_fraction_max) * scale_s
    return min(max(recorded, longer), LONGEST_RUN_UP * recorded)


def longest_step(
    ball_diameter_m: float, cases: Iterable[Case], contacts: Mapping[str, ContactConfig], dem: DemConfig
) -> float:
    """The longest requested step [s] of the cases with balls of a diameter [m] and the density of their contact set.

    That of `dem` if there are none.
    """
    steps = []
    for case in cases:
        if (case.ball_diameter_m, case.mixture, case.density_kg_m3) == (ball_diameter_m, None, None):
            scale_s = step_scale(contacts[case.contact], ball_diameter_m / 2)
            steps.append(requested_step(case, dem, scale_s))
    return max(steps, default=dem.time_step_s)


def largest_fraction(case: Case, dem: DemConfig) -> float:
    """The largest step that is allowed for a case, over its scale [-]."""
    return case.rayleigh_fraction_max or dem.rayleigh_fraction_max


def skin_of(radius_m: float, step_over_scale: float) -> float:
    """The skin of the lists of candidates [m]: SKIN_SHARE R sqrt(step / scale). A contact is listed at a smaller gap.

    Lists are made again when a ball has moved by half the skin, so that their cost in a step goes with step / skin.
    That of going through them goes with their length, and so with skin / R. The sum is least where the skin goes with
    the root of R times the step, and the Rayleigh time goes with R.
    """
    return SKIN_SHARE * radius_m * math.sqrt(step_over_scale)


def resolved_step(contact: ContactConfig, radius_m: float, wanted_s: float, rayleigh_fraction_max: float) -> float:
    """The requested step [s], or a shorter one if the law requires it for a ball."""
    return min(wanted_s, rayleigh_fraction_max * step_scale(contact, radius_m))


def check_cohesion(contact: ContactConfig, radii_m: list[float], overlap_max: float) -> None:
    """Check that no pull presses balls of these radii [m] farther than the bound, over the smaller radius [-].

    Raises SimulationError that names the key, and the largest value that the springs carry.
    """
    if contact.cohesion is None:
        return
    pairs = [("ball_ball", a, b, a * b / (a + b)) for a, b in combinations_with_replacement(radii_m, 2)]
    for pair, a, b, radius in [*pairs, *(("ball_wall", a, math.inf, a) for a in radii_m)]:
        law, pull, limit = law_of(contact), contact.cohesion.pull_N(pair, radius), overlap_max * min(a, b)
        carried = law.springs(limit, *law.coefficients(contact, radius, ball_mass(contact, min(a, b))))[0]
        if pull > carried:
            key = f"{pair}_N" if getattr(contact.cohesion, f"{pair}_N") is not None else f"{pair}_J_m2"
            value = getattr(contact.cohesion, key)
            raise SimulationError(
                f"contact set {contact.name}: cohesion.{key} = {value:g}: its pull of {pull:.3g} N presses a ball of "
                f"{2e3 * min(a, b):g} mm in by more than dem.overlap_max = {overlap_max:g} of its radius; at most "
                f"{value * carried / pull:.3g} with these springs"
            )


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
    processor_s: what it is likely to take [s], with a window that does not grow;
    processor_max_s: with the longest window;
    disk_mb: size of run.h5 [MB].
    """

    runtime_min: int
    runtime_max_min: int
    memory_mb: int
    threads: int
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


def ball_steps(case: Case, dem: DemConfig, contact: ContactConfig, balls: int) -> tuple[float, float]:
    """Balls times steps of a case as it is likely to run, and with the longest window.

    contact: the set as the case runs it. A whole number of steps makes the time between snapshots.
    """
    scale = step_scale(contact, min(case.sizes_m) / 2)
    longer, step = run_up_step(case, dem, scale), requested_step(case, dem, scale)
    # Of a step so small that their ratio is not finite, any number does.
    if case.snapshot_interval_s and case.snapshot_interval_s < 1e15 * step:
        longer = step = aligned_step(step, case.snapshot_interval_s)[0]
    before = (case.settle_s + case.discard_s) / longer
    windows = case.window_s, max(case.window_s, case.window_max_s or 0.0)
    return balls * (before + windows[0] / step), balls * (before + windows[1] / step)


def resources_of(case: Case, dem: DemConfig, mill: MillConfig, contact: ContactConfig) -> Resources:
    """Estimate a case by its balls, its steps and what it records. Raises ConfigError as `overridden`."""
    _, contact = overridden(case, mill, contact)
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_m)
    window = max(case.window_s, case.window_max_s or 0.0)
    likely, most = ball_steps(case, dem, contact, balls)
    snapshots = window / case.snapshot_interval_s if case.snapshot_interval_s else 0
    collisions = min(balls * window * COLLISIONS_HZ, COLLISION_ROWS_MAX)
    recorded = balls * snapshots * SNAPSHOT_COLUMNS * 8 + collisions * COLLISION_BYTES
    # A table with more collisions than it may have is not written.
    rows = balls * case.window_s * COLLISIONS_HZ
    stored = (rows if rows < COLLISION_ROWS_MAX else 0) * STORED_COLLISION_BYTES
    stored += balls * snapshots * STORED_SNAPSHOT_BYTES
    return Resources(
        runtime_min=runtime_of(most * BALL_STEP_S),
        runtime_max_min=math.ceil(60 * dem.runtime_max_h),
        memory_mb=BASE_MB + math.ceil((COPIES * recorded + balls * BALL_BYTES) / 1e6),
        threads=threads_of(case, dem),
        processor_s=LIKELY_START_S + likely * LIKELY_BALL_STEP_S,
        processor_max_s=LIKELY_START_S + most * LIKELY_BALL_STEP_S,
        disk_mb=stored / 1e6,
    )


def runtime_of(seconds: float) -> int:
    """The time to request for a simulation of an estimated length [min]."""
    return START_MIN + math.ceil(MARGIN * seconds / 60)
