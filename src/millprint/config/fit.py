"""The section `fit`: jar shape and counting rule, fitted to some published values and checked with the others."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.counting import DEFAULT_RULES, RuleName
from millprint.config.section import Name, NonNegative, Positive, Section

# Published values are named quantity_fFILL or quantity_dDIAMETER_nSPEED, such as Pn_f0.06 and normal_d10_n1200.
ValueName = Annotated[str, Field(pattern=r"^(Pn|Pt|f)_f0\.\d+$|^(normal|tangential)_d[\d.]+_n\d+$")]
Count = Annotated[int, Field(ge=1)]


class RangeConfig(Section):
    """A parameter of the jar's shape: the range and grid of its search."""

    low: NonNegative
    """smallest value, in the parameter's unit"""
    high: Positive
    """largest value, in the parameter's unit"""
    step: Positive
    """values are low, low + step, ...; the sensitivity is the effect of one step"""

    @model_validator(mode="after")
    def _range_rises(self) -> "RangeConfig":
        if self.low + self.step > self.high * (1 + 1e-9):
            raise ValueError(f"step = {self.step:g}: must not exceed high - low = {self.high - self.low:g}")
        return self


class ShapeConfig(Section):
    """The parameters that are fitted; the end radius follows from them and the volume."""

    straight_ratio: RangeConfig
    """length of the straight sides over the end radius [-]"""
    height_mm: RangeConfig
    """inner height [mm]"""
    facets_per_half_circle: RangeConfig
    """flat facets of each round end [-]"""
    facet_unevenness: RangeConfig
    """unevenness u of the facets, as in the stadium [-]"""
    fillet_radius_mm: RangeConfig
    """radius of the bottom edge's fillet [mm]"""

    @model_validator(mode="after")
    def _facets_are_whole(self) -> "ShapeConfig":
        facets = self.facets_per_half_circle
        if facets.low % 1 or facets.step % 1:
            raise ValueError("facets_per_half_circle: low and step must be whole numbers")
        return self


class StageConfig(Section):
    """One stage of the search: how many jars, and how long each is simulated."""

    jars: Count
    """jars that are simulated, or kept from the stage before"""
    revolutions: int = Field(ge=2)
    """revolutions of the mill that are recorded"""
    seeds: Count = 1
    """starting positions of each jar, the same for all: seeds from 0 on"""


class TrialConfig(Section):
    """The values that a jar is compared with, and the simulations for it."""

    contact: Name
    """contact set of the published values"""
    fitted: list[ValueName] = Field(min_length=1)
    """fitted values, at most half of each kind"""
    counting_rules: list[RuleName] = Field(default=[rule.name for rule in DEFAULT_RULES], min_length=1)
    """rules to choose from, without thresholds"""
    shape: ShapeConfig
    ball_diameters_mm: list[Positive] = Field(min_length=1)
    """ball diameters that curves average over [mm]"""
    speeds_rpm: list[Positive] = Field(min_length=1)
    """speeds that curves average over [rpm]"""
    time_step_s: Positive = 4e-6
    """integration step of the search [s]"""
    settle_s: Positive = 0.2
    """time for the balls to come to rest [s]"""
    discard_revolutions: int = Field(default=6, ge=0)
    """first revolutions, left out of the averages"""
    closure_max: Positive = 0.02
    """in place of dem.closure_max, for the coarse step [-]"""
    refining: StageConfig = StageConfig(jars=5, revolutions=12)
    """simulations of the best jars, the steps from them, and the sensitivity"""


class FitConfig(TrialConfig):
    """A fit of a mill, its geometry a stadium, to values of data.published."""

    mill: Name
    """the mill that is fitted; a run of another mill fits nothing"""
    in_all: bool = False
    """whether the search is a part of `all`, and the shape of the jar, which follows from it, widens the intervals"""
    screening: StageConfig = StageConfig(jars=48, revolutions=10)
    """jars over the whole ranges, by a Sobol sequence"""
    rounds: Count = 2
    """rounds of steps up and down in every parameter, while one is better"""
    seed: int = Field(default=0, ge=0)
    """seed of the Sobol sequence"""
