"""Set-ups that others measured: kinds of predictions, their quantities, and the files of config/validation.

They are constants and not keys: nobody tunes a prediction. To add a set-up of a kind, write a file.

What every set-up of the validation has; and shaken boxes: on a drive, on a leaf spring, and a pendulum.
"""

import math
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from pydantic import TypeAdapter

from millprint.config.charge import BallMixture, BallSize
from millprint.config.load import read_yaml, shipped
from millprint.config.mill import MillConfig
from millprint.config.section import Section
from millprint.config.sweep import Case, DemConfig, SweepConfig, balls_of, expand_sweep

Interval = tuple[float, float]


class SetupConfig(Section):
    """Settings of a set-up: its contact sets, its mill if it has one, and its simulations."""

    # The files that the prediction reads of each simulation.
    run_files: ClassVar[tuple[str, ...]] = ("summary.json",)
    # Tables of its own simulations in its own folder, which another rule writes before the prediction.
    own_tables: ClassVar[tuple[str, ...]] = ()

    contact: str
    """contact set of the prediction: a file in config/contacts"""
    further_contacts: list[str] = []
    """contact sets that are equally likely; the interval by contact parameters spans them all"""

    def without_intervals(self) -> "SetupConfig":
        """The set-up without the simulations that only its intervals need."""
        return self.model_copy(update={"further_contacts": []})

    @property
    def mill_name(self) -> str | None:
        """The mill, a file in config/mills; None for a set-up without one."""
        return getattr(self, "mill", None)

    @property
    def contact_names(self) -> list[str]:
        """Every contact set of the set-up, the one that predicts first."""
        return [self.contact, *self.further_contacts]

    @property
    def sweeps(self) -> list[SweepConfig]:
        """Its simulations in results/dem; none for a set-up that simulates on its own. Each sweep names its mills."""
        return []

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """The simulations that have no file in results/dem: a rule of the validation has them inside."""
        return []

    @property
    def further_s(self) -> float:
        """Processor time that simulations without a case and a mill are likely to take, for the plan of a run [s]."""
        return 0.0


# What a run takes of a processor [s], and for which number of balls.
SECONDS, BALLS = 10.0, 300


class ShakenConfig(SetupConfig):
    """A box of a square cross-section that moves up and down, with a pile of balls of one size."""

    ball_diameter_mm: float = 10.0
    """ball diameter [mm]"""
    side_diameters: float
    """side of the cross-section [ball diameters]"""
    balls: int
    """number of balls [-]"""
    seeds: list[int] = [0, 1, 2]
    """seeds of the starting positions; their scatter is the interval"""
    rayleigh_fraction: float = 0.15
    """step over the Rayleigh time [-]"""
    closure_max: float = 0.02
    """a simulation fails at this energy balance error over the wall work [-]"""

    def without_intervals(self) -> "ShakenConfig":
        """One seed, and nothing changed."""
        fewer: dict[str, list] = {"further_balls": [], "varied_amplitudes": []}
        own = {key: value for key, value in fewer.items() if key in type(self).model_fields}
        return self.model_copy(update={**own, "seeds": self.seeds[:1]})

    @property
    def side_m(self) -> float:
        """Side of the cross-section [m]."""
        return self.side_diameters * self.ball_diameter_mm / 1e3

    @property
    def runs(self) -> int:
        """Simulations of the set-up, apart from those at measured places [-]."""
        raise NotImplementedError

    @property
    def further_s(self) -> float:
        """About SECONDS for a run of BALLS balls."""
        return SECONDS * self.runs * self.balls / BALLS


class ShakenBoxConfig(ShakenConfig):
    """Set-up 21: a box without gravity, half full of many layers, and what must not change the energy lost in it."""

    speed_m_s: float
    """peak speed of the box, A w, at every amplitude [m/s]"""
    fill_share: float
    """thickness of the packed pile over the inner length [-]"""
    amplitudes: list[float]
    """amplitudes over the free gap, in addition to the measured ones [-]"""
    packing_amplitude: float
    """least amplitude over the free gap at which shaking packs the poured pile; a larger one packs it more [-]"""
    packing_periods: int
    """periods in which shaking packs the poured pile [-]"""
    discard_periods: int
    """further periods before the averages begin [-]"""
    window_periods: int
    """periods that are averaged [-]"""
    varied_amplitudes: list[float]
    """amplitudes over the free gap at which one thing is changed, with the first seed [-]"""
    further_speeds_m_s: list[float]
    """other speeds, and so frequencies [m/s]"""
    further_restitutions: list[float]
    """other coefficients of restitution [-]"""
    further_frictions: list[float]
    """other coefficients of friction [-]"""
    further_balls: list[int]
    """other numbers of balls, and so of layers [-]"""

    @property
    def changes(self) -> dict[str, list]:
        """What is changed, one at a time: the value of a run and its values."""
        return {
            "speed_m_s": self.further_speeds_m_s,
            "restitution": self.further_restitutions,
            "static_friction": self.further_frictions,
            "balls": self.further_balls,
        }

    @property
    def runs(self) -> int:
        """Those of each seed, and those with one thing changed."""
        changed = sum(map(len, self.changes.values())) * len(self.varied_amplitudes)
        return len(self.amplitudes) * len(self.seeds) + changed


