"""Settings of the yield stage: models, search of hyper-parameters, and evaluation."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from millprint.config.averaged_process import AveragingConfig, LibraryConfig
from millprint.config.next_experiments import PredictionConfig, ProposalConfig, RetrospectiveConfig
from millprint.config.other_sources import OtherSourcesConfig
from millprint.config.search_spaces import COMPARED, SPACE_BOUNDS, Interval, RegressorList, Spaces, Tuned
from millprint.config.section import Count, ProjectFile, Section, Seed, completed

# Sets of hyper-parameters that are evaluated for each regressor (Sec. 5.2.6), and in each outer fold.
SEARCHED: dict[Tuned, int] = {"gpr": 100, "rf": 100, "svr": 500, "xgb": 100, "extra_trees": 100}
HELD_OUT: dict[Tuned, int] = {"gpr": 20, "rf": 5, "svr": 20, "xgb": 5, "extra_trees": 100}


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
    outer_repeats: Count = 10
    """repeats of the nested cross-validation, each shuffled differently"""
    random_splits: Count = 20
    """random splits of the size of the locked one"""
    # Trees of a forest in an outer fold at most: more trees only change its noise.
    largest_forest: ClassVar[int] = 100
    conformal_folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the CV+ predictive intervals, and of the errors that give other models a normal distribution"""
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


class Choices(Section):
    """Choices that the thesis leaves open. The defaults come nearest to its Table 5.6 (see choices.tsv)."""

    linear_features: list[str] = Field(default=["bpr", "molar_ratio", "time_h"], min_length=1)
    """features of the linear baseline"""
    length_scales: Literal["per_feature", "shared"] = "per_feature"
    """Matern kernel with a length scale for each feature, or one for all"""
    kernel_bounds: Interval = [1e-5, 1e5]
    """bounds of the kernel's hyper-parameters in the marginal likelihood"""
    time_model: Literal["same", "linear"] = "same"
    """first step of a two-step model: the same algorithm, or a straight line"""
    residual_weights: Literal["yield", "residual"] = "yield"
    """the weight of Eq. 5.3, when the residual model is tuned, follows the yield or the residual"""
    max_features: Annotated[float, Field(gt=0, le=1)] = 1.0
    """fraction of the features available at a forest's node [-]"""


class TrainingConfig(Section):
    """How a model is trained, whatever the budget of its search."""

    # Eq. 5.3: errors above this yield [%] have this weight, all others 1.
    high_yield_percent: ClassVar[float] = 70.0
    high_yield_weight: ClassVar[float] = 2.0
    seed: Seed = 42
    """seed of the folds, the search and the trees"""
    # Starts of the regressor gpr_starts, drawn within spaces.gpr [-].
    kernel_starts: ClassVar[int] = 8
    spaces: Spaces = SPACE_BOUNDS
    """bounds [low, high] of the search in place of those of Tables 5.2 to 5.5, by regressor and hyper-parameter"""
    choices: Choices = Choices()


class LibraryTrialConfig(Section):
    """What the averaged process gains by the choice of its library, and whether chance could reach its score."""

    earlier: LibraryConfig = LibraryConfig(links=["identity", "logit", "avrami"], time_h=["linear", "log"])
    """library scored next to that of `averaging`: the earlier one, chosen after seeing scores"""
    sub_libraries: Count = 500
    """random halves of a library, each scored by the same folds"""
    permutations: Annotated[int, Field(ge=19, le=100_000)] = 199
    """shuffles of the yields among the runs; the smallest p-value is 1 / (1 + permutations)"""
    # Seed of the halves and of the shuffles.
    seed: ClassVar[int] = 42


class YieldConfig(Section):
    """Settings of the yield stage (thesis chapter 5)."""

    out_of_domain: ProjectFile
    """table of runs outside the trained domain (Table 5.7)"""
    # Level of the predictive intervals in tables and figures [-].
    interval_level: ClassVar[float] = 0.95
    models: RegressorList = [*COMPARED]
    """regressors of the models that are trained; those of Table 5.6 and gpr_starts at least"""
    training: TrainingConfig = TrainingConfig()
    search: SearchConfig = SearchConfig()
    searched_again: list[Literal["search_seed", "residual_weights"]] = ["search_seed", "residual_weights"]
    """choices that are also searched with another value: the seed (every tuned model), the weights of residuals
    (two-step models); [] for none. Together they take longer than the models themselves
    """
    evaluation: EvaluationConfig = EvaluationConfig()
    other_sources: OtherSourcesConfig = OtherSourcesConfig()
    averaging: AveragingConfig = AveragingConfig()
    library_trial: LibraryTrialConfig = LibraryTrialConfig()
    proposals: ProposalConfig
    retrospective: RetrospectiveConfig = RetrospectiveConfig()
    prediction: PredictionConfig
