"""Settings of the yield stage: the models, the search of their hyper-parameters, and how they are judged."""

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
                raise ValueError(f"{name} = [{low}, {high}]: a lower and then a higher bound is wanted")
        return self


class GprSpace(Bounded):
    """Table 5.2. The values drawn are where the marginal likelihood (Eq. 5.10) starts to climb."""

    constant: Interval = Field(description="constant scaling C, uniform [pp2]")
    length_scale: Interval = Field(description="length scale l, uniform [standard deviations of a feature]")
    noise: Interval = Field(description="noise variance, uniform [pp2]")


class RfSpace(Bounded):
    """Table 5.3, uniform on whole numbers."""

    n_estimators: WholeInterval = Field(description="number of trees")
    max_depth: WholeInterval = Field(description="largest depth of a tree")
    min_samples_split: Annotated[list[Annotated[int, Field(ge=2, le=100_000)]], Field(min_length=2, max_length=2)] = (
        Field(description="rows that a node needs to be split")
    )
    min_samples_leaf: WholeInterval = Field(description="rows that a leaf needs")


class SvrSpace(Bounded):
    """Table 5.4."""

    C: Interval = Field(description="regularisation, uniform in its logarithm [-]")
    epsilon: Interval = Field(description="half width of the insensitive tube, uniform [pp]")
    gamma: Interval = Field(description="kernel scale of Eq. 5.13, uniform in its logarithm [-]")


class XgbSpace(Bounded):
    """Table 5.5."""

    max_depth: WholeInterval = Field(description="largest depth of a tree, uniform on whole numbers")
    learning_rate: Interval = Field(description="learning rate, uniform in its logarithm [-]")
    n_estimators: WholeInterval = Field(description="number of trees, uniform on whole numbers")
    subsample: Interval = Field(description="fraction of the rows for a tree, uniform [-]")
    colsample_bytree: Interval = Field(description="fraction of the features for a tree, uniform [-]")
    gamma: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] = Field(
        description="smallest loss reduction that splits a node, uniform [pp2]"
    )


class Spaces(Section):
    """Where each algorithm's hyper-parameters are looked for."""

    gpr: GprSpace
    rf: RfSpace
    svr: SvrSpace
    xgb: XgbSpace


class Evaluations(Section):
    """Evaluations of the search for each algorithm that is tuned, one at least."""

    gpr: Count = Field(description="evaluations for Gaussian-process regression")
    rf: Count = Field(description="evaluations for the random forest")
    svr: Count = Field(description="evaluations for support-vector regression")
    xgb: Count = Field(description="evaluations for XGBoost")


class SearchConfig(Section):
    """The search by hyperopt's tree-structured Parzen estimator (thesis Sec. 5.2.6)."""

    evaluations: Evaluations = Field(description="sets of hyper-parameters that are tried for each step of a model")
    folds: Annotated[int, Field(ge=2, le=100_000)] = Field(description="folds of the cross-validation")
    repeats: Count = Field(description="repeats of the cross-validation, each shuffled anew")


class HonestConfig(SearchConfig):
    """Evaluation over all runs, with scaling, search and fit repeated inside every outer fold."""

    outer_folds: Annotated[int, Field(ge=2, le=100_000)] = Field(description="folds of the nested cross-validation")
    outer_repeats: Count = Field(description="repeats of the nested cross-validation, each shuffled anew")
    random_splits: Count = Field(description="random splits of the size of the locked one")
    permutations: Count = Field(description="shuffles of the yields among the runs, each cross-validated once")
    conformal_folds: Annotated[int, Field(ge=2, le=100_000)] = Field(
        description="folds of the CV+ predictive intervals"
    )
    resamples: Count = Field(description="bootstrap resamples behind each interval")
    level: Fraction = Field(description="level of the bootstrap intervals [-]")
    seed: Seed = Field(description="of the outer folds, the shuffles and the bootstrap")
    nominal: list[Fraction] = Field(min_length=1, description="levels at which predictive intervals are checked [-]")


class Choices(Section):
    """What the thesis leaves open. The values are those that come nearest to its Table 5.6 (see choices.tsv)."""

    linear_features: list[str] = Field(min_length=1, description="features of the linear baseline")
    length_scales: Literal["per_feature", "shared"] = Field(
        description="Matern kernel with a length scale for each feature, or one for all"
    )
    kernel_bounds: Interval = Field(description="bounds of the kernel's hyper-parameters in the marginal likelihood")
    time_model: Literal["same", "linear"] = Field(
        description="first step of a two-step model: the same algorithm, or a straight line"
    )
    residual_weights: Literal["yield", "residual"] = Field(
        description="what decides the weight of Eq. 5.3 while the residual model is tuned"
    )
    max_features: Annotated[float, Field(gt=0, le=1)] = Field(
        description="fraction of the features that a forest's node sees [-]"
    )


class TrainingConfig(Section):
    """How a model is trained, whatever the budget of its search."""

    high_yield_percent: NonNegative = Field(description="yield above which an error counts more, Eq. 5.3 [%]")
    high_yield_weight: Positive = Field(description="weight of an error above it [-]")
    seed: Seed = Field(description="of the folds, the search and the trees")
    spaces: Spaces
    choices: Choices


class YieldConfig(Section):
    """Settings of the yield stage (thesis chapter 5)."""

    out_of_domain: ProjectFile = Field(description="table of runs outside the trained domain (Table 5.7)")
    interval_level: Fraction = Field(description="level of the predictive intervals in tables and figures [-]")
    training: TrainingConfig
    search: SearchConfig
    searched_again: list[Literal["search_seed", "residual_weights"]] = Field(
        description="choices that are also searched with another value: the seed (every tuned model), the weights of "
        "residuals (two-step models); [] for none. Together they take longer than the models themselves"
    )
    honest: HonestConfig
    averaging: AveragingConfig
    proposals: ProposalConfig
    retrospective: RetrospectiveConfig
    prediction: PredictionConfig
