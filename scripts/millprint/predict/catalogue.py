"""The yield models: those of thesis Table 5.6 by algorithm and strategy, and the one chosen on training data alone."""

MODELS = (
    ("linear", "primary"),
    *((algorithm, strategy) for algorithm in ("gpr", "rf", "svr", "xgb") for strategy in ("primary", "two_step")),
)
AVERAGED = "averaged_gpr"
EVERY_MODEL = (*MODELS, (AVERAGED, "primary"))
