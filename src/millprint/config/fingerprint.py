"""Settings of the fingerprint, of the study of its time step, and of the uncertainty of contact parameters.

To add a kind of distribution, write its section, add it to `DISTRIBUTIONS`, and give it a function in
`millprint.uncertainty.samples`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, create_model, model_validator

from millprint.config.charge import BallChoice, ChargeSection, SpeedSection
from millprint.config.counting import DEFAULT_RULE, RuleName
from millprint.config.section import (
    Count,
    Density,
    Fraction,
    Name,
    NonNegative,
    Positive,
    PositiveSpeed,
    ProjectFile,
    Section,
    first_repeated,
    kind_of,
)
from millprint.observables.definitions import ASKED_DESCRIPTORS, ASKED_SETS, PREDICTED, SHARE, Observable

DescriptorSet = Literal["weighted", "per_collision"]
AskedSet = Literal["weighted", "per_collision", "shear_share"]
if TYPE_CHECKING:
    TargetDescriptor = str
else:
    TargetDescriptor = Literal[ASKED_DESCRIPTORS]

# How much more the descriptor counts that a user holds dear.
FIRST = 100.0
Energy = Annotated[float, Field(gt=0, le=1e6)]
Frequency = Annotated[float, Field(gt=0, le=1e9)]
SpeedRange = Annotated[list[PositiveSpeed], Field(min_length=2, max_length=2)]
FillRange = Annotated[list[Fraction], Field(min_length=2, max_length=2)]


class SimulatedCondition(ChargeSection, SpeedSection):
    """A condition of a mill, by its balls, charge and speed."""

    ball_diameter_mm: BallChoice
    """ball diameter [mm], or the name of a charge of several sizes that was simulated"""


class LikeConfig(SimulatedCondition):
    """A condition of another mill, whose descriptors are the target."""

    fingerprint: ProjectFile
    """fingerprint_CONTACT.json of that mill, from the project's root"""


class NamedTarget(Section):
    """A target."""

    name: Name
    """name of the target"""


def _number(own: Observable) -> tuple[Any, Any]:
    """The key of a descriptor, without a value."""
    kind = Fraction if own is SHARE else {"J": Energy, "1/s": Frequency}.get(own.unit, Positive)
    return kind | None, Field(None, description=f"{own.title}: {own.meaning} [{own.unit}]")


_numbers: dict[str, Any] = {name: _number(PREDICTED[name]) for name in ASKED_DESCRIPTORS}
_TargetNumbers: Any = create_model("TargetNumbers", __base__=NamedTarget, **_numbers)


class TargetConfig(_TargetNumbers):
    """The descriptors that the inverse mode looks for: numbers, or the descriptors of another mill's condition."""

    like: LikeConfig | None = None
    """a condition of another mill, instead of numbers"""

    @property
    def given(self) -> dict[str, float]:
        """The descriptors that are given as numbers."""
        return {name: value for name in ASKED_DESCRIPTORS if (value := getattr(self, name)) is not None}

    @model_validator(mode="after")
    def _numbers_or_a_condition(self) -> "TargetConfig":
        if bool(self.given) == (self.like is not None):
            raise ValueError(f"either one at least of {', '.join(ASKED_DESCRIPTORS)}, or like: must be given")
        return self


class SearchConfig(Section):
    """The settings that a user can change to approach a target, and what is asked for."""

    speeds_rpm: SpeedRange | None = None
    """speeds that the user can set, from and to; as simulated if left out [rpm]"""
    fill_ratios: FillRange | None = None
    """fill ratios that the user can set, from and to; as simulated if left out [-]"""
    ball_diameters_mm: Annotated[list[BallChoice], Field(min_length=1)] | None = None
    """ball diameters that the user has [mm], and names of charges of several sizes that were simulated; the simulated
    ones, and what is sold between them, if left out
    """
    densities_kg_m3: list[Density] = []
    """densities of the balls, if not as simulated [kg/m3]"""
    descriptors: AskedSet = "weighted"
    """descriptors compared with another mill's condition: its energies, or the weighted normal energy and the share of
    shear, while milling time makes up how often they come; a target of numbers uses the ones it gives
    """
    equal_frequency: bool = False
    """whether the frequencies of another mill's condition are asked for too"""
    near_percent: Annotated[float, Field(gt=0, le=1000)] = 30.0
    """what is asked for is met if the mills are surely this near to each other in it [%]"""
    first: TargetDescriptor | None = None
    """descriptor that counts a hundred times as much as the others"""
    weights: dict[TargetDescriptor, NonNegative] = {}
    """weights of descriptors in the ranking, 1 if left out; only those of the target count [-]"""
    ranked: Count = 10
    """number of conditions to list for each target"""

    @model_validator(mode="after")
    def _ranges_rise(self) -> "SearchConfig":
        for key in ("speeds_rpm", "fill_ratios"):
            low, high = getattr(self, key) or (0, 0)
            if low > high:
                raise ValueError(f"{key} = [{low:g}, {high:g}]: the first must not exceed the second")
        return self

    @property
    def all_weights(self) -> dict[str, float]:
        """The weight of every descriptor."""
        weights = dict.fromkeys(ASKED_DESCRIPTORS, 1.0) | self.weights
        return weights | ({self.first: FIRST * weights[self.first]} if self.first else {})

    @property
    def asked(self) -> tuple[str, ...]:
        """The descriptors of another mill's condition that are asked for."""
        frequencies = self.equal_frequency
        names = ASKED_SETS[self.descriptors]
        return tuple(name for name in names if frequencies or PREDICTED[name].unit != "1/s" or name == self.first)


