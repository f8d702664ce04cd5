"""Settings of the fingerprint stage, and of the convergence study that justifies its time step."""

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


class LikeConfig(ChargeSection, SpeedSection):
    """A condition of another mill, whose descriptors are the target."""

    fingerprint: ProjectFile
    """fingerprint_CONTACT.json of that mill, from the project's root"""
    ball_diameter_mm: BallChoice
    """ball diameter [mm], or the name of a charge of several sizes that was simulated"""


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
