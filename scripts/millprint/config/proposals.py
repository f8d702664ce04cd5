"""Settings for predictions of new conditions and for proposals of the next experiments."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.averaging import LinkName, Structure
from millprint.config.regressors import STORED_MODEL
from millprint.config.section import Count, Fraction, NonNegative, Positive, ProjectFile, Section, Seed

Settings = Annotated[list[Positive], Field(min_length=1)]


class RegionConfig(Section):
    """Possible values of each factor; the region is all their combinations."""

    bpr: Settings
    """ball-to-powder mass ratios"""
    molar_ratio: Settings
    """mol of MgH2 to mol of NaBO2.4H2O"""
    time_h: Settings
    """milling times [h]"""
    speed_rpm: Settings
    """speeds of the mill [rpm]"""
    fill_ratio: Annotated[list[Fraction], Field(min_length=1)]
    """ball volumes over the volume of the jar [-]"""
    ball_diameter_mm: Settings
    """ball diameters [mm]"""


class ProposalConfig(Section):
    """The next experiments."""

    runs: Count = 4
    """experiments for each purpose, proposed as one batch"""
    curves: Literal["published", "fingerprint"] = "published"
    """master curves for the descriptors: those of data.regimes, or the simulated ones"""
    regimes: bool = True
    """whether the cases of data.regimes train the model too"""
    level: Fraction = 0.95
    """level of the predictive intervals [-]"""
    shortlist: Count = 400
    """conditions that are compared jointly, half by merit and half at random"""
    draws: Count = 2000
    """joint draws from the model for the expected improvement"""
    seed: Seed = 42
    """of the shortlist and the draws"""
    region: RegionConfig


class RetrospectiveConfig(Section):
    """How many experiments it takes to find the best of the runs that were done."""

    start_runs: Annotated[int, Field(ge=3, le=100_000)] = 8
    """runs known at the start"""
    starts: Count = 30
    """random starts, which do not contain the best run"""
    targets: Annotated[int, Field(ge=1, le=12)] = 5
    """best runs to find: the best of all runs, the best without that one, and so on. One best run is one draw: what
    finds it fast may do so by luck
    """
    seed: Seed = 42
    """of the starts and of ties"""
    links: Annotated[list[LinkName], Field(min_length=1)] = ["logit", "avrami"]
    """scales of the yield that are averaged"""
    structures: Annotated[list[Structure], Field(min_length=1)] = ["product"]
    """kernels that are averaged"""


class PredictionConfig(Section):
    """Yields of new conditions."""

    conditions: ProjectFile
    """table of conditions: case and the six conditions"""
    model: str = Field(
        default="averaged_gpr_final",
        pattern=STORED_MODEL,
    )
    """stored model: ALGORITHM_STRATEGY, or averaged_gpr_final, which is fitted on all runs"""
    tolerance: NonNegative = 0.01
    """largest distance outside a trained range with a prediction, as a fraction of the range [ranges]"""
    share_tolerance: NonNegative = 0.02
    """largest distance outside the trained tangential shares with a prediction [-]"""

    @model_validator(mode="after")
    def _small(self) -> "PredictionConfig":
        if self.tolerance > 1:
            raise ValueError(f"tolerance = {self.tolerance:g}: at most 1, a whole range on either side")
        return self
