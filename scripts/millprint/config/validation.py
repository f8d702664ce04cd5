"""The section `validation`: set-ups that others measured, and the settings by which each is predicted.

The settings of a set-up are fixed before the prediction is held against the measured values: `python
scripts/fix_predictions.py` records their digest and the date. To add a set-up, write a section with its defaults here
and a record in millprint/validation/setups.py, of the same name.
"""

import math
from typing import Annotated, Any, ClassVar

from pydantic import Field, model_validator

from millprint.config.mixture import BallMixture, BallSize
from millprint.config.section import (
    Fraction,
    Name,
    Positive,
    PositiveSpeed,
    ProjectFile,
    Section,
    Seed,
    first_repeated,
)
from millprint.config.sweep import Case, DemConfig, SweepConfig, expand_sweep

Interval = tuple[float, float]
# The name that stands for every set-up.
ALL = "all"
Angle = Annotated[float, Field(gt=0, lt=90)]


class SetupConfig(Section):
    """Settings of a set-up: its contact sets, its mill if it has one, and its simulations."""

    # Keys that say where is predicted, such as at which speeds: they change no number, and so no digest.
    places: ClassVar[tuple[str, ...]] = ()

    contact: Name
    """contact set that predicts: a file in config/contacts"""
    further_contacts: list[Name] = []
    """contact sets that are as likely; the interval by contact parameters spans them all"""

    @classmethod
    def __pydantic_init_subclass__(cls, **options: Any) -> None:
        """A key of which a set-up replaces the default alone keeps its description."""
        super().__pydantic_init_subclass__(**options)
        bare = [name for name, field in cls.model_fields.items() if field.description is None]
        for name in bare:
            parents = (parent.model_fields.get(name) for parent in cls.__mro__[1:] if issubclass(parent, Section))
            cls.model_fields[name].description = next((field.description for field in parents if field), None)
        if bare:
            cls.model_rebuild(force=True)

    @property
    def mill_name(self) -> str | None:
        """The mill, a file in config/mills; None for a set-up without one."""
        return None

    @property
    def further_mills(self) -> list[str]:
        """Mills beside it that its sweeps simulate, such as a shorter slice."""
        return []

    @property
    def contact_names(self) -> list[str]:
        """Every contact set of the set-up, the one that predicts first."""
        return [self.contact, *self.further_contacts]

    @property
    def sweeps(self) -> list[SweepConfig]:
        """Its simulations in results/dem; none for a set-up that simulates on its own. Each sweep names its mills."""
        return []

    @property
    def run_files(self) -> tuple[str, ...]:
        """The files that the prediction reads of each simulation."""
        return ("summary.json",)

    @property
    def own_tables(self) -> tuple[str, ...]:
        """Tables of its own simulations in its own folder, which another rule writes before the prediction."""
        return ()


class ImpactConfig(SetupConfig):
    """A sphere hits a plate at rest; nothing else acts on it."""

    radius_mm: Positive
    """radius of the sphere [mm]"""
    steps_per_impact: Annotated[int, Field(ge=100, le=1_000_000)] = 4000
    """steps in the duration of the elastic normal impact (Hertz) [-]"""
    restitution: Interval | None = None
    """interval of the coefficient of restitution; known exactly if left out [-]"""
    static_friction: Interval | None = None
    """interval of the friction coefficient; known exactly if left out [-]"""

    @model_validator(mode="after")
    def _intervals_rise(self) -> "ImpactConfig":
        for key, most in (("restitution", 1.0), ("static_friction", 100.0)):
            interval = getattr(self, key)
            if interval and not 0 < interval[0] <= interval[1] <= most:
                raise ValueError(f"{key} = {list(interval)}: two numbers above 0 and up to {most:g}, the smaller first")
        return self


class AluminaImpactConfig(ImpactConfig):
    """Set-up 3: a sphere of aluminium oxide on glass, at one speed and many angles (Kharaz, Gorham and Salman 2001)."""

    places = ("angles_deg",)

    contact: Name = "alumina_on_glass"
    radius_mm: Positive = 2.5
    restitution: Interval | None = (0.97, 0.99)
    static_friction: Interval | None = (0.087, 0.097)
    speed_m_s: Positive = 3.9
    """speed of the sphere before the impact [m/s]"""
    angles_deg: list[Angle] = Field(default=[float(a) for a in (*range(1, 15), *range(15, 90, 5), 88)], min_length=1)
    """angles of incidence from the normal, beside the measured ones [deg]"""


