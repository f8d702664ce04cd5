"""How the regressors are trained: which of them, by which strategies, and the search of their hyper-parameters."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, BeforeValidator, Field

from millprint.config.section import Positive

# The models of thesis Table 5.6, in its order. The linear one has no hyper-parameters and takes one step.
TABLE_5_6 = ("linear", "gpr", "rf", "svr", "xgb")
PRIMARY, TWO_STEP = "primary", "two_step"
Draw = Literal["uniform", "logarithmic", "whole"]
Interval = Annotated[list[Positive], Field(min_length=2, max_length=2)]


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
    # Extremely randomised trees (Geurts et al. 2006) draw thresholds and see every row; not of the thesis.
    "extra_trees": Training(FOREST, 100, 100),
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