class LeafSpringConfig(ShakenConfig):
    """Set-up 22: a box on a leaf spring without gravity, which swings freely and is stopped by the balls in it."""

    length_diameters: float
    """inner length [ball diameters]"""
    frequency_hz: float
    """frequency of the box without balls [Hz]"""
    amplitude_diameters: float
    """amplitude at the start [ball diameters]"""
    mass_ratio: float
    """mass of the box over that of all balls [-]"""
    further_balls: list[int]
    """other numbers of balls, in a box of the same ratio of masses; the interval spans them"""
    times_s: list[float]
    """times, in addition to the measured ones [s]"""

    @property
    def runs(self) -> int:
        """One of each seed and of each other number of balls."""
        return len(self.seeds) + len(self.further_balls)


class ShakenPlateConfig(ShakenConfig):
    """Set-up 23: layers of balls on a shaken plate under gravity."""

    frequency_hz: float
    """frequency of the plate [Hz]"""
    accelerations: list[float]
    """peak accelerations of the plate over gravity [-]"""
    discard_periods: int
    """periods before the averages begin [-]"""
    window_periods: int
    """periods that are averaged [-]"""

    @property
    def runs(self) -> int:
        """One of each acceleration and seed."""
        return len(self.accelerations) * len(self.seeds)


class TumblingConfig(SetupConfig):
    """A drum that lifts balls, at several speeds: power, toe and shoulder, and rings of centrifuging balls.

    Speeds are in the unit of the measured values: rpm, or per cent of `critical_speed_rpm` where that is given.
    """

    own_tables: ClassVar[tuple[str, ...]] = ("runs.tsv",)

    mill: str
    """mill: a file in config/mills"""
    ball_diameter_mm: BallSize
    """ball diameter, or a mixture of several sizes [mm]"""
    numbers: list[int]
    """numbers of balls; the first is that of the measured power"""
    fillings: list[float]
    """share of the drum that each number fills, voids included, for the power formulas [-]"""
    speeds: list[float]
    """speeds, in addition to the measured ones"""
    critical_speed_rpm: float | None = None
    """critical speed that the speeds are per cent of; left out, they are in rpm [rpm]"""
    drawn_speeds: list[float] = []
    """speeds at which the charge is drawn, for the first number of balls"""
    seeds: list[int] = [0, 1, 2]
    """seeds of the starting positions; their scatter is one of the two intervals"""
    settle_s: float = 0.3
    """time for the balls to come to rest before the drum turns [s]"""
    discard_turns: float = 0.75
    """revolutions before the averages begin [-]"""
    discard_s: float = 2.5
    """time before the averages begin, if that is longer [s]"""
    window_turns: float = 1.5
    """revolutions that are averaged [-]"""
    window_s: float = 4.0
    """time that is averaged, if that is longer [s]"""
    snapshots_per_turn: int = 67
    """records of the balls per revolution, for toe, shoulder and rings; not a multiple of the number of lifters [-]"""
    rayleigh_fraction: float = 0.15
    """step over the Rayleigh time of the smallest ball [-]"""
    closure_max: float = 0.01
    """a simulation fails at this energy balance error over the wall work [-]"""
    samples: int = 8
    """contact sets of the interval by contact parameters, a Latin hypercube over the four ranges below"""
    sample_speeds: list[float]
    """speeds at which these sets are simulated; between them the effect is interpolated"""
    restitution: Interval = (0.45, 0.90)
    """range of the coefficient of restitution, ball on ball and ball on wall [-]"""
    static_friction: Interval = (0.14, 0.70)
    """range of the static friction of ball on ball [-]"""
    wall_static_friction: Interval = (0.20, 0.70)
    """range of the static friction of ball on wall [-]"""
    rolling_friction: Interval = (0.0, 0.02)
    """range of the rolling friction [-]"""

    # Whether only measured speeds are simulated, of the numbers of balls that were measured.
    only_measured: bool | None = None

    def without_intervals(self) -> "TumblingConfig":
        """One seed and one contact set, at the measured speeds."""
        changed = {"seeds": self.seeds[:1], "samples": 0, "further_contacts": [], "only_measured": True}
        return self.model_copy(update=changed)

    def case(self, number: int, speed_rpm: float, seed: int, mill: MillConfig) -> Case:
        """The simulation of a number of balls at a speed [rpm]."""
        turn_s = 60 / speed_rpm
        return Case(
            mill=mill.name, contact=self.contact, **balls_of(self.ball_diameter_mm),
            fill_ratio=self.fill_ratio(number, mill.volume_ml), speed_hz=speed_rpm / 60, seed=seed,
            rayleigh_fraction=self.rayleigh_fraction, closure_max=self.closure_max, settle_s=self.settle_s,
            discard_s=max(self.discard_turns * turn_s, self.discard_s),
            window_s=max(self.window_turns * turn_s, self.window_s),
            snapshot_interval_s=turn_s / self.snapshots_per_turn,
        )  # fmt: skip

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """A case for each simulation at a speed of this section: every number, speed and seed, and the contact sets."""
        numbers = self.numbers[:1] if self.only_measured else self.numbers
        predicting = [(number, speed, seed) for seed in self.seeds for number in numbers for speed in self.speeds]
        sets = len(self.further_contacts) + self.samples
        others = [(self.numbers[0], speed, self.seeds[0]) for speed in self.sample_speeds] * sets
        return [self.case(number, self.speed_rpm(speed), seed, mill) for number, speed, seed in (*predicting, *others)]

    @property
    def diameter_mm(self) -> float:
        """The ball diameter, or that of the ball of mean volume [mm]."""
        size = self.ball_diameter_mm
        return size.mean_diameter_mm if isinstance(size, BallMixture) else size

    def speed_rpm(self, speed: float) -> float:
        """A speed of the set-up [rpm]."""
        return speed if self.critical_speed_rpm is None else speed / 100 * self.critical_speed_rpm

    def speed_of(self, speed_rpm: float) -> float:
        """A speed in rpm, in the unit of the set-up."""
        return speed_rpm if self.critical_speed_rpm is None else 100 * speed_rpm / self.critical_speed_rpm

    def fill_ratio(self, number: int, volume_ml: float) -> float:
        """Fill ratio of a number of balls in a mill of that nominal volume [-]."""
        return number * math.pi / 6 * self.diameter_mm**3 / (1e3 * volume_ml)