class ElasticImpactConfig(ImpactConfig):
    """Set-up 9: an elastic sphere on a plate of its own material, at one normal speed (Chung and Ooi 2011, test 5)."""

    places = ("slopes",)

    contact: Name = "steel_elastic"
    radius_mm: Positive = 0.01
    normal_speed_m_s: Positive = 5.0
    """normal speed of the sphere before the impact [m/s]"""
    slopes: list[Positive] = Field(default=[0.1, 0.5, 1.0, 1.5, 2.0, 2.5, *map(float, range(3, 15))], min_length=1)
    """tangential over mu times normal speed at the contact point, beside the measured ones [-]"""


class ShakerConfig(SetupConfig):
    """Row 8a: a shaker mill of the class of SPEX 8000, of which neither balls nor vial are known."""

    contact: Name = "steel"
    mill: Name = "spex"
    """mill: a file in config/mills"""
    ball_diameters_mm: Annotated[list[Positive], Field(min_length=1)] = [12.7, 6.35]
    """ball diameters, each a charge of its own [mm]"""
    fill_ratio: Fraction = 0.06
    """ball volume over the mill's nominal volume [-]"""
    speed_rpm: PositiveSpeed = 1050.0
    """cycles of the arm [1/min]"""
    seeds: Annotated[list[Seed], Field(min_length=1)] = [0, 1]
    """seeds of the starting positions"""
    discard_s: Positive = 0.5
    """time before the record begins [s]"""
    window_s: Positive = 2.0
    """recorded time [s]"""
    interval_s: Positive = 2e-3
    """time between two records of the balls [s]"""
    share: Fraction = 0.8
    """share of all speeds that the range holds [-]"""

    @property
    def mill_name(self) -> str:
        """The mill."""
        return self.mill

    @property
    def run_files(self) -> tuple[str, ...]:
        """The records of the balls."""
        return ("run.h5",)

    @property
    def sweeps(self) -> list[SweepConfig]:
        """A charge of each size with each seed."""
        return [
            SweepConfig(
                name="spex_shaker", mills=[self.mill], contacts=self.contact_names,
                ball_diameters_mm=self.ball_diameters_mm, fill_ratios=[self.fill_ratio], speeds_rpm=[self.speed_rpm],
                seeds=self.seeds, rayleigh_fraction=0.024, discard_s=self.discard_s, window_s=self.window_s,
                snapshot_interval_s=self.interval_s,
            )
        ]  # fmt: skip


