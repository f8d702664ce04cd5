"""Settings of the yield stage: models, search of hyper-parameters, and evaluation."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.averaging import AveragingConfig
from millprint.config.proposals import PredictionConfig, ProposalConfig, RetrospectiveConfig
from millprint.config.section import Count, Fraction, NonNegative, Positive, ProjectFile, Section, Seed

Algorithm = Literal["linear", "gpr", "rf", "svr", "xgb"]
Strategy = Literal["primary", "two_step"]
Interval = Annotated[list[Positive], Field(min_length=2, max_length=2)]
WholeInterval = Annotated[list[Count], Field(min_length=2, max_length=2)]


class Bounded(Section):
    """A search space: a lower and an upper bound for each hyper-parameter."""

    @model_validator(mode="after")
    def _bounds_rise(self) -> "Bounded":
        for name in type(self).model_fields:
            low, high = getattr(self, name)
            if low >= high:
                raise ValueError(f"{name} = [{low}, {high}]: the first bound must be below the second")
        return self


class GprSpace(Bounded):
    """Table 5.2: starting points for maximising the marginal likelihood (Eq. 5.10)."""

    constant: Interval = [0.1, 1000.0]
    """constant scaling C, uniform [pp2]"""
    length_scale: Interval = [0.05, 10.0]
    """length scale l, uniform [standard deviations of a feature]"""
    noise: Interval = [1e-5, 1.5]
    """noise variance, uniform [pp2]"""


class RfSpace(Bounded):
    """Table 5.3, uniform on whole numbers."""

    n_estimators: WholeInterval = [50, 300]
    """number of trees"""
    max_depth: WholeInterval = [5, 30]
    """largest depth of a tree"""
    min_samples_split: Annotated[list[Annotated[int, Field(ge=2, le=100_000)]], Field(min_length=2, max_length=2)] = [
        2,
        20,
    ]
    """rows that a node needs to be split"""
    min_samples_leaf: WholeInterval = [1, 10]
    """rows that a leaf needs"""


class SvrSpace(Bounded):
    """Table 5.4."""

    C: Interval = [0.1, 100.0]
    """regularisation, uniform in its logarithm [-]"""
    epsilon: Interval = [0.001, 1.0]
    """half width of the insensitive tube, uniform [pp]"""
    gamma: Interval = [0.001, 1.0]
    """kernel scale of Eq. 5.13, uniform in its logarithm [-]"""


class XgbSpace(Bounded):
    """Table 5.5."""

    max_depth: WholeInterval = [3, 10]
    """largest depth of a tree, uniform on whole numbers"""
    learning_rate: Interval = [0.01, 0.3]
    """learning rate, uniform in its logarithm [-]"""
    n_estimators: WholeInterval = [100, 500]
    """number of trees, uniform on whole numbers"""
    subsample: Interval = [0.5, 1.0]
    """fraction of the rows for a tree, uniform [-]"""
    colsample_bytree: Interval = [0.5, 1.0]
    """fraction of the features for a tree, uniform [-]"""
    gamma: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] = [0.0, 5.0]
    """smallest loss reduction that splits a node, uniform [pp2]"""


class Spaces(Section):
    """The search space of each algorithm."""

    gpr: GprSpace = GprSpace()
    rf: RfSpace = RfSpace()
    svr: SvrSpace = SvrSpace()
    xgb: XgbSpace = XgbSpace()


class Evaluations(Section):
    """Evaluations of the search for each algorithm that is tuned, one at least."""

    gpr: Count
    """evaluations for Gaussian-process regression"""
    rf: Count
    """evaluations for the random forest"""
    svr: Count
    """evaluations for support-vector regression"""
    xgb: Count
    """evaluations for XGBoost"""


class SearchConfig(Section):
    """The search by hyperopt's tree-structured Parzen estimator (thesis Sec. 5.2.6)."""

    evaluations: Evaluations = Evaluations(gpr=100, rf=100, svr=500, xgb=100)
    """sets of hyper-parameters that are tried for each step of a model"""
    folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the cross-validation"""
    repeats: Count = 3
    """repeats of the cross-validation, each shuffled differently"""


class HeldOutConfig(SearchConfig):
    """Predictions of every run by models that were not trained on it; each outer fold repeats search and fit."""

    # By default a smaller search than for the models themselves, since it is repeated many times.
    evaluations: Evaluations = Evaluations(gpr=5, rf=5, svr=20, xgb=5)
    """sets of hyper-parameters that are tried for each step of a model, in every outer fold"""
    folds: Annotated[int, Field(ge=2, le=100_000)] = 4
    """folds of the inner cross-validation"""
    repeats: Count = 1
    """repeats of the inner cross-validation, each shuffled differently"""
    outer_folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the nested cross-validation"""
    outer_repeats: Count = 4
    """repeats of the nested cross-validation, each shuffled differently"""
    random_splits: Count = 20
    """random splits of the size of the locked one"""
    permutations: Count = 8
    """shuffles of the yields among the runs, each cross-validated once"""
    conformal_folds: Annotated[int, Field(ge=2, le=100_000)] = 5
    """folds of the CV+ predictive intervals"""
    seed: Seed = 42
    """of the outer folds, the shuffles and the bootstrap"""
    nominal: list[Fraction] = Field(default=[0.5, 0.8, 0.95], min_length=1)
    """levels at which predictive intervals are checked [-]"""


class HonestConfig(HeldOutConfig):
    """Evaluation over all runs, with scaling, search and fit repeated inside every outer fold."""

    resamples: Count = 10_000
    """bootstrap resamples for each interval"""
    level: Fraction = 0.95
    """level of the bootstrap intervals [-]"""


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

    high_yield_percent: NonNegative = 70.0
    """errors above this yield have a larger weight, Eq. 5.3 [%]"""
    high_yield_weight: Positive = 2.0
    """weight of an error above high_yield_percent [-]"""
    seed: Seed = 42
    """of the folds, the search and the trees"""
    spaces: Spaces = Spaces()
    choices: Choices = Choices()


class YieldConfig(Section):
    """Settings of the yield stage (thesis chapter 5)."""

    out_of_domain: ProjectFile
    """table of runs outside the trained domain (Table 5.7)"""
    interval_level: Fraction = 0.95
    """level of the predictive intervals in tables and figures [-]"""
    training: TrainingConfig = TrainingConfig()
    search: SearchConfig = SearchConfig()
    searched_again: list[Literal["search_seed", "residual_weights"]] = ["search_seed", "residual_weights"]
    """choices that are also searched with another value: the seed (every tuned model), the weights of residuals
    (two-step models); [] for none. Together they take longer than the models themselves
    """
    honest: HonestConfig = HonestConfig()
    averaging: AveragingConfig = AveragingConfig()
    proposals: ProposalConfig
    retrospective: RetrospectiveConfig = RetrospectiveConfig()
    prediction: PredictionConfig