class DrumOfBallsConfig(SetupConfig):
    """A drum in which a bed of balls flows: one size, one fill ratio, one speed."""

    run_files: ClassVar[tuple[str, ...]] = ("run.h5",)

    mill: str
    """the drum, or a slice of it: a file in config/mills"""
    ball_diameter_mm: float
    """ball diameter [mm]"""
    fill_ratio: float
    """ball volume over the volume of the drum [-]"""
    speed_rpm: float
    """speed of the drum [rpm]"""
    rayleigh_fraction: float = 0.2
    """step over the Rayleigh time [-]"""
    closure_max: float = 0.02
    """a run fails at this energy balance error over the wall work, which is small in a slow drum [-]"""
    settle_s: float = 0.2
    """time for the balls to come to rest before the drum starts [s]"""
    discard_s: float
    """time of motion before the averages begin [s]"""
    window_s: float
    """time of motion that is averaged [s]"""
    snapshot_interval_s: float = 0.02
    """time between snapshots [s]"""
    blocks: int = 4
    """blocks of the window, whose scatter gives the interval at fixed contact parameters"""
    surface_share: float = 0.5
    """the surface is fitted over this share of the radius on both sides of the axis [-]"""

    def sweep(self, name: str, mill: str, contacts: list[str], seeds: list[int]) -> SweepConfig:
        """Simulations of one drum at the settings of this section."""
        return SweepConfig(
            name=name, mills=[mill], contacts=contacts, ball_diameters_mm=[self.ball_diameter_mm],
            fill_ratios=[self.fill_ratio], speeds_rpm=[self.speed_rpm], seeds=seeds,
            rayleigh_fraction=self.rayleigh_fraction, rayleigh_fraction_max=self.rayleigh_fraction,
            closure_max=self.closure_max, settle_s=self.settle_s, discard_s=self.discard_s, window_s=self.window_s,
            snapshot_interval_s=self.snapshot_interval_s,
        )  # fmt: skip


