"""Set-ups of tumbling mills, measured at several speeds."""

import math
from typing import Annotated, ClassVar

from pydantic import Field, model_validator

from millprint.config.mill import MillConfig
from millprint.config.mixture import BallMixture, BallSize
from millprint.config.section import Fraction, Name, Positive, Seed
from millprint.config.setups.base import Interval, SetupConfig
from millprint.config.sweep import Case, balls_of


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
    """speeds, in addition to the measured ones"""
    critical_speed_rpm: Positive | None = None
    """critical speed that the speeds are per cent of; left out, they are in rpm [rpm]"""
    drawn_speeds: list[Positive] = []
    """speeds at which the charge is drawn, for the first number of balls"""
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
    """records of the balls per revolution, for toe, shoulder and rings; not a multiple of the number of lifters [-]"""
    rayleigh_fraction: Fraction = 0.15
    """step over the Rayleigh time of the smallest ball [-]"""
    closure_max: Fraction = 0.01
    """a simulation fails at this energy balance error over the wall work [-]"""
    samples: Annotated[int, Field(ge=2, le=1000)] = 8
    """contact sets of the interval by contact parameters, a Latin hypercube over the four ranges below"""
    sample_speeds: list[Positive] = Field(min_length=1)
    """speeds at which these sets are simulated; between them the effect is interpolated"""
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

    def case(self, number: int, speed_rpm: float, seed: int, mill: MillConfig) -> Case:
        """The simulation of a number of balls at a speed [rpm]."""
        turn_s = 60 / speed_rpm
        return Case(
            mill=mill.name, contact=self.contact, **balls_of(self.ball_diameter_mm),
            fill_ratio=self.fill_ratio(number, mill.volume_ml), speed_rpm=speed_rpm, seed=seed,
            rayleigh_fraction=self.rayleigh_fraction, closure_max=self.closure_max, settle_s=self.settle_s,
            discard_s=max(self.discard_turns * turn_s, self.discard_s),
            window_s=max(self.window_turns * turn_s, self.window_s),
            snapshot_interval_s=turn_s / self.snapshots_per_turn,
        )  # fmt: skip

    def simulated_inside(self, mill: MillConfig) -> list[Case]:
        """A case for each simulation at a speed of this section: every number, speed and seed, and the contact sets."""
        predicting = [(number, speed, seed) for seed in self.seeds for number in self.numbers for speed in self.speeds]
        sets = len(self.further_contacts) + self.samples
        others = [(self.numbers[0], speed, self.seeds[0]) for speed in self.sample_speeds] * sets
        return [self.case(number, self.speed_rpm(speed), seed, mill) for number, speed, seed in (*predicting, *others)]

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

    def speed_of(self, speed_rpm: float) -> float:
        """A speed in rpm, in the unit of the set-up."""
        return speed_rpm if self.critical_speed_rpm is None else 100 * speed_rpm / self.critical_speed_rpm

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
