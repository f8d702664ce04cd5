"""Chapter 5 against its claims: yield models on the locked split and outside their domain."""

from pathlib import Path

import pandas as pd

from millprint.claims.compare import agrees
from millprint.claims.finding import Finding
from millprint.files import read_table
from millprint.predict.catalogue import MODELS
from millprint.predict.honest import LEFT_OUT, NESTED, RANDOM
from millprint.predict.judge import GAINS
from millprint.predict.metrics import METRICS

UNITS = {"rmse": "pp", "mae": "pp", "mape": "%", "r2": "", "wmse": "pp2"}
# How the open choices were settled; every row of the table was computed from training rows alone.
RECIPES = {
    "linear": "least squares on three features; found by its printed row, as is the split",
    "gpr": "the search sets where the marginal likelihood starts, with a length scale for each feature; both read off "
    "the printed row",
    "rf": "every node sees the share of features in yields.training.choices; one seed for everything, not chosen",
    "svr": "one seed for everything, not chosen",
    "xgb": "one seed for everything, not chosen; choices.tsv shows what other seeds of the trees do",
}


def _name(model: str, strategy: str) -> str:
    return model if model == "linear" else f"{model}.{strategy}"


def _row(table: pd.DataFrame, **keys: str) -> pd.Series | None:
    """The one row of these keys, or None."""
    mask = pd.Series(True, index=table.index)
    for column, value in keys.items():
        mask &= table[column] == value
    rows = table[mask]
    return rows.iloc[0] if len(rows) == 1 else None


def _against_printed(metric: str, value: float, printed: str | None) -> str:
    """Whether a metric is better than printed, for rows that deviate to the good side."""
    if printed is None:
        return ""
    gain = value - float(printed) if metric in GAINS else float(printed) - value
    return f"; better than printed by {abs(gain):.3g}" if gain > 0.1 * abs(float(printed)) else ""


def _scheme(honest: pd.DataFrame, keys: dict[str, str], scheme: str, title: str, unit: str) -> str:
    """A figure of another scheme with its interval, or nothing where it was not run."""
    row = _row(honest, **keys, scheme=scheme)
    if row is None:
        return ""
    return f"{title} {row['value']:.3g} ({row['lower']:.3g} to {row['upper']:.3g}){unit}"


def _metric(
    honest: pd.DataFrame, model: str, strategy: str, metric: str, rows: int, printed: str | None = None
) -> Finding:
    """A metric of the locked split, with its interval and the figures of the honest schemes beside it."""
    keys = {"model": model, "strategy": strategy, "metric": metric}
    locked = _row(honest, **keys, scheme="locked")
    if locked is None:
        return Finding(None, f"not run: results/yield/honest.tsv has no {metric} of {model} {strategy}")
    unit = f" {UNITS[metric]}" if UNITS[metric] else ""
    value = float(locked["value"])
    parts = [
        f"{rows} test rows decide nothing: over resamples of them {locked['lower']:.3g} to {locked['upper']:.3g}{unit}",
        _scheme(honest, keys, LEFT_OUT, "leave-one-out", unit),
        _scheme(honest, keys, NESTED, "nested cross-validation", unit),
        _scheme(honest, keys, RANDOM, "other splits of this size", unit),
    ]
    text = "; ".join(part for part in parts if part) + _against_printed(metric, value, printed)
    return Finding(value, f"{text}. {RECIPES[model].capitalize()}.")


def _outside(table: pd.DataFrame, case: str, model: str) -> Finding:
    row = _row(table, case=case, model=model, strategy="two_step")
    if row is None:
        return Finding(None, f"not run: results/yield/out_of_domain.tsv has no case {case} of {model}")
    interval = ""
    if pd.notna(row["deviation_pp"]):
        interval = f"; interval {row['lower_percent']:.0f} to {row['upper_percent']:.0f} %"
    return Finding(
        float(row["predicted_percent"]),
        f"measured {row['yield_percent']:g} %, error {row['error_pp']:+.1f} points{interval}; not fitted again",
    )


def _time_variance(results: Path, printed: str | None) -> Finding:
    table = read_table(results / "yield/time_variance.tsv", numeric=["share"], text=["measure"]).set_index("measure")
    levels, line = 100 * table.loc["levels", "share"], 100 * table.loc["line", "share"]
    beyond = printed is not None and levels < float(printed) and not agrees(printed, "report", levels)
    return Finding(
        levels,
        f"sum of squares between the times over the total, all runs: the most that any function of time explains; a "
        f"straight line explains {line:.1f} %",
        erratum=f"No function of time alone can explain {printed} % of these yields;" if beyond else "",
    )


def _shap(results: Path) -> Finding:
    table = read_table(results / "yield/shap_ranking.tsv", numeric=["mean_abs_shap_pp"], text=["model", "feature"])
    first, words = [], []
    for model, rows in table.groupby("model", sort=False):
        ranked = rows.sort_values("mean_abs_shap_pp", ascending=False)
        first.append(ranked["feature"].iloc[0].removesuffix("_h"))
        top = ", ".join(f"{row.feature} {row.mean_abs_shap_pp:.1f}" for row in ranked.head(3).itertuples())
        words.append(f"{model}: {top}")
    return Finding(" / ".join(dict.fromkeys(first)), f"mean |SHAP| in points over all runs; {'; '.join(words)}")


def findings(results: Path, data: Path) -> dict[str, Finding]:
    """A finding for every claim of chapter 5, from the tables in `results`/yield.

    `data` is the folder of the measured tables and of the claims, whose values are read to say which row is better.
    """
    printed = read_table(data / "claims.tsv", text=["id", "value"]).set_index("id")["value"]
    honest = read_table(
        results / "yield/honest.tsv",
        numeric=["value", "lower", "upper"],
        text=["model", "strategy", "scheme", "metric"],
    )
    locked = read_table(results / "yield/locked.tsv", numeric=["test_rows"], text=["model", "strategy"])
    outside = read_table(
        results / "yield/out_of_domain.tsv",
        numeric=["yield_percent", "predicted_percent", "error_pp"],
        text=["case", "model", "strategy"],
    )
    rows = int(locked["test_rows"].iloc[0])
    found = {
        f"5.{_name(model, strategy)}.{metric}": _metric(
            honest, model, strategy, metric, rows, printed.get(f"5.{_name(model, strategy)}.{metric}")
        )
        for model, strategy in MODELS
        for metric in METRICS
    }
    for case in ("27", "28"):
        for model in ("gpr", "xgb"):
            found[f"5.ood.{case}.{model}"] = _outside(outside, case, model)
    return found | {
        "5.time_variance": _time_variance(results, printed.get("5.time_variance")),
        "5.shap.first": _shap(results),
    }