class MatchConfig(SearchConfig):
    """The targets, and the settings that a user can change to approach them."""

    targets: list[TargetConfig] = Field(min_length=1)
    """descriptors to approach"""

    @model_validator(mode="after")
    def _something_weighs(self) -> "MatchConfig":
        for target in self.targets:
            counted = target.given or self.asked
            if not any(self.all_weights[name] for name in counted):
                raise ValueError(f"weights: at least one of target {target.name} must be over 0 ({', '.join(counted)})")
        return self


class InverseConfig(MatchConfig):
    """Inverse mode: which conditions come nearest to the descriptors of a target."""

    # Contact set of the search in which only the speed varies.
    contact: ClassVar[str] = "calibrated"
    # Fill ratio of the search in which only the speed varies [-].
    fixed_fill_ratio: ClassVar[float] = 0.10
    # Ball diameter of the search in which only the speed varies [mm].
    fixed_ball_diameter_mm: ClassVar[float] = 5.0
    speeds_rpm: SpeedRange
    """speeds that the user can set, from and to [rpm]"""
    fill_ratios: FillRange
    """fill ratios that the user can set, from and to [-]"""
    ball_diameters_mm: list[BallChoice] = Field(min_length=1)
    """ball diameters that the user has [mm], and names of charges of several sizes that were simulated"""
    contacts: list[Name] = Field(min_length=1)
    """contact sets that the user can choose from"""


class MapsConfig(Section):
    """Simulations shown as heat maps."""

    # Ball diameter [mm].
    ball_diameter_mm: ClassVar[float] = 10.0
    speed_rpm: Positive
    """mill speed [rpm]"""
    fill_ratios: list[Fraction] = Field(min_length=1, max_length=4)
    """fill ratios; each has a row of maps [-]"""


class FingerprintConfig(Section):
    """Settings of the fingerprint stage. Only the thesis chapters need the last three."""

    counting_rule: RuleName = DEFAULT_RULE
    """name of the rule of dem.counting_rules that counts"""
    descriptors: DescriptorSet = "weighted"
    """descriptors by which mills are matched: `weighted`, energy-weighted ones, which need no counting rule, or
    `per_collision`, the thesis's; tables, pages and cards show both
    """
    interval: Fraction = 0.95
    """probability of every band and confidence interval [-]"""
    smooth_points: int = Field(default=200, ge=20, le=100_000)
    """points of the fitted curves"""
    cycle_fill_ratio: Fraction | None = None
    """fill ratio of Table 3.5, on revolutions [-]"""
    maps: MapsConfig | None = None
    """simulations shown as heat maps (Figs 3.9, 3.10)"""
    inverse: InverseConfig | None = None
    """inverse mode (Sec. 3.3.4)"""


class StudyConfig(Section):
    """Whether the settings of the sweep of the run's mill are good enough: target `convergence`.

    One condition (first speed, first balls, middle fill ratio) is simulated again, with one setting changed at a time.
    """

    seeds: Annotated[int, Field(ge=2, le=100)] = 6
    """starting positions simulated for each variant"""
    # Changes of a descriptor up to this are accepted [%].
    tolerance_percent: ClassVar[float] = 5.0


class FurtherRules(Section):
    """Counting rules in addition to fingerprint.counting_rule."""

    counting_rules: list[RuleName] = ["lifetimes"]
    """further rules of dem.counting_rules in the tables"""

    @model_validator(mode="after")
    def _rules_differ(self) -> "FurtherRules":
        if twice := first_repeated(self.counting_rules):
            raise ValueError(f"counting_rules: {twice} appears twice")
        return self


