"""The conditions of the fingerprint of a mill: its own `sweep`, and the settings of all mills (`mills`)."""

from typing import Annotated, ClassVar, Literal, NamedTuple

from pydantic import AfterValidator, Field, model_validator

from millprint.config.counting import RuleName
from millprint.config.fingerprint import Range
from millprint.config.mixture import BallChoice, BallSize, check_charges
from millprint.config.section import Fraction, Name, Positive, PositiveSpeed, Section, Seed

Turns = Annotated[float, Field(ge=1, le=10_000)]
Several = Annotated[list[Positive], Field(min_length=1, max_length=12)]
Speeds = Annotated[list[PositiveSpeed], Field(min_length=1, max_length=12)]


PrecisionName = Literal["quick", "standard", "fine"]


class Precision(NamedTuple):
    """How exactly the sweep of a mill is simulated, as factors on its settings.

    step: on mills.rayleigh_fraction; recorded: on the recorded time; seeds: on the number of starting positions.
    """

    step: float
    recorded: float
    seeds: int


# Steps of 0.11 and of 0.08 of the Rayleigh time: descriptors stay within the scatter of seeds (docs/how_to/speed.md).
PRECISIONS: dict[PrecisionName, Precision] = {
    "quick": Precision(step=1.375, recorded=0.5, seeds=1),
    "standard": Precision(step=1.0, recorded=1.0, seeds=1),
    "fine": Precision(step=1.0, recorded=2.0, seeds=3),
}


class MillSweepConfig(Section):
    """Speeds, balls and fill ratios that suit a mill.

    Simulated are the first speed with every ball size, and the first ball size with every speed, each at every fill
    ratio and with every seed.
    """

    speeds_rpm: Speeds | None = None
    """speeds of a mill that is set in rpm [rpm]"""
    speeds_hz: Speeds | None = None
    """speeds of a mill that is set in Hz [Hz]"""
    ball_diameters_mm: Annotated[list[BallSize], Field(min_length=1, max_length=12), AfterValidator(check_charges)]
    """ball diameters [mm]; a charge of several sizes is `{name, sizes_mm, numbers}` or `{name, sizes_mm, shares}`"""
    fill_ratios: Annotated[list[Fraction], Field(min_length=3, max_length=24)]
    """ball volume over the nominal volume [-]"""
    seeds: Annotated[list[Seed], Field(min_length=1, max_length=100)] = [0]
    """seeds of the starting positions: each condition is simulated with every seed"""
    discard_turns: Turns | None = None
    """revolutions of the mill before the averages begin; by default at least 0.25 s [-]"""
    window_turns: Turns | None = None
    """recorded revolutions of the mill at precision `standard`; by default at least 3, and 0.8 s [-]"""

    @model_validator(mode="after")
    def _one_list_of_speeds(self) -> "MillSweepConfig":
        if (self.speeds_rpm is None) == (self.speeds_hz is None):
            raise ValueError("speeds: give either speeds_rpm or speeds_hz")
        for key in ("speeds_rpm", "speeds_hz", "ball_diameters_mm", "fill_ratios", "seeds"):
            values = getattr(self, key) or []
            if len(set(values)) < len(values):
                raise ValueError(f"{key} = {values}: a value appears twice")
        return self

    @property
    def speeds(self) -> list[float]:
        """The speeds [rpm]."""
        return self.speeds_rpm or [60 * speed for speed in self.speeds_hz or []]


class MatchMillsConfig(Section):
    """The conditions of one mill that come nearest to a condition of another: target `match`."""

    mill: Name
    """mill whose conditions are searched: a file in config/mills"""
    like_mill: Name
    """mill whose condition is the target: a file in config/mills"""
    like_speed_rpm: Positive
    """its speed [rpm]"""
    like_ball_diameter_mm: BallChoice
    """its balls [mm], or the name of a charge of several sizes in its sweep"""
    like_fill_ratio: Fraction
    """its fill ratio [-]"""
    speeds_rpm: Range | None = None
    """range of possible speeds [rpm]; the simulated range if left out"""
    ball_diameters_mm: Annotated[list[BallChoice], Field(min_length=1)] | None = None
    """available balls [mm], and names of charges in the mill's sweep; the simulated ones if left out"""
    ranked: Annotated[int, Field(ge=1, le=1000)] = 10
    """conditions to list"""


