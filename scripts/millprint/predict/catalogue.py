"""The yield models: those of thesis Table 5.6 by algorithm and strategy, and the one chosen on training data alone."""

MODELS = (
    ("linear", "primary"),
    *((algorithm, strategy) for algorithm in ("gpr", "rf", "svr", "xgb") for strategy in ("primary", "two_step")),
)
AVERAGED = "averaged_gpr"
EVERY_MODEL = (*MODELS, (AVERAGED, "primary"))
# Choices whose other value needs a search of its own, and the models that they bear on.
SEARCHED_AGAIN = (
    *((model, strategy, "search_seed") for model, strategy in MODELS if model != "linear"),
    *((model, strategy, "residual_weights") for model, strategy in MODELS if strategy == "two_step"),
)
