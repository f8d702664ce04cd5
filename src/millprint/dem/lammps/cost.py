"""What a simulation by LAMMPS takes, estimated. The Snakefile imports this, so no heavy imports here."""

from dataclasses import replace

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import LifterDrumGeometry, MillConfig
from millprint.config.sweep import Case, ball_count
from millprint.config.workflow import EngineConfig
from millprint.dem.resources import LIKELY_BALL_STEP_S, LIKELY_START_S, Resources, resources_of, runtime_of

# A ball and a step on one core without walls, of 20,000 balls in a smooth drum, and for each region of the walls (every
# lifter is one), of 764 balls in a drum with eight; contacts between balls are recorded (docs/how_to/lammps.md) [s].
LAMMPS_BALL_STEP_S, REGION_S = 4.3e-7, 1.25e-7
# Efficiency of n balls on each rank, 1 / (1 + SURFACE / n^(1/3)): what a rank exchanges and computes twice is at the
# surface of its part. SURFACE is that of 20,000 balls on 16 ranks (docs/how_to/lammps.md).
SURFACE = 5.5


def efficiency(balls: int, ranks: int) -> float:
    """Speed on some ranks over that on one, over their number [-]."""
    return 1.0 if ranks == 1 else 1 / (1 + SURFACE * (ranks / balls) ** (1 / 3))


def ball_step_s(mill: MillConfig) -> float:
    """Processor time of a ball and a step on one rank [s]."""
    shape = mill.geometry
    regions = 1 + (shape.smooth_axis is not None)
    if isinstance(shape, LifterDrumGeometry):
        # LAMMPS turns every ball into the frame of every lifter.
        regions += shape.lifters.number
    return LAMMPS_BALL_STEP_S + REGION_S * regions


def rank_step_s(balls: int, ranks: int, mill: MillConfig) -> float:
    """Wall time of a step [s]."""
    return balls * ball_step_s(mill) / ranks / efficiency(balls, ranks)


def lammps_resources(case: Case, dem: EngineConfig, mill: MillConfig, contact: ContactConfig) -> Resources:
    """What a case takes, as `resources_of`; processor_s: of all ranks together. Raises ConfigError as it does."""
    # LAMMPS has one step (`lammps_case`).
    own, ranks = resources_of(case, dem.model_copy(update={"run_up_fraction": 0.0}), mill, contact), dem.lammps.ranks
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_m)
    slower = ball_step_s(mill) / efficiency(balls, ranks) / LIKELY_BALL_STEP_S
    processor_s = LIKELY_START_S + (own.processor_s - LIKELY_START_S) * slower
    return replace(
        own,
        runtime_min=runtime_of(processor_s / ranks),
        threads=ranks,
        processor_s=processor_s,
        processor_max_s=processor_s,
    )
