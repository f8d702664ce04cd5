"""Settings for predictions of new conditions and for proposals of the next experiments."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from millprint.config.averaged_process import LinkName
from millprint.config.search_spaces import STORED_MODEL
from millprint.config.section import Count, Fraction, NonNegative, Positive, ProjectFile, Section

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
    powder_max_g: Positive | None = 6.0
    """largest powder mass that is proposed; null: no limit [g]"""
    hydrogen_max_mmol: Positive | None = 75.0
    """largest amount of hydrogen that a proposed run may give off at full conversion; null: no limit. The default is
    cautious: the charges of the screening with a ball-to-powder ratio of 30 and more stay below it. Ask the maker of
    your jar [mmol]
    """
    pressure_max_bar: Positive | None = None
    """largest pressure of this hydrogen in the free volume of the jar, where the maker of the jar gives one [bar]"""
    gas_temperature_k: Annotated[float, Field(ge=250, le=1000)] = 298.15
    """temperature of the gas for this pressure, which is proportional to it [K]"""
    powder_density_kg_m3: Positive = 1500.0
    """density of the powder's grains, for the free volume; MgH2 has 1450 [kg/m3]"""


class ProposalConfig(Section):
    """The next experiments."""

    runs: Count = 4
    """experiments for each purpose, proposed as one batch"""
    curves: Literal["published", "fingerprint"] = "published"
    """master curves for the descriptors: from data.regimes, or simulated"""
    regimes: bool = True
    """whether the cases of data.regimes train averaged_gpr_final too, which proposes and predicts"""
    experiments: ProjectFile | None = None
    """table of experiments that were proposed, are running or done, with your results: done ones train
    averaged_gpr_final, running ones are taken into account (ask and tell)
    """
    replicates: Annotated[int, Field(ge=0, le=1000)] = 2
    """runs of the batch that repeat earlier ones, for the scatter of repeated runs"""
    centre_points: Annotated[int, Field(ge=0, le=1000)] = 1
    """runs of the batch at the centre of the runs that were done"""
    smallest_gain_pp: NonNegative = 0.5
    """a run for a higher yield must be expected to add at least this to those before it [pp]; what is left of `runs`
    goes to learning
    """
    smallest_share: NonNegative = 0.005
    """a run for learning must take at least this share of the integrated variance [-]"""
    # Level of the predictive intervals [-].
    level: ClassVar[float] = 0.95
    shortlist: Count = 400
    """conditions that are compared jointly, half by merit and half at random"""
    draws: Count = 2000
    """joint draws from the model for the expected improvement"""
    # Seed of the shortlist and the draws.
    seed: ClassVar[int] = 42
    region: RegionConfig


class RetrospectiveConfig(Section):
    """How many experiments it takes to find the best of the runs that were done."""

    # Runs known at the start.
    start_runs: ClassVar[int] = 8
    starts: Count = 30
    """random starts, which do not contain the best run"""
    targets: Annotated[int, Field(ge=1, le=12)] = 5
    """best runs to find: the best of all runs, the best without that one, and so on, because a single run may
    be found fast by luck
    """
    # Runs that no strategy may choose; their error says what the chosen runs teach.
    held_out_runs: ClassVar[int] = 7
    chosen_runs: Annotated[int, Field(ge=1, le=100_000)] = 8
    """runs that a strategy chooses one by one before the last error"""
    # Seed of the starts and of ties.
    seed: ClassVar[int] = 42
    links: Annotated[list[LinkName], Field(min_length=1)] = ["logit", "avrami"]
    """scales of the yield that are averaged"""
    # Kernels that are averaged.
    structures: ClassVar[tuple[str, ...]] = ("product",)


class PredictionConfig(Section):
    """Yields of new conditions."""

    conditions: ProjectFile
    """table of conditions: case and the six conditions"""
    model: str = Field(
        default="averaged_gpr_final",
        pattern=STORED_MODEL,
    )
    """stored model: ALGORITHM_STRATEGY, or averaged_gpr_final, which is fitted on all runs"""
    # Largest distance outside a trained range with a prediction, as a fraction of the range [ranges].
    tolerance: ClassVar[float] = 0.01
    # Largest distance outside the trained tangential shares with a prediction [-].
    share_tolerance: ClassVar[float] = 0.02
    # Three descriptors belong to one setting of the mill if each is within the band of its master curve, widened
    # by this fraction. The default is a little more than what two printed digits of a curve lose, 0.5 of 23 [-].
    curve_tolerance: ClassVar[float] = 0.03
    correlation_min: Annotated[float, Field(ge=0, lt=1)] = 0.5
    """smallest correlation of a yield with that of the nearest run, by the length scales of the averaged process, with
    a prediction; 0: no limit [-]
    """

    @model_validator(mode="after")
    def _small(self) -> "PredictionConfig":
        if self.tolerance > 1:
            raise ValueError(f"tolerance = {self.tolerance:g}: at most 1, a whole range on either side")
        return self
