"""The jobs of a run, whatever planned them, and the simulations in them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, ball_count, overridden
from millprint.dem.timestep import rayleigh_time, requested_step
from millprint.errors import ConfigError

# The stages of a run, by the folder of results/logs that holds the logs of their jobs.
STAGES = {
    "dem": "simulations (DEM)",
    "doe": "chapter 2: design of experiments",
    "convergence": "time step and stiffness",
    "calibration": "calibration of the contact",
    "view": "pictures and animations",
    "fingerprint": "chapter 3: fingerprint",
    "partition": "chapter 4: shear and compression",
    "yields": "chapter 5: yield models",
    "surrogate": "chapter 6: surrogates of the DEM",
    "uncertainty": "uncertainty by the contact parameters",
    "dose": "energy spectra, dose, heat, wear",
    "mills": "other mills",
    "cards": "milling cards",
    "validation": "validation",
    "report": "report",
}


@dataclass(frozen=True)
class PlannedCase:
    """A simulation: its case, balls and steps, most rows of its table of collisions, and whether its result exists."""

    case: Case
    balls: int
    steps: int
    rows_max: int
    exists: bool

    @property
    def condition(self) -> str:
        """Its path without the seed."""
        return self.case.path.removesuffix(f"_s{self.case.seed}")


@dataclass(frozen=True)
class PlannedJob:
    """A job.

    needed: whether it is going to run. missing: whether one of its files does not exist yet; a job that is needed
    though its files exist runs again. stage: its folder of logs; name: that of its benchmark or log. after: places of
    the jobs in the plan that it waits for. cases: its simulations, if it is one of the rules of the DEM.
    """

    rule: str
    stage: str
    name: str
    needed: bool
    missing: bool
    threads: int
    after: tuple[int, ...]
    benchmark: Path | None = None
    log: Path | None = None
    outputs: tuple[Path, ...] = ()
    cases: tuple[PlannedCase, ...] = field(default=())

    @property
    def cases_to_run(self) -> tuple[PlannedCase, ...]:
        """A job that makes what is missing leaves its other cases as they are."""
        if not self.needed:
            return ()
        return tuple(each for each in self.cases if not (self.missing and each.exists))


def stage_title(stage: str) -> str:
    """A stage in words. Raises ConfigError for a folder of logs without one."""
    if stage not in STAGES:
        raise ConfigError(f"{stage}: no such stage; there are {', '.join(STAGES)}")
    return STAGES[stage]


def planned_case(case: Case, dem: DemConfig, mill: MillConfig, contact: ContactConfig, exists: bool) -> PlannedCase:
    """Balls and steps of a case; its window as configured, which may become longer. Raises as `overridden`."""
    _, contact = overridden(case, mill, contact)
    stiffness = contact.young_modulus_gpa * 1e9
    rayleigh = rayleigh_time(min(case.sizes_mm) / 2000, contact.density_kg_m3, stiffness, contact.poisson_ratio)
    simulated_s = case.settle_s + case.discard_s + case.window_s
    steps = simulated_s / requested_step(case, dem, rayleigh)
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_mm / 1000)
    return PlannedCase(case, balls, round(steps), dem.collision_rows_max, exists)


def needed_for(jobs: Sequence[PlannedJob], last: int) -> set[int]:
    """Places of all jobs that the job at place `last` waits for, directly or indirectly, and itself."""
    found, waiting = {last}, [last]
    while waiting:
        for before in jobs[waiting.pop()].after:
            if before not in found:
                found.add(before)
                waiting.append(before)
    return found