class ConvergenceConfig(FurtherRules):
    """How the sweeps over time_steps_s and over young_moduli_gpa are judged.

    Energies and frequencies use fingerprint.counting_rule.
    """

    # Largest significant deviation of a descriptor from its value at the finest step [%].
    tolerance_percent: ClassVar[float] = 1.0
    study: StudyConfig = StudyConfig()


class DistributionSection(Section):
    """The keys that every distribution has."""

    kind: str
    source: Annotated[str, Field(min_length=1)]
    """where the numbers come from"""

    @property
    def given_range(self) -> tuple[float | None, float | None]:
        """The ends that the section states; None for an end that it leaves to the parameter's own bounds."""
        return getattr(self, "low", None), getattr(self, "high", None)


class RangeOfValues(DistributionSection):
    """A distribution between two ends."""

    low: float
    """smallest value, in the unit of the parameter"""
    high: float
    """largest value, in the unit of the parameter"""


class UniformSection(RangeOfValues):
    """Every value between two ends is equally likely: only a range is known."""

    kind: Literal["uniform"]


class LogUniformSection(RangeOfValues):
    """As uniform, in the logarithm: for a range over powers of ten."""

    kind: Literal["loguniform"]
    low: Positive
    high: Positive


class TriangularSection(RangeOfValues):
    """A range with a most likely value."""

    kind: Literal["triangular"]
    mode: float
    """most likely value, in the unit of the parameter"""

    @model_validator(mode="after")
    def _mode_between(self) -> "TriangularSection":
        if not self.low <= self.mode <= self.high:
            raise ValueError(f"mode = {self.mode:g}: must lie between low = {self.low:g} and high = {self.high:g}")
        return self


class MeasuredSection(DistributionSection):
    """A measured value with its standard error, or the interval of a measurement.

    A normal distribution, cut off at the parameter's bounds and at three standard deviations.

    The stage `calibration` gives the numbers: `lower` and `upper` of restitution.tsv and of friction_fit.tsv, as
    docs/how_to/contact_set.md shows.
    """

    kind: Literal["measured"]
    value: float | None = None
    """measured value, with standard_error"""
    standard_error: Positive | None = None
    """standard error of the value"""
    lower: float | None = None
    """lower end of the measured interval, in place of value and standard_error"""
    upper: float | None = None
    """upper end of the measured interval"""
    probability: Fraction = 0.95
    """probability of the measured interval [-]"""

    @model_validator(mode="after")
    def _a_value_or_an_interval(self) -> "MeasuredSection":
        point, interval = (self.value, self.standard_error), (self.lower, self.upper)
        nothing = (None, None)
        if not (interval == nothing and None not in point) and not (point == nothing and None not in interval):
            raise ValueError("give either value and standard_error, or lower and upper")
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"lower = {self.lower:g}: must be below upper = {self.upper:g}")
        return self


DISTRIBUTIONS = {
    kind_of(section): section for section in (UniformSection, LogUniformSection, TriangularSection, MeasuredSection)
}

if TYPE_CHECKING:
    Distribution = DistributionSection
else:
    Distribution = Annotated[reduce(or_, DISTRIBUTIONS.values()), Field(discriminator="kind")]


@dataclass(frozen=True)
class Parameter:
    """A contact parameter that may be uncertain: its title, its unit, and the values that it can have."""

    title: str
    unit: str
    lowest: float
    highest: float


# The keys of a contact set that are varied.
PARAMETERS = {
    "restitution": Parameter("restitution", "-", 0.02, 1.0),
    "static_friction": Parameter("static friction, ball on ball", "-", 0.0, 5.0),
    "wall_static_friction": Parameter("static friction, ball on wall", "-", 0.0, 5.0),
    "rolling_friction": Parameter("rolling friction", "-", 0.0, 1.0),
    "young_modulus_gpa": Parameter("Young's modulus", "GPa", 0.01, 2000.0),
}

THESIS = "thesis Table 3.2"
HLOSTA = "Hlosta et al., Processes 8 (2020) 222, measured on steel balls, as quoted in the code jviquerat/dem"
KHARAZ = "Kharaz, Gorham, Salman, Powder Technol. 120 (2001) 281, alumina on glass"
GOVENDER = "Govender et al., BLAZE-DEM of a steel ball mill"


def between(section: type[RangeOfValues], low: float, high: float, source: str) -> RangeOfValues:
    """A distribution between two ends, for defaults."""
    return section(kind=kind_of(section), low=low, high=high, source=source)


