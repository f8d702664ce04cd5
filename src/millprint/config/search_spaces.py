"""Settings of the regressors: which of them are trained, and the search spaces of their hyper-parameters."""

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from millprint.config.section import Count, NonNegative, Positive, Section

# The models of thesis Table 5.6, in its order. The linear one has no hyper-parameters and takes one step.
TABLE_5_6 = ("linear", "gpr", "rf", "svr", "xgb")
Draw = Literal["uniform", "logarithmic", "whole"]


@dataclass(frozen=True)
class Drawn:
    """How the search draws a hyper-parameter between its bounds: logarithmic is uniform in the logarithm."""

    how: Draw


Pair = Field(min_length=2, max_length=2)
Interval = Annotated[list[Positive], Pair]
Uniform = Annotated[list[Positive], Pair, Drawn("uniform")]
UniformFromZero = Annotated[list[NonNegative], Pair, Drawn("uniform")]
Logarithmic = Annotated[list[Positive], Pair, Drawn("logarithmic")]
Whole = Annotated[list[Count], Pair, Drawn("whole")]
WholeFromTwo = Annotated[list[Annotated[int, Field(ge=2, le=100_000)]], Pair, Drawn("whole")]


class SearchSpace(Section):
    """A search space: a lower and an upper bound for each hyper-parameter."""

    @model_validator(mode="after")
    def _bounds_rise(self) -> "SearchSpace":
        for name in type(self).model_fields:
            low, high = getattr(self, name)
            if low >= high:
                raise ValueError(f"{name} = [{low}, {high}]: the first bound must be below the second")
        return self

    @classmethod
    def draws(cls) -> dict[str, Draw]:
        """How each hyper-parameter is drawn."""
        fields = cls.model_fields.items()
        return {name: mark.how for name, field in fields for mark in field.metadata if isinstance(mark, Drawn)}


class GprSpace(SearchSpace):
    """Table 5.2: starting points for maximising the marginal likelihood (Eq. 5.10)."""

    constant: Uniform = [0.1, 1000.0]
    """constant scaling C, uniform [pp2]"""
    length_scale: Uniform = [0.05, 10.0]
    """length scale l, uniform [standard deviations of a feature]"""
    noise: Uniform = [1e-5, 1.5]
    """noise variance, uniform [pp2]"""


class RfSpace(SearchSpace):
    """Table 5.3, uniform on whole numbers."""

    n_estimators: Whole = [50, 300]
    """number of trees"""
    max_depth: Whole = [5, 30]
    """largest depth of a tree"""
    min_samples_split: WholeFromTwo = [2, 20]
    """rows that a node needs to be split"""
    min_samples_leaf: Whole = [1, 10]
    """rows that a leaf needs"""


class SvrSpace(SearchSpace):
    """Table 5.4."""

    C: Logarithmic = [0.1, 100.0]
    """regularisation, uniform in its logarithm [-]"""
    epsilon: Uniform = [0.001, 1.0]
    """half width of the insensitive tube, uniform [pp]"""
    gamma: Logarithmic = [0.001, 1.0]
    """kernel scale of Eq. 5.13, uniform in its logarithm [-]"""


class XgbSpace(SearchSpace):
    """Table 5.5."""

    max_depth: Whole = [3, 10]
    """largest depth of a tree, uniform on whole numbers"""
    learning_rate: Logarithmic = [0.01, 0.3]
    """learning rate, uniform in its logarithm [-]"""
    n_estimators: Whole = [100, 500]
    """number of trees, uniform on whole numbers"""
    subsample: Uniform = [0.5, 1.0]
    """fraction of the rows for a tree, uniform [-]"""
    colsample_bytree: Uniform = [0.5, 1.0]
    """fraction of the features for a tree, uniform [-]"""
    gamma: UniformFromZero = [0.0, 5.0]
    """smallest loss reduction that splits a node, uniform [pp2]"""


class ExtraTreesSpace(RfSpace):
    """As for the random forest. Extremely randomised trees (Geurts et al. 2006) draw thresholds and see every row."""


class Spaces(Section):
    """The search space of each regressor."""

    gpr: GprSpace = GprSpace()
    rf: RfSpace = RfSpace()
    svr: SvrSpace = SvrSpace()
    xgb: XgbSpace = XgbSpace()
    extra_trees: ExtraTreesSpace = ExtraTreesSpace()


class Evaluations(Section):
    """Evaluations of the search for each regressor that is tuned, at least 1."""

    gpr: Count
    """evaluations for Gaussian-process regression"""
    rf: Count
    """evaluations for the random forest"""
    svr: Count
    """evaluations for support-vector regression"""
    xgb: Count
    """evaluations for XGBoost"""
    extra_trees: Count = 100
    """evaluations for extra trees, which are trained only if `models` lists them"""


TUNED = tuple(Spaces.model_fields)
# Without hyper-parameters to search, and of one step or two.
UNTUNED = ("gpr_starts",)
# What the report needs; further ones are trained where `models` lists them.
COMPARED = (*TABLE_5_6, "gpr_starts")
# The stem of the file of a stored model.
STORED_MODEL = rf"^(linear_primary|({'|'.join((*TUNED, *UNTUNED))})_(primary|two_step)|averaged_gpr_(primary|final))$"


def _complete_list(names: list[str]) -> list[str]:
    """Raise ValueError for an unknown regressor, one listed twice, or a missing one of Table 5.6."""
    known = ("linear", *TUNED, *UNTUNED)
    for name in names:
        if name not in known:
            raise ValueError(f"{name!r}: no such regressor; known: {', '.join(known)}")
        if names.count(name) > 1:
            raise ValueError(f"{name!r} is listed twice")
    for name in COMPARED:
        if name not in names:
            raise ValueError(f"{name!r} is missing: the report compares {', '.join(COMPARED)}")
    return names


RegressorList = Annotated[list[str], AfterValidator(_complete_list)]