class BeadDrumConfig(DrumOfBallsConfig):
    """Set-up 4: speed over depth in a long drum of glass beads, from two slices of it (Alizadeh et al. 2013)."""

    short_mill: str
    """a shorter slice: it shows that the length is enough, and runs with every contact set"""
    half_width_diameters: float
    """half the width, along the surface, of the part about the axis in which speeds are averaged [ball diameters]"""
    half_height_diameters: float
    """half its height [ball diameters]"""

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The long slice with the contact set that predicts, the short one with all."""
        return [
            self.sweep("long", self.mill, [self.contact], [0]),
            self.sweep("short", self.short_mill, self.contact_names, [0]),
        ]


class ReposeDrumConfig(DrumOfBallsConfig):
    """Set-up 7: angle of repose in a short drum, its ends included, of spheres without known friction."""

    seeds: list[int]
    """seeds of the starting positions; their scatter is a part of the interval"""
    slice_mm: float
    """length of the slices in which contact parameters are varied, with smooth ends [mm]"""
    samples: int
    """slices, each with different contact parameters, drawn evenly at random from these intervals"""
    restitution: Interval
    """restitution [-]"""
    static_friction: Interval
    """static friction, of balls and of ball and wall [-]"""
    rolling_friction: Interval
    """rolling friction, in its logarithm [-]"""

    def without_intervals(self) -> "ReposeDrumConfig":
        """One seed, and no slices but the one with the set that predicts."""
        return self.model_copy(update={"seeds": self.seeds[:1], "samples": 0})

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The whole drum."""
        return [self.sweep("whole", self.mill, [self.contact], self.seeds)]

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """The slices, one with the set that predicts: each has its share of the drum's balls."""
        (whole,) = self.sweeps
        share = self.slice_mm / getattr(mill.geometry, "height_mm", self.slice_mm)
        shorter = whole.model_copy(update={"seeds": [0], "fill_ratios": [self.fill_ratio * share]})
        return list(expand_sweep(shorter, DemConfig(), mill.name)) * (self.samples + 1)


class ImpactConfig(SetupConfig):
    """A sphere hits a plate at rest; nothing else acts on it."""

    radius_mm: float
    """radius of the sphere [mm]"""
    steps_per_impact: int = 4000
    """steps in the duration of the elastic normal impact (Hertz) [-]"""
    restitution: Interval | None = None
    """interval of the coefficient of restitution; known exactly if left out [-]"""
    static_friction: Interval | None = None
    """interval of the friction coefficient; known exactly if left out [-]"""


class AluminaImpactConfig(ImpactConfig):
    """Set-up 3: a sphere of aluminium oxide on glass, at one speed and many angles (Kharaz, Gorham and Salman 2001)."""

    speed_m_s: float
    """speed of the sphere before the impact [m/s]"""
    angles_deg: list[float]
    """angles of incidence from the normal, in addition to the measured ones [deg]"""


class ElasticImpactConfig(ImpactConfig):
    """Set-up 9: an elastic sphere on a plate of its own material, at one normal speed (Chung and Ooi 2011, test 5)."""

    normal_speed_m_s: float
    """normal speed of the sphere before the impact [m/s]"""
    slopes: list[float]
    """tangential over mu times normal speed at the contact point, in addition to the measured ones [-]"""


KINDS: dict[str, type[SetupConfig]] = {
    "tumbling": TumblingConfig,
    "oblique_impact": AluminaImpactConfig,
    "elastic_impact": ElasticImpactConfig,
    "bead_drum": BeadDrumConfig,
    "repose_drum": ReposeDrumConfig,
    "shaken_box": ShakenBoxConfig,
    "leaf_spring": LeafSpringConfig,
    "shaken_plate": ShakenPlateConfig,
}


class Assumption(Section):
    """Something that the source does not state, or that we took from another source."""

    what: str
    value: str
    source: str


class SetupFile(Section):
    """A file of config/validation: what was measured, the settings of its prediction, and what is assumed."""

    kind: str
    """name in KINDS"""
    number: int
    """in the literature list of measured machines"""
    title: str
    """in figures and tables"""
    settings: dict[str, Any]
    """keys of its kind"""
    quick: dict[str, Any] = {}
    """in place of some of them, a coarse version that takes seconds, for a test of the workflow"""
    shared: str | None = None
    """a file of config/validation/shared with further assumptions"""
    assumptions: list[Assumption] = []

    def read(self, **changes: Any) -> SetupConfig:
        """The settings, with some in place of its own."""
        return KINDS[self.kind](**{**self.settings, **changes})