class ParametersSection(Section):
    """The contact parameters, each with its distribution. The defaults are wide, for balls that were not measured."""

    restitution: Distribution = between(
        UniformSection, 0.2, 0.95,
        f"0.30 coated with powder, 0.68 clean steel: {THESIS}; 0.85 ball on ball: {HLOSTA}; 0.98: {KHARAZ}; the lower "
        "end, for thicker powder, is assumed",
    )  # fmt: skip
    """coefficient of restitution [-]"""
    static_friction: Distribution = between(
        UniformSection, 0.08, 0.8,
        f"0.30 coated with powder, 0.70 clean steel: {THESIS}; 0.17 ball on ball: {HLOSTA}; 0.14 ball on ball: "
        f"{GOVENDER}; 0.092: {KHARAZ}; the upper end is assumed",
    )  # fmt: skip
    """static friction of ball on ball [-]"""
    wall_static_friction: Distribution = between(
        UniformSection, 0.08, 0.8,
        f"0.30 coated with powder, 0.70 clean steel: {THESIS}; 0.13 on a steel wall: {HLOSTA}; 0.39 on the shell: "
        f"{GOVENDER}; the upper end is assumed",
    )  # fmt: skip
    """static friction of ball on wall [-]"""
    rolling_friction: Distribution = between(
        LogUniformSection, 0.005, 0.09,
        f"0.045 coated with powder, 0.010 clean steel: {THESIS}; a factor of two beyond both is assumed",
    )  # fmt: skip
    """rolling friction, ball on ball and ball on wall [-]"""
    young_modulus_gpa: Distribution = between(
        LogUniformSection, 1.0, 20.5,
        "no material is as soft: simulations lower the 205 GPa of steel a hundredfold (thesis Sec. 3.2.3); from half "
        "of that to ten times as stiff shows what the softening costs",
    )  # fmt: skip
    """Young's modulus [GPa]"""

    @model_validator(mode="after")
    def _values_can_be(self) -> "ParametersSection":
        for name, parameter in PARAMETERS.items():
            low, high = getattr(self, name).given_range
            for key, end in (("low", low), ("high", high)):
                if end is not None and not parameter.lowest <= end <= parameter.highest:
                    raise ValueError(
                        f"{name}.{key} = {end:g}: must be from {parameter.lowest:g} to {parameter.highest:g} "
                        f"[{parameter.unit}]"
                    )
            if low is not None and high is not None and low >= high:
                raise ValueError(f"{name}.low = {low:g}: must be below {name}.high = {high:g}")
        return self

    def items(self) -> Iterator[tuple[str, Any]]:
        """Name and distribution of each parameter."""
        return ((name, getattr(self, name)) for name in PARAMETERS)


class UncertaintyConfig(Section):
    """How much the predictions for a mill depend on contact parameters: target `uncertainty`."""

    mills: list[Name] = []
    """mills whose intervals are part of the whole run: files in config/mills; may be empty for the target"""
    samples: Annotated[int, Field(ge=8, le=4096)] = 128
    """short simulations of a mill, each with its own contact parameters and fill ratio"""
    jobs: Annotated[int, Field(ge=1, le=64)] = 8
    """jobs that share the samples"""
    fill_ratios: Annotated[list[Fraction], Field(min_length=2, max_length=24)] | None = None
    """fill ratios at which intervals are given; if left out, the fill ratios of the mill's sweep [-]"""
    rayleigh_fraction: Fraction = 0.08
    """step over the Rayleigh time of each simulation; 0.08 is 2e-6 s for 5 mm balls of a softened set [-]"""
    # Probability of every interval [-].
    probability: ClassVar[float] = 0.95
    # Seed of the design and of the draws from the emulator.
    seed: ClassVar[int] = 0
    base_samples: Annotated[int, Field(ge=16, le=4096)] = 512
    """rows of Saltelli's sample of the emulator; a power of two [-]"""
    draws: Annotated[int, Field(ge=2, le=1000)] = 32
    """functions drawn from the emulator, for its own uncertainty [-]"""
    parameters: ParametersSection = ParametersSection()

    @model_validator(mode="after")
    def _lists_and_powers(self) -> "UncertaintyConfig":
        if (twice := first_repeated(self.mills)) is not None:
            raise ValueError(f"mills: {twice} appears twice")
        if self.jobs > self.samples:
            raise ValueError(f"jobs = {self.jobs}: more than samples = {self.samples}")
        fills = self.fill_ratios or []
        if sorted(set(fills)) != fills:
            raise ValueError(f"fill_ratios = {fills}: must rise")
        if self.base_samples & (self.base_samples - 1):
            raise ValueError(f"base_samples = {self.base_samples}: must be a power of two, such as 256 or 512")
        return self
