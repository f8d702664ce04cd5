"""The yield models: those of thesis Table 5.6 by algorithm and strategy, and the one chosen on training data alone."""

from collections.abc import Sequence

from millprint.config.yields import TrainingConfig

MODELS = (
    ("linear", "primary"),
    *((algorithm, strategy) for algorithm in ("gpr", "rf", "svr", "xgb") for strategy in ("primary", "two_step")),
)
AVERAGED = "averaged_gpr"
EVERY_MODEL = (*MODELS, (AVERAGED, "primary"))
# Choices whose other value needs a search of its own, and the models that they bear on.
BEARS_ON = {
    "search_seed": tuple(pair for pair in MODELS if pair[0] != "linear"),
    "residual_weights": tuple(pair for pair in MODELS if pair[1] == "two_step"),
}


def searched_again(choices: Sequence[str]) -> list[tuple[str, str, str]]:
    """Algorithm, strategy and choice of every model that is searched anew for some keys of BEARS_ON."""
    return [(*pair, choice) for choice in choices for pair in BEARS_ON[choice]]


def otherwise(settings: TrainingConfig, choice: str) -> TrainingConfig:
    """The settings with another value of a choice that a search depends on: search_seed or residual_weights."""
    if choice == "search_seed":
        return settings.model_copy(update={"seed": settings.seed + 1})
    other = "residual" if settings.choices.residual_weights == "yield" else "yield"
    return settings.model_copy(update={"choices": settings.choices.model_copy(update={"residual_weights": other})})