def _read_files() -> dict[str, SetupFile]:
    """The set-ups by the names of their files, in the order of their numbers."""
    folder = Path(str(shipped(FOLDER)))
    files = {path.stem: SetupFile.model_validate(read_yaml(path)) for path in sorted(folder.glob("*.yaml"))}
    for file in files.values():
        if file.shared:
            shared = read_yaml(folder / "shared" / f"{file.shared}.yaml")
            file.assumptions[:0] = TypeAdapter(list[Assumption]).validate_python(shared)
    return dict(sorted(files.items(), key=lambda item: item[1].number))


FOLDER = "config/validation"
FILES = _read_files()
SETTINGS = {name: file.read() for name, file in FILES.items()}
QUICK = {name: file.read(**file.quick) for name, file in FILES.items() if file.quick}


def read_settings(name: str, content: dict) -> SetupConfig:
    """The settings of a set-up from plain values: each set-up has its own class of them."""
    return type(SETTINGS[name])(**content)


def setup_cases(setup: SetupConfig, dem: DemConfig) -> dict[str, Case]:
    """The simulations of a set-up in results/dem, by path. Raises ValueError for a sweep that names no mill."""
    cases = {}
    for sweep in setup.sweeps:
        if not sweep.mills:
            raise ValueError(f"sweep {sweep.name} of a set-up names no mill")
        cases.update({case.path: case for case in expand_sweep(sweep, dem, sweep.mills[0])})
    return cases


POWER, RINGS, TOE, SHOULDER = "power", "complete rings of centrifuging balls", "toe angle", "shoulder angle"
TURN_ENERGY = "energy a revolution"
FLOW_SPEED, SURFACE_ANGLE = "speed down the slope", "angle of the surface"
STILL_PLACE = "place at which the speed is zero"
REPOSE = "angle of repose"
IMPACT = {
    "tangential restitution": "-",
    "spin after the impact": "rad/s",
    "rebound angle of the centre": "deg",
    "rebound angle of the contact point": "deg",
}
LOST, SWING = "energy lost a period over 4 m (A w)^2", "amplitude over ball diameter"
PLATE_POWER, PLATE_MEAN = "power over m g V", "mean power over m g V from 6 to 30 g"
LOSS_EXPONENT = "exponent of the loss factor over the acceleration"
SURFACE = "tangential over mu times normal velocity after the impact"


class Asked(NamedTuple):
    """A quantity that can be asked: its unit, and the x that it depends on; empty for a single number."""

    unit: str
    x: str = ""


ASKED: dict[type[SetupConfig], dict[str, Asked]] = {
    AluminaImpactConfig: {
        name: Asked(unit, "angle of incidence from the normal [deg]") for name, unit in IMPACT.items()
    },
    ElasticImpactConfig: {SURFACE: Asked("-", "tangential over mu times normal velocity before the impact [-]")},
    BeadDrumConfig: {
        FLOW_SPEED: Asked("m/s", "place along the normal of the surface, from the axis [m]"),
        SURFACE_ANGLE: Asked("deg"),
        STILL_PLACE: Asked("m"),
    },
    ReposeDrumConfig: {REPOSE: Asked("deg")},
    ShakenBoxConfig: {LOST: Asked("-", "amplitude over free gap, A / G [-]")},
    LeafSpringConfig: {SWING: Asked("-", "time [s]")},
    ShakenPlateConfig: {
        PLATE_POWER: Asked("-", "peak acceleration of the plate [g]"),
        PLATE_MEAN: Asked("-"),
        LOSS_EXPONENT: Asked("-"),
    },
}


def with_number(quantity: str, number: int, settings: TumblingConfig) -> str:
    """A quantity of a tumbling mill, with the number of balls unless it is the first of the set-up."""
    return quantity if number == settings.numbers[0] else f"{quantity}, {number} balls"


def quantities_of(setup: SetupConfig) -> dict[str, Asked]:
    """The quantities of a set-up by name."""
    return _of_tumbling(setup) if isinstance(setup, TumblingConfig) else ASKED[type(setup)]


def _of_tumbling(setup: TumblingConfig) -> dict[str, Asked]:
    # At a single speed, what is measured is the energy of a revolution.
    if len(setup.speeds) == 1:
        return {TURN_ENERGY: Asked("J/rev")}
    x = "speed [rpm]" if setup.critical_speed_rpm is None else "speed [% of the critical speed]"
    units = {POWER: "W", RINGS: "rings", TOE: "deg", SHOULDER: "deg"}
    return {
        with_number(name, number, setup): Asked(unit, x) for number in setup.numbers for name, unit in units.items()
    }
