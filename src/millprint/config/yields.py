"""Settings of the yield stage: models, search spaces of hyper-parameters, evaluation, and proposals.

The default library follows from kinetics, not from scores. Choices that this argument leaves open
are averaged:

- Conversion saturates, since the powder runs out. So the yield enters under a link that ends at 0 and at 100 %:
  Avrami's, under which y = 1 - exp(-(k t)^n) is a straight line in ln t, or the logit, under which log-logistic
  kinetics y = 1 / (1 + (k t)^-n) is one. The yield itself (`identity`) has no such end.
- Time enters as its logarithm, since both laws add it to that of the rate constant, ln k + ln t. On a linear
  scale the yield would rise between 15 and 20 h as fast as between 5 and 10 h.
- The logarithm of the ball-to-powder ratio belongs to a rate constant that is a power of it, the ratio itself to one
  that changes less and less. The argument does not say which, so both are kept.
- The kernels are one product, or this and a term for each input, for time only, or a straight line in each input,
  which for time is Avrami's exponent. `mains_pairs` (15 variances for 27 runs) is gone: all runs together gave each
  of its members a smaller weight than the smallest that is kept.

Priors, margin and the other scales are those of the earlier library, which had the identity link, linear time and
`mains_pairs` as well. That one was fixed after some 130 kernels had been compared by leave-one-out, so the authors of
this one had seen scores of the earlier library, too. No score of this one had been computed when it was written down,
and it stays whatever its score turns out to be.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal, NamedTuple

from pydantic import AfterValidator, BeforeValidator, Field, StringConstraints, model_validator

from millprint.config.section import (
    Count,
    Fraction,
    NonNegative,
    Positive,
    ProjectFile,
    Section,
    Seed,
    completed,
    first_repeated,
)

Scale = Literal["linear", "log"]
Scales = Annotated[list[Scale], Field(min_length=1)]
Input = Literal["bpr", "molar_ratio", "time_h", "power_per_ball_mW", "tangential_share"]
SCALES: dict[Input, list[Scale]] = {
    "bpr": ["linear", "log"],
    "molar_ratio": ["linear"],
    "time_h": ["log"],
    "power_per_ball_mW": ["log"],
    "tangential_share": ["linear"],
}
INPUTS = tuple(SCALES)
LinkName = Literal["identity", "logit", "avrami"]
Structure = Literal["product", "mains_product", "time_product", "trend_product"]


class LogNormal(NamedTuple):
    """A log-normal prior: its median, and the standard deviation of the natural logarithm [-]."""

    median: float
    log_deviation: float


class Priors(NamedTuple):
    """Priors of the kernel's hyper-parameters, for inputs and targets of unit variance.

    length_scale: two steps of a three-level factor [standard deviations of an input]; variance: of a term [variance of
    the target]; noise: its variance [variance of the target].
    """

    length_scale: LogNormal = LogNormal(2.5, 0.7)
    variance: LogNormal = LogNormal(0.5, 1.5)
    noise: LogNormal = LogNormal(0.03, 1.5)


class AveragingConfig(Section):
    """The library of the averaged Gaussian process: every combination of link, scales and structure."""

    links: Annotated[list[LinkName], Field(min_length=1)] = ["logit", "avrami"]
    """scales of the yield"""
    structures: Annotated[list[Structure], Field(min_length=1)] = [
        "product",
        "mains_product",
        "time_product",
        "trend_product",
    ]
    """sums of products of kernels"""
    scales: Annotated[dict[Input, Scales], completed(SCALES)] = SCALES
    """scales on which each input is tried, in place of those that the kinetics give [-]"""
    # An input that varies less is divided by this [-].
    smallest_spread: ClassVar[dict[str, float]] = {"tangential_share": 0.05}
    priors: ClassVar[Priors] = Priors()
    # Under a bounded link, conversions are kept this far from 0 and 1 [-].
    margin: ClassVar[float] = 0.005
    # Members of a smaller weight are dropped [-].
    smallest_weight: ClassVar[float] = 0.002


# The models of thesis Table 5.6, in its order. The linear one has no hyper-parameters and takes one step.
TABLE_5_6 = ("linear", "gpr", "rf", "svr", "xgb")
PRIMARY, TWO_STEP = "primary", "two_step"
Draw = Literal["uniform", "logarithmic", "whole"]


class Drawn(NamedTuple):
    """A hyper-parameter: its bounds, how the search draws it between them, and the smallest value that it can have.

    logarithmic: uniform in the logarithm.
    """

    low: float
    high: float
    how: Draw = "uniform"
    least: float = 1e-12

    def check(self, place: str, bounds: Any) -> None:
        """Raise ValueError for bounds that are not two, do not rise, are too small, or are not whole."""
        numbers = isinstance(bounds, list | tuple) and all(isinstance(bound, int | float) for bound in bounds)
        if not numbers or len(bounds) != 2 or not bounds[0] < bounds[1]:
            raise ValueError(f"{place} = {bounds}: must be two numbers, and the first bound must be below the second")
        if bounds[0] < self.least:
            raise ValueError(f"{place} = {bounds}: must be greater than or equal to {self.least:g}")
        if self.how == "whole" and not all(isinstance(bound, int) for bound in bounds):
            raise ValueError(f"{place} = {bounds}: must be whole numbers")


FOREST = {
    "n_estimators": Drawn(50, 300, "whole", 1),  # trees
    "max_depth": Drawn(5, 30, "whole", 1),  # of a tree
    "min_samples_split": Drawn(2, 20, "whole", 2),  # rows that a node needs to be split
    "min_samples_leaf": Drawn(1, 10, "whole", 1),  # rows that a leaf needs
}


class Training(NamedTuple):
    """How a regressor is trained.

    space: the hyper-parameters that are searched; evaluations, held_out: sets of them that are evaluated (Sec. 5.2.6),
    for a model and in each outer fold. two_step: whether it also makes a model of two steps, first on time and then on
    the rest (Sec. 5.2.5).
    """

    space: Mapping[str, Drawn] = MappingProxyType({})
    evaluations: int = 0
    held_out: int = 0
    two_step: bool = True

    @property
    def strategies(self) -> tuple[str, ...]:
        """The strategies of its models."""
        return (PRIMARY, TWO_STEP) if self.two_step else (PRIMARY,)


# By the name of its record in millprint.thesis.yields.regressors.
TRAININGS = {
    "linear": Training(two_step=False),
    # Table 5.2: where the maximisation of the marginal likelihood starts (Eq. 5.10).
    "gpr": Training(
        {
            "constant": Drawn(0.1, 1000.0),  # constant scaling C [pp2]
            "length_scale": Drawn(0.05, 10.0),  # l [standard deviations of a feature]
            "noise": Drawn(1e-5, 1.5),  # variance [pp2]
        },
        100,
        20,
    ),
    "rf": Training(FOREST, 100, 5),  # Table 5.3
    "svr": Training(  # Table 5.4
        {
            "C": Drawn(0.1, 100.0, "logarithmic"),  # regularisation [-]
            "epsilon": Drawn(0.001, 1.0),  # half width of the insensitive tube [pp]
            "gamma": Drawn(0.001, 1.0, "logarithmic"),  # kernel scale of Eq. 5.13 [-]
        },
        500,
        20,
    ),
    "xgb": Training(  # Table 5.5
        {
            "max_depth": Drawn(3, 10, "whole", 1),  # of a tree
            "learning_rate": Drawn(0.01, 0.3, "logarithmic"),  # [-]
            "n_estimators": Drawn(100, 500, "whole", 1),  # trees
            "subsample": Drawn(0.5, 1.0),  # fraction of the rows for a tree [-]
            "colsample_bytree": Drawn(0.5, 1.0),  # fraction of the features for a tree [-]
            "gamma": Drawn(0.0, 5.0, least=0.0),  # smallest loss reduction that splits a node [pp2]
        },
        100,
        5,
    ),
    "gpr_starts": Training(),
}
SPACES = {name: own.space for name, own in TRAININGS.items() if own.space}
SEARCHED = {name: TRAININGS[name].evaluations for name in SPACES}
HELD_OUT = {name: TRAININGS[name].held_out for name in SPACES}


def _complete_spaces(content: Any) -> Any:
    """Every space, with the bounds that are given; raises ValueError for bounds that cannot be."""
    if not isinstance(content, dict):
        return content
    spaces: dict[str, Any] = {
        name: {key: [drawn.low, drawn.high] for key, drawn in space.items()} for name, space in SPACES.items()
    }
    for name, given in content.items():
        if name not in SPACES or not isinstance(given, dict):
            raise ValueError(f"{name} = {given}: must be bounds of the hyper-parameters of one of {', '.join(SPACES)}")
        for key, bounds in given.items():
            if key not in SPACES[name]:
                raise ValueError(f"{name}.{key} = {bounds}: no such hyper-parameter; known: {', '.join(SPACES[name])}")
            SPACES[name][key].check(f"{name}.{key}", bounds)
            spaces[name][key] = bounds
    return spaces


SPACE_BOUNDS = _complete_spaces({})
Spaces = Annotated[dict[str, dict[str, list[int | float]]], BeforeValidator(_complete_spaces)]


Tuned = Annotated[str, Field(pattern=f"^({'|'.join(SPACES)})$")]
# What is trained where `models` is left out, and what it has at least.
COMPARED = (*TABLE_5_6, "gpr_starts")
STATED = ("linear", "gpr", "gpr_starts")
# The stem of the file of a stored model.
MODEL_NAMES = [f"{name}_{strategy}" for name, own in TRAININGS.items() for strategy in own.strategies]
STORED_MODEL = f"^({'|'.join(MODEL_NAMES)}|averaged_gpr_(primary|final))$"


def _complete_list(names: list[str]) -> list[str]:
    """Raise ValueError for an unknown regressor, one listed twice, or a missing one that the report needs."""
    for name in names:
        if name not in TRAININGS:
            raise ValueError(f"{name!r}: no such regressor; known: {', '.join(TRAININGS)}")
        if names.count(name) > 1:
            raise ValueError(f"{name!r} is listed twice")
    for name in STATED:
        if name not in names:
            raise ValueError(f"{name!r} is missing: the statements of chapter 5 compare {', '.join(STATED)}")
    return names


RegressorList = Annotated[list[str], AfterValidator(_complete_list)]


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
    # A run for learning must take at least this share of the integrated variance [-].
    smallest_share: ClassVar[float] = 0.005
    # Level of the predictive intervals [-].
    level: ClassVar[float] = 0.95
    shortlist: Count = 400
    """conditions that are compared jointly, half by merit and half at random"""
    draws: Count = 2000
    """joint draws from the model for the expected improvement"""
    # Seed of the shortlist and the draws.
    seed: ClassVar[int] = 42
    region: RegionConfig


class PredictionConfig(Section):
    """Yields of new conditions."""

    conditions: ProjectFile
    """table of conditions: case and the six conditions"""
    model: str = Field(default="averaged_gpr_final", pattern=STORED_MODEL)
    """stored model: ALGORITHM_STRATEGY, or averaged_gpr_final, which is fitted on all runs"""
    # Largest distance outside a trained range with a prediction, as a fraction of the range [ranges].
    tolerance: ClassVar[float] = 0.01
    # Largest distance outside the trained tangential shares with a prediction [-].
    share_tolerance: ClassVar[float] = 0.02
    # Three descriptors belong to one setting of the mill if each is within the band of its master curve, widened
    # by this fraction. The default is a little more than what two printed digits of a curve lose, 0.5 of 23 [-].
    curve_tolerance: ClassVar[float] = 0.03
    # Smallest correlation of a yield with that of the nearest run, by the length scales of the averaged process, with a
    # prediction [-].
    correlation_min: ClassVar[float] = 0.5


class SearchConfig(Section):
    """The search by hyperopt's tree-structured Parzen estimator (thesis Sec. 5.2.6)."""

    evaluations: Annotated[dict[Tuned, Count], completed(SEARCHED)] = SEARCHED
    """sets of hyper-parameters that are evaluated for each step of a model, by regressor"""
    folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the cross-validation"""
    repeats: Count = 3
    """repeats of the cross-validation, each shuffled differently"""


class HeldOutConfig(SearchConfig):
    """Predictions of every run by models that were not trained on it; each outer fold repeats search and fit."""

    # By default a smaller search than for the models themselves, since it is repeated many times.
    evaluations: Annotated[dict[Tuned, Count], completed(HELD_OUT)] = HELD_OUT
    """sets of hyper-parameters that are evaluated for each step of a model, in every outer fold, by regressor"""
    folds: Annotated[int, Field(ge=2, le=100_000)] = 4
    """folds of the inner cross-validation"""
    repeats: Count = 1
    """repeats of the inner cross-validation, each shuffled differently"""
    outer_folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the nested cross-validation"""
    outer_repeats: Count = 20
    """repeats of the nested cross-validation, each shuffled differently"""
    orders: Count = 5
    """orders of the rows over which leave-one-out is averaged: they decide the inner folds of a search"""
    random_splits: Count = 20
    """random splits of the size of the locked one"""
    # Trees of a forest in an outer fold at most: more trees only change its noise.
    largest_forest: ClassVar[int] = 100
    conformal_folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the CV+ intervals, and of the errors, of models that predict no distribution"""
    # Seed of the outer folds and the bootstrap.
    seed: ClassVar[int] = 42
    # Levels at which predictive intervals are checked [-].
    nominal: ClassVar[list[float]] = [0.5, 0.8, 0.95]


class EvaluationConfig(HeldOutConfig):
    """Evaluation over all runs, with scaling, search and fit repeated inside every outer fold."""

    resamples: Count = 10_000
    """bootstrap resamples for each interval"""
    # Level of the bootstrap intervals [-].
    level: ClassVar[float] = 0.95


class TrainingConfig(Section):
    """How a model is trained, whatever the budget of its search."""

    # Eq. 5.3: errors above this yield [%] have this weight, all others 1.
    high_yield_percent: ClassVar[float] = 70.0
    high_yield_weight: ClassVar[float] = 2.0
    seed: Seed = 42
    """seed of the folds, the search and the trees"""
    kernel_starts: Count = 8
    """starts of the regressor gpr_starts, drawn within spaces.gpr"""
    spaces: Spaces = SPACE_BOUNDS
    """bounds [low, high] of the search in place of those of Tables 5.2 to 5.5, by regressor and hyper-parameter"""
    length_scales: Literal["per_feature", "shared"] = "per_feature"
    """Matern kernel with a length scale for each feature, or one for all: the thesis leaves it open"""


class LibraryTrialConfig(Section):
    """Whether chance could reach the score of the averaged process."""

    permutations: Annotated[int, Field(ge=19, le=100_000)] = 199
    """shuffles of the yields among the runs; the smallest p-value is 1 / (1 + permutations)"""
    # Seed of the shuffles.
    seed: ClassVar[int] = 42


SourceName = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=60)]


class SourceConfig(Section):
    """A group or a mill whose runs are in the table of others."""

    name: SourceName
    """as in the column `source` of the table"""
    fingerprint: ProjectFile | None = None
    """fingerprint of its mill, for rows without energies; if left out, each row gives its own"""


class OtherSourcesConfig(Section):
    """Runs of other groups or mills, to test the yield models on runs that are not ours."""

    own: SourceName = "screening"
    """name of the source of data.screening"""
    runs: ProjectFile | None = None
    """table of the others' runs, with a column `source`; if left out, there is one source"""
    sources: list[SourceConfig] = []
    """every source in that table"""
    in_training: bool = False
    """whether the models of chapter 5 train on these runs too; if not, they see only data.screening. The locked
    test rows stay the same
    """

    @model_validator(mode="after")
    def _table_and_names_go_together(self) -> "OtherSourcesConfig":
        names = [source.name for source in self.sources]
        if twice := first_repeated([self.own, *names]):
            raise ValueError(f"sources: two have the name {twice!r}; data.screening is {self.own!r}")
        if self.runs is None and names:
            raise ValueError(f"runs is missing: the table that has the runs of {', '.join(names)}")
        if self.runs is not None and not names:
            raise ValueError("sources is missing: name every source of the table, as [{name: NAME}]")
        if self.in_training and self.runs is None:
            raise ValueError("in_training = true: there is no table of others; give runs")
        return self


class YieldConfig(Section):
    """Settings of the yield stage (thesis chapter 5)."""

    out_of_domain: ProjectFile
    """table of runs outside the trained domain (Table 5.7)"""
    # Level of the predictive intervals in tables and figures [-].
    interval_level: ClassVar[float] = 0.95
    models: RegressorList = [*COMPARED]
    """regressors of the models that are trained; linear, gpr and gpr_starts at least"""
    training: TrainingConfig = TrainingConfig()
    search: SearchConfig = SearchConfig()
    searched_again: bool = True
    """whether every tuned model is also searched with another seed, for its scatter; this doubles the searches"""
    evaluation: EvaluationConfig = EvaluationConfig()
    other_sources: OtherSourcesConfig = OtherSourcesConfig()
    averaging: AveragingConfig = AveragingConfig()
    library_trial: LibraryTrialConfig = LibraryTrialConfig()
    proposals: ProposalConfig
    prediction: PredictionConfig
