"""The models of thesis Table 5.6, by algorithm and strategy."""

MODELS = (
    ("linear", "primary"),
    *((algorithm, strategy) for algorithm in ("gpr", "rf", "svr", "xgb") for strategy in ("primary", "two_step")),
)