class ScaleUpConfig(Section):
    """A mill enlarged by geometric similarity, and what it costs to simulate: target `scale_up`."""

    mill: Name
    """mill that is enlarged: a file in config/mills"""
    volume_l: Annotated[float, Field(gt=0, le=10_000)]
    """nominal volume of the large mill [L]"""
    ball_diameter_mm: BallChoice
    """balls of the small mill [mm], or the name of a charge of several sizes in its sweep"""
    fill_ratio: Fraction
    """fill ratio of both mills [-]"""
    speed_rpm: PositiveSpeed
    """speed of the small mill [rpm]"""
    # Revolutions for which the cost is estimated [-].
    revolutions: ClassVar[float] = 10.0
    cores: Annotated[int, Field(ge=1)] = 1
    """threads of the large run"""


class MillsConfig(Section):
    """Settings of results/mills: the fingerprints of any mills, by their own sweeps."""

    box: Annotated[list[Name], Field(min_length=1)] = [
        "emax",
        "planetary",
        "spex",
        "mixer",
        "vibratory",
        "attritor",
        "drum",
    ]
    """mills of the target `mills`"""
    contact: Name | None = None
    """contact set of their balls: a file in config/contacts; the first of `contacts` if left out"""
    counting_rule: RuleName | None = None
    """name of the rule of dem.counting_rules that counts; `fingerprint.counting_rule` if left out"""
    precision: PrecisionName = "quick"
    """how exactly the sweeps are simulated: `quick` takes steps of 1.375 times `rayleigh_fraction` and records half
    the time of `standard`; `fine` records twice that time, with three times as many seeds
    """
    rayleigh_fraction: Fraction = 0.08
    """step over each case's own Rayleigh time at precision `standard`; 0.08 is 2e-6 s for 5 mm balls of a softened set
    [-]
    """
    settle_s: Positive = 0.2
    """time for the balls to come to rest before the mill starts [s]"""
    held_out: Annotated[int, Field(ge=0, le=64)] = 8
    """simulations of new conditions, not used in the fingerprint, to count how often its bands hold"""
    first_case_only: bool = False
    """simulate only the first case of each mill of the box, for a smoke test"""
    explored: list[Name] = []
    """further mills in the report's explorer; the run simulates the own sweep of each"""
    match: MatchMillsConfig | None = None
    """search for one mill's conditions nearest to a condition of another; none if left out"""
    scale_up: ScaleUpConfig | None = None
    """a large mill; none if left out"""

    @property
    def level(self) -> Precision:
        """The factors of the precision."""
        return PRECISIONS[self.precision]

    @property
    def contact_set(self) -> str:
        """The contact set of the balls. Raises ValueError if neither this section nor the configuration has it."""
        if self.contact is None:
            raise ValueError("mills.contact: is left out, and there are no `contacts` to take the first of")
        return self.contact

    @property
    def rule(self) -> str:
        """The counting rule. Raises ValueError if neither this section nor the configuration has it."""
        if self.counting_rule is None:
            raise ValueError("mills.counting_rule: is left out, and there is no `fingerprint.counting_rule` to take")
        return self.counting_rule

    @property
    def named(self) -> list[str]:
        """Every mill that the section names."""
        matched = [self.match.mill, self.match.like_mill] if self.match else []
        return [*self.box, *self.explored, *matched, *([self.scale_up.mill] if self.scale_up else [])]

    @property
    def named_balls(self) -> list[tuple[str, str, list[float | str]]]:
        """Every key that names balls of a mill: the key, the mill, and the balls as diameters [mm] or charges."""
        found: list[tuple[str, str, list[float | str]]] = []
        if own := self.match:
            found.append(("mills.match.like_ball_diameter_mm", own.like_mill, [own.like_ball_diameter_mm]))
            found.append(("mills.match.ball_diameters_mm", own.mill, list(own.ball_diameters_mm or [])))
        if plan := self.scale_up:
            found.append(("mills.scale_up.ball_diameter_mm", plan.mill, [plan.ball_diameter_mm]))
        return found