class DrumOfBallsConfig(SetupConfig):
    """A drum in which a bed of balls flows: one size, one fill ratio, one speed."""

    mill: Name
    """the drum, or a slice of it: a file in config/mills"""
    ball_diameter_mm: Positive
    """ball diameter [mm]"""
    fill_ratio: Fraction
    """ball volume over the volume of the drum [-]"""
    speed_rpm: PositiveSpeed
    """speed of the drum [rpm]"""
    rayleigh_fraction: Fraction = 0.2
    """step over the Rayleigh time [-]"""
    closure_max: Fraction = 0.02
    """a run fails at this energy balance error over the wall work, which is small in a slow drum [-]"""
    settle_s: Positive = 0.2
    """time for the balls to come to rest before the drum starts [s]"""
    discard_s: Positive
    """time of motion before the averages begin [s]"""
    window_s: Positive
    """time of motion that is averaged [s]"""
    snapshot_interval_s: Positive = 0.02
    """time between snapshots [s]"""
    blocks: Annotated[int, Field(ge=2, le=100)] = 4
    """blocks of the window, whose scatter is the interval without that by contact parameters"""
    surface_share: Fraction = 0.5
    """the surface is fitted over this share of the radius on both sides of the axis [-]"""

    @property
    def mill_name(self) -> str | None:
        """The drum, or the slice that predicts."""
        return self.mill

    @property
    def run_files(self) -> tuple[str, ...]:
        """The snapshots."""
        return ("run.h5",)

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

    contact: Name = "glass_beads"
    """contact set that predicts: a file in config/contacts"""
    further_contacts: list[Name] = ["glass_beads_clean"]
    """contact sets that bound it; the interval by contact parameters spans them"""
    mill: Name = "bead_drum"
    """the drum, or a slice of it: a file in config/mills"""
    short_mill: Name = "bead_drum_short"
    """a shorter slice: it shows that the length is enough, and runs with every contact set"""
    ball_diameter_mm: Positive = 3.0
    """ball diameter [mm]"""
    fill_ratio: Fraction = 0.1962
    """ball volume over the volume of the drum [-]"""
    speed_rpm: PositiveSpeed = 11.6
    """speed of the drum [rpm]"""
    discard_s: Positive = 1.55
    """time of motion before the averages begin [s]"""
    window_s: Positive = 2.08
    """time of motion that is averaged [s]"""
    half_width_diameters: Positive = 1.5
    """half the width, along the surface, of the part about the axis in which speeds are averaged [ball diameters]"""
    half_height_diameters: Positive = 0.5
    """half its height [ball diameters]"""

    @property
    def further_mills(self) -> list[str]:
        """The shorter slice."""
        return [self.short_mill]

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The long slice with the contact set that predicts, the short one with all."""
        return [
            self.sweep("long", self.mill, [self.contact], [0]),
            self.sweep("short", self.short_mill, self.contact_names, [0]),
        ]


class ReposeDrumConfig(DrumOfBallsConfig):
    """Set-up 7: angle of repose in a short drum, its ends included, of spheres without known friction."""

    contact: Name = "generic_spheres"
    """contact set that predicts: a file in config/contacts"""
    mill: Name = "repose_drum"
    """the drum, or a slice of it: a file in config/mills"""
    ball_diameter_mm: Positive = 5.95
    """ball diameter [mm]"""
    fill_ratio: Fraction = 0.23916
    """ball volume over the volume of the drum [-]"""
    speed_rpm: PositiveSpeed = 20.99
    """speed of the drum [rpm]"""
    discard_s: Positive = 1.43
    """time of motion before the averages begin [s]"""
    window_s: Positive = 1.43
    """time of motion that is averaged [s]"""
    seeds: list[Seed] = Field(default=[0, 1], min_length=2)
    """seeds of the starting positions; their scatter is a part of the interval"""
    slice_mm: Positive = 30.0
    """length of the slices in which contact parameters are varied, with smooth ends [mm]"""
    samples: Annotated[int, Field(ge=2, le=1000)] = 8
    """slices, each with contact parameters of its own, drawn at random but evenly from these intervals"""
    restitution: Interval = (0.2, 0.95)
    """restitution [-]"""
    static_friction: Interval = (0.08, 0.8)
    """static friction, of balls and of ball and wall [-]"""
    rolling_friction: Interval = (0.005, 0.09)
    """rolling friction, in its logarithm [-]"""

    @model_validator(mode="after")
    def _intervals_rise(self) -> "ReposeDrumConfig":
        for key, most in (("restitution", 1.0), ("static_friction", 100.0), ("rolling_friction", 100.0)):
            low, high = getattr(self, key)
            if not 0 < low < high <= most:
                raise ValueError(f"{key} = {[low, high]}: two numbers above 0 and up to {most:g}, the smaller first")
        return self

    @property
    def sweeps(self) -> list[SweepConfig]:
        """The whole drum."""
        return [self.sweep("whole", self.mill, [self.contact], self.seeds)]


class TumblingConfig(SetupConfig):
    """A drum that lifts balls, at several speeds: power, toe and shoulder, and rings of centrifuging balls.

    Speeds are in the unit of the measured values: rpm, or per cent of `critical_speed_rpm` where that is given.
    """

    places: ClassVar[tuple[str, ...]] = ("speeds", "drawn_speeds")

    mill: Name
    """mill: a file in config/mills"""
    ball_diameter_mm: BallSize
    """ball diameter, or a mixture of several sizes [mm]"""
    numbers: list[Annotated[int, Field(ge=1, le=100_000)]] = Field(min_length=1)
    """numbers of balls; the first is that of the measured power"""
    fillings: list[Fraction] = Field(min_length=1)
    """share of the drum that each number fills, voids included, for the power formulas [-]"""
    speeds: list[Positive] = Field(min_length=1)
    """speeds, beside the measured ones"""
    critical_speed_rpm: Positive | None = None
    """critical speed that the speeds are per cent of; left out, they are in rpm [rpm]"""
    drawn_speeds: list[Positive] = []
    """speeds of which the charge is drawn, for the first number of balls"""
    seeds: Annotated[list[Seed], Field(min_length=2, max_length=100)] = [0, 1, 2]
    """seeds of the starting positions; their scatter is one of the two intervals"""
    settle_s: Positive = 0.3
    """time for the balls to come to rest before the drum turns [s]"""
    discard_turns: Positive = 0.75
    """revolutions before the averages begin [-]"""
    discard_s: Positive = 2.5
    """time before the averages begin, if that is longer [s]"""
    window_turns: Positive = 1.5
    """revolutions that are averaged [-]"""
    window_s: Positive = 4.0
    """time that is averaged, if that is longer [s]"""
    snapshots_per_turn: Annotated[int, Field(ge=12, le=720)] = 67
    """places of the balls a revolution, for toe, shoulder and rings; no multiple of the number of lifters [-]"""
    rayleigh_fraction: Fraction = 0.15
    """step over the Rayleigh time of the smallest ball [-]"""
    closure_max: Fraction = 0.01
    """a simulation fails at this energy balance error over the wall work [-]"""
    samples: Annotated[int, Field(ge=2, le=1000)] = 8
    """contact sets of the interval by contact parameters, a Latin hypercube over the four ranges below"""
    sample_speeds: list[Positive] = Field(min_length=1)
    """speeds at which they are simulated; in between their effect is interpolated"""
    restitution: Interval = (0.45, 0.90)
    """range of the coefficient of restitution, ball on ball and ball on wall [-]"""
    static_friction: Interval = (0.14, 0.70)
    """range of the static friction of ball on ball [-]"""
    wall_static_friction: Interval = (0.20, 0.70)
    """range of the static friction of ball on wall [-]"""
    rolling_friction: Interval = (0.0, 0.02)
    """range of the rolling friction [-]"""

    @model_validator(mode="after")
    def _fits_together(self) -> "TumblingConfig":
        if len(self.fillings) != len(self.numbers):
            raise ValueError(f"fillings = {self.fillings}: must hold one value for each of {len(self.numbers)} numbers")
        for key in ("restitution", "static_friction", "wall_static_friction", "rolling_friction"):
            low, high = getattr(self, key)
            if not 0 <= low < high <= (1 if key == "restitution" else 100):
                raise ValueError(f"{key} = [{low:g}, {high:g}]: the smaller first, and a number that it can have")
        return self

    @property
    def mill_name(self) -> str:
        """The mill."""
        return self.mill

    @property
    def own_tables(self) -> tuple[str, ...]:
        """The table of its runs."""
        return ("runs.tsv",)

    @property
    def diameter_mm(self) -> float:
        """The ball diameter, or that of the ball of mean volume [mm]."""
        size = self.ball_diameter_mm
        return size.mean_diameter_mm if isinstance(size, BallMixture) else size

    def speed_rpm(self, speed: float) -> float:
        """A speed of the set-up [rpm]."""
        return speed if self.critical_speed_rpm is None else speed / 100 * self.critical_speed_rpm

    def fill_ratio(self, number: int, volume_ml: float) -> float:
        """Fill ratio of a number of balls in a mill of that nominal volume [-]."""
        return number * math.pi / 6 * self.diameter_mm**3 / (1e3 * volume_ml)


SLICE_SPEEDS = [20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 100.0, 110.0, 120.0, 140.0, 160.0]


class SliceMillConfig(TumblingConfig):
    """Set-up 1: the slice mill of Hlungwani, Rikhotso, Dong and Moys (2003), as Govender and others (2015) print it."""

    contact: Name = "slice_mill"
    further_contacts: list[Name] = ["slice_mill_elastic", "steel"]
    mill: Name = "slice_mill"
    ball_diameter_mm: BallSize = 22.0
    numbers: list[Annotated[int, Field(ge=1, le=100_000)]] = [120, 169]
    fillings: list[Fraction] = [0.25, 0.35]
    speeds: list[Positive] = Field(default=SLICE_SPEEDS, min_length=1)
    critical_speed_rpm: Positive | None = 58.3
    drawn_speeds: list[Positive] = [30.0, 70.0, 100.0, 140.0]
    sample_speeds: list[Positive] = Field(default=[30.0, 70.0, 110.0, 140.0], min_length=1)


class DrumConfig(TumblingConfig):
    """Set-up 2: the drum of 90 cm of Venugopal and Rajamani (2001), as Govender and others (2015) print it."""

    contact: Name = "drum_90cm"
    further_contacts: list[Name] = ["steel"]
    mill: Name = "drum_90cm"
    ball_diameter_mm: BallSize = 50.8
    numbers: list[Annotated[int, Field(ge=1, le=100_000)]] = [168]
    fillings: list[Fraction] = [0.20]
    speeds: list[Positive] = Field(default=[9.0, 14.0, 18.0, 22.0, 27.0, 32.0, 37.0, 42.0], min_length=1)
    drawn_speeds: list[Positive] = [14.0, 22.0, 32.0, 42.0]
    sample_speeds: list[Positive] = Field(default=[14.0, 22.0, 32.0], min_length=1)


BOND_CHARGE = BallMixture(name="bond", sizes_mm=(36.83, 29.72, 25.40, 19.05, 15.49), numbers=(43, 67, 10, 71, 94))


class BondMillConfig(TumblingConfig):
    """Set-up 5: the laboratory mill of the Bond work index."""

    contact: Name = "balls_in_ore"
    further_contacts: list[Name] = ["steel"]
    mill: Name = "bond_mill"
    ball_diameter_mm: BallSize = BOND_CHARGE
    numbers: list[Annotated[int, Field(ge=1, le=100_000)]] = [285]
    fillings: list[Fraction] = [0.19]
    speeds: list[Positive] = Field(default=[70.0], min_length=1)
    drawn_speeds: list[Positive] = [70.0]
    discard_s: Positive = 2.0
    window_s: Positive = 3.0
    sample_speeds: list[Positive] = Field(default=[70.0], min_length=1)


class ValidationConfig(Section):
    """What others measured, predicted without a fit: target `validation`."""

    setups: list[Name] = []
    """set-ups to predict: names of the sections below, or `all`; none if left out"""
    in_all: bool = False
    """whether the validation is a part of `all`, and so of the report of a run with chapters"""
    measured: ProjectFile = "config/data/measured.tsv"
    """what others measured, with sources"""
    fixed: ProjectFile = "config/data/fixed_predictions.tsv"
    """when the settings of each set-up were fixed, and their digest"""
    alumina_impact: AluminaImpactConfig = AluminaImpactConfig()
    elastic_impact: ElasticImpactConfig = ElasticImpactConfig()
    slice_mill: SliceMillConfig = SliceMillConfig()
    drum_90cm: DrumConfig = DrumConfig()
    bond_mill: BondMillConfig = BondMillConfig()
    spex_shaker: ShakerConfig = ShakerConfig()
    bead_drum: BeadDrumConfig = BeadDrumConfig()
    repose_drum: ReposeDrumConfig = ReposeDrumConfig()

    @model_validator(mode="after")
    def _setups_are_known(self) -> "ValidationConfig":
        known = self.all_setups
        for name in self.setups:
            if name not in (*known, ALL):
                raise ValueError(f"setups: unknown set-up {name!r}; known: {', '.join(known)}; {ALL}")
        if twice := first_repeated(self.setups):
            raise ValueError(f"setups: {twice} is named twice")
        return self

    @property
    def all_setups(self) -> dict[str, SetupConfig]:
        """The settings of every set-up by name."""
        sections = {name: getattr(self, name) for name in type(self).model_fields}
        return {name: section for name, section in sections.items() if isinstance(section, SetupConfig)}

    @property
    def chosen(self) -> dict[str, SetupConfig]:
        """The settings of the set-ups to predict, by name."""
        known = self.all_setups
        return known if ALL in self.setups else {name: known[name] for name in self.setups}

    @property
    def tumbling(self) -> list[str]:
        """The set-ups to predict that are tumbling mills."""
        return [name for name, setup in self.chosen.items() if isinstance(setup, TumblingConfig)]

    @property
    def mills(self) -> list[str]:
        """The mills of the set-ups to predict."""
        chosen = self.chosen.values()
        return [name for setup in chosen if setup.mill_name for name in (setup.mill_name, *setup.further_mills)]

    @property
    def contacts(self) -> list[str]:
        """The contact sets of the set-ups to predict."""
        return [name for setup in self.chosen.values() for name in setup.contact_names]


def setup_cases(setup: SetupConfig, dem: DemConfig) -> dict[str, Case]:
    """The simulations of a set-up in results/dem, by path. Raises ValueError for a sweep that names no mill."""
    cases = {}
    for sweep in setup.sweeps:
        if not sweep.mills:
            raise ValueError(f"sweep {sweep.name} of a set-up names no mill")
        cases.update({case.path: case for case in expand_sweep(sweep, dem, sweep.mills[0])})
    return cases
