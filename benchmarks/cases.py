"""A case of the benchmark: a jar, its balls, and the simulation of it by millprint."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from benchmarks.config import BenchConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import CircleMotion
from millprint.config.sweep import Case, DemConfig
from millprint.dem.simulation import Simulation
from millprint.mill.vessel import Vessel, build_vessel

# Ledger samples per revolution in millprint. The window that ends a timed run is one of them.
SAMPLES = 200

# The shortest settling time of a simulation [s]: one step of a jar at rest.
ONE_STEP_S = 1e-12


class BenchDem(DemConfig):
    """Settings of a benchmark."""

    ledger_samples_per_revolution: ClassVar[int] = SAMPLES


@dataclass(frozen=True)
class Jar:
    """A jar as a mill, and as a region of LAMMPS; `region` is empty if LAMMPS has no such shape."""

    name: str
    mill: MillConfig
    region: str = ""

    @cached_property
    def vessel(self) -> Vessel:
        """Its walls in millprint."""
        return build_vessel(self.mill)


@dataclass(frozen=True)
class Setup:
    """Everything that defines the motion of one jar of balls in either code."""

    jar: Jar
    contact: ContactConfig
    balls: int
    diameter_m: float
    speed_rpm: float
    time_step_s: float
    settle_s: float

    @property
    def mill(self) -> MillConfig:
        """The jar's mill."""
        return self.jar.mill

    @property
    def name(self) -> str:
        """Such as `cylinder_24x10mm`."""
        return f"{self.jar.name}_{self.balls}x{self.diameter_m * 1e3:g}mm"

    @property
    def amplitude_m(self) -> float:
        """Radius A of the mill's circle [m]."""
        assert isinstance(self.mill.motion, CircleMotion), "make_setup refuses any other motion"
        return self.mill.motion.amplitude_mm / 1e3

    @property
    def angular_frequency(self) -> float:
        """w of the mill's circle [rad/s]."""
        return 2 * np.pi * self.speed_rpm / 60

    def case(self, seed: int, **times: float) -> Case:
        """The case of millprint with this number of balls."""
        volume = np.pi / 6 * (self.diameter_m**3) * self.balls
        return Case(
            mill=self.mill.name,
            contact=self.contact.name,
            ball_diameter_m=self.diameter_m,
            fill_ratio=volume / (self.mill.volume_ml * 1e-6),
            speed_hz=self.speed_rpm / 60,
            seed=seed,
            **times,
        )

    def settings(self) -> DemConfig:
        """Settings with almost no output."""
        return BenchDem(
            time_step_s=self.time_step_s,
            settle_s=self.settle_s,
            window_s=1e-4,
            run_up_fraction=0,
        )

    def simulation(self, case: Case, start: np.ndarray | None = None) -> Simulation:
        """millprint's simulation of a case in this jar, from `start` (n, 3) [m] in its frame or the seed's packing."""
        return Simulation(case, self.mill, self.contact, self.settings(), start)


def emax_jar(mill: MillConfig) -> Jar:
    """The mill's own jar."""
    return Jar(mill.name, mill)


def cylinder_jar(config: BenchConfig, mill: MillConfig) -> Jar:
    """The mill with the cylinder, upright, in its jar's place; smooth in LAMMPS."""
    shape = config.cylinder
    region = f"cylinder z 0 0 {shape.radius_mm / 1e3!r} 0 {shape.height_mm / 1e3!r}"
    return Jar("cylinder", mill.model_copy(update={"geometry": shape, "inserts": []}), region)


def box_jar(config: BenchConfig, mill: MillConfig) -> Jar:
    """The mill with the box, whose six walls are the same in both codes, in its jar's place."""
    shape = config.physics.box
    x, y, height = shape.x_mm / 2e3, shape.y_mm / 2e3, shape.z_mm / 1e3
    region = f"block {-x!r} {x!r} {-y!r} {y!r} 0 {height!r}"
    return Jar("box", mill.model_copy(update={"geometry": shape, "inserts": []}), region)


def make_setup(config: BenchConfig, contact: ContactConfig, jar: Jar, balls: int, diameter_mm: float) -> Setup:
    """The setup of some balls in a jar; raises ConfigError for a mill whose motion is not a circle.

    LAMMPS is given one law for all contacts: a contact set with values of its own for walls is refused, and so is a jar
    with ends without friction.
    """
    if not isinstance(jar.mill.motion, CircleMotion):
        raise ConfigError(
            f"config/mills/{jar.mill.name}.yaml: motion.kind = {jar.mill.motion.kind!r}: the bench needs a circle"
        )
    if contact.has_own_walls:
        raise ConfigError(
            f"config/contacts/{contact.name}.yaml: wall_*: the bench has one law for balls and walls; leave these out"
        )
    if jar.mill.geometry.smooth_axis:
        raise ConfigError(f"benchmarks/bench.yaml: smooth_ends = true: the jar {jar.name} has rough walls only")
    diameter = diameter_mm / 1e3
    return Setup(jar, contact, balls, diameter, config.speed_rpm, config.time_step_s, config.settle_s)


def at_rest(mill: MillConfig) -> MillConfig:
    """The same mill at rest."""
    return MillConfig.model_validate({**mill.model_dump(), "motion": {"kind": "rest"}})


def settle(setup: Setup, seed: int) -> np.ndarray:
    """Positions (n, 3) [m] of balls that have come to rest, in the jar's own frame, from the seed's packing."""
    still = replace(setup, jar=replace(setup.jar, mill=at_rest(setup.mill)))
    # A jar at rest has samples at fractions of the window: one per step, so that the step is not reduced.
    window = SAMPLES * setup.time_step_s
    times = {"settle_s": setup.settle_s, "discard_s": 0, "window_s": window}
    simulation = still.simulation(setup.case(seed, **times))
    simulation.run(f"{setup.name}: settle")
    return simulation.balls.position.copy()


@dataclass(frozen=True)
class Timing:
    """Wall time and processor time [s] of a number of steps, and open contacts a ball at their end where known [-]."""

    steps: int
    balls: int
    wall_s: float
    processor_s: float
    contacts: float = math.nan

    @property
    def ns_per_ball_step(self) -> float:
        """Wall time per ball and step [ns]."""
        return self.wall_s / self.steps / self.balls * 1e9


def start_from(setup: Setup, start: np.ndarray, driven_s: float) -> Simulation:
    """A simulation whose mill starts at time 0, with balls at rest at `start` (n, 3) [m] in the jar's frame."""
    times = {"settle_s": ONE_STEP_S, "discard_s": driven_s, "window_s": 1e-9}
    return setup.simulation(setup.case(0, **times), start)


def time_millprint(setup: Setup, start: np.ndarray, driven_s: float) -> Timing:
    """Run the driven motion from `start` and time the kernel's loop; compiled code must be at hand."""
    simulation = start_from(setup, start, driven_s)
    simulation.run(f"{setup.name}: millprint")
    contacts = np.count_nonzero(simulation.contacts.slot >= 0) / setup.balls
    return Timing(count_steps(simulation), setup.balls, simulation.wall_clock_s, simulation.processor_s, contacts)


def count_steps(simulation: Simulation) -> int:
    """Number of steps of a run."""
    return simulation.settle_steps + simulation.discard_steps + simulation.window_steps + 1
