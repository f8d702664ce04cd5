"""Settings of the fingerprint stage, and of the convergence study that its time step rests on."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.counting import RuleName
from millprint.config.section import Count, Fraction, Name, NonNegative, Positive, ProjectFile, Section

TARGET_DESCRIPTORS = ("normal_energy_J", "tangential_energy_J", "frequency_per_ball_hz")

Range = Annotated[list[Positive], Field(min_length=2, max_length=2)]


class LikeConfig(Section):
    """A condition of another mill, whose descriptors are the target."""

    fingerprint: ProjectFile = Field(description="fingerprint_CONTACT.json of that mill, from the project's root")
    speed_rpm: Positive = Field(description="mill speed [rpm]")
    ball_diameter_mm: Positive = Field(description="ball diameter [mm]")
    fill_ratio: Fraction = Field(description="fill ratio [-]")


class TargetConfig(Section):
    """The descriptors that the inverse mode looks for: numbers, or those of a condition of another mill."""

    name: Name = Field(description="name of the target")
    normal_energy_J: Positive | None = Field(default=None, description="mean normal energy per collision [J]")
    tangential_energy_J: Positive | None = Field(default=None, description="mean tangential energy per collision [J]")
    frequency_per_ball_hz: Positive | None = Field(default=None, description="collisions per ball and second [1/s]")
    like: LikeConfig | None = Field(default=None, description="a condition of another mill, instead of numbers")

    @property
    def given(self) -> dict[str, float]:
        """The descriptors that are given as numbers."""
        return {name: value for name in TARGET_DESCRIPTORS if (value := getattr(self, name)) is not None}

    @model_validator(mode="after")
    def _numbers_or_a_condition(self) -> "TargetConfig":
        if bool(self.given) == (self.like is not None):
            raise ValueError(f"either one at least of {', '.join(TARGET_DESCRIPTORS)}, or like: must be given")
        return self


class WeightsConfig(Section):
    """Weights of the descriptors when conditions are ranked."""

    normal_energy_J: NonNegative = Field(default=1.0, description="weight of the normal energy [-]")
    tangential_energy_J: NonNegative = Field(default=1.0, description="weight of the tangential energy [-]")
    frequency_per_ball_hz: NonNegative = Field(default=1.0, description="weight of the frequency per ball [-]")


class MatchConfig(Section):
    """The targets, and what a user can change to come near them."""

    targets: list[TargetConfig] = Field(min_length=1, description="descriptors to come near to")
    speeds_rpm: Range = Field(description="speeds that the user can set, from and to [rpm]")
    fill_ratios: Range = Field(description="fill ratios that the user can set, from and to [-]")
    ball_diameters_mm: list[Positive] = Field(min_length=1, description="ball diameters that the user has [mm]")
    densities_kg_m3: list[Positive] = Field(
        default=[], description="densities of the balls, if not as simulated [kg/m3]"
    )
    weights: WeightsConfig = Field(default=WeightsConfig(), description="weights of the descriptors in the ranking")
    ranked: Count = Field(default=10, description="number of conditions to list for each target")

    @model_validator(mode="after")
    def _ranges_rise(self) -> "MatchConfig":
        for key in ("speeds_rpm", "fill_ratios"):
            low, high = getattr(self, key)
            if low > high:
                raise ValueError(f"{key} = [{low:g}, {high:g}]: the first must not exceed the second")
        if self.fill_ratios[1] >= 1:
            raise ValueError(f"fill_ratios = {self.fill_ratios}: must be under 1")
        return self

    @model_validator(mode="after")
    def _something_weighs(self) -> "MatchConfig":
        for target in self.targets:
            counted = target.given or TARGET_DESCRIPTORS
            if not any(getattr(self.weights, name) for name in counted):
                raise ValueError(f"weights: at least one of target {target.name} must be over 0 ({', '.join(counted)})")
        return self


class InverseConfig(MatchConfig):
    """Inverse mode: which conditions come nearest to the descriptors of a target."""

    contact: Name = Field(description="contact set of the search for the speed alone")
    fixed_fill_ratio: Fraction = Field(description="fill ratio of the search for the speed alone [-]")
    fixed_ball_diameter_mm: Positive = Field(description="ball diameter of the search for the speed alone [mm]")
    contacts: list[Name] = Field(min_length=1, description="contact sets that the user can choose from")


class MapsConfig(Section):
    """Simulations shown as heat maps."""

    ball_diameter_mm: Positive = Field(description="ball diameter [mm]")
    speed_rpm: Positive = Field(description="mill speed [rpm]")
    fill_ratios: list[Fraction] = Field(
        min_length=1, max_length=4, description="fill ratios; each has a row of maps [-]"
    )


class FingerprintConfig(Section):
    """Settings of the fingerprint stage. The last three serve the chapters of the thesis alone."""

    counting_rule: RuleName = Field(default="gap_2ms", description="name of the rule of dem.counting_rules that counts")
    interval: Fraction = Field(default=0.95, description="probability of every band and confidence interval [-]")
    smooth_points: int = Field(default=200, ge=20, le=100_000, description="points of the fitted curves")
    cycle_fill_ratio: Fraction | None = Field(default=None, description="fill ratio of Table 3.5, on revolutions [-]")
    maps: MapsConfig | None = Field(default=None, description="simulations shown as heat maps (Figs 3.9, 3.10)")
    inverse: InverseConfig | None = Field(default=None, description="inverse mode (Sec. 3.3.4)")


class ConvergenceConfig(Section):
    """How the sweeps over time_steps_s and over young_moduli_gpa are judged.

    Energies and frequencies are those of fingerprint.counting_rule.
    """

    counting_rules: list[RuleName] = Field(
        default=["lifetimes"], description="further rules of dem.counting_rules in the tables"
    )
    tolerance_percent: Positive = Field(
        default=1.0, description="largest significant deviation of a descriptor from its value at the finest step [%]"
    )
    confidence: Fraction = Field(
        default=0.95, description="probability that no comparison of a sweep is taken for a deviation by chance [-]"
    )
    closure_max: Fraction = Field(
        default=0.001, description="largest energy balance error over the wall work at a step that passes [-]"
    )
