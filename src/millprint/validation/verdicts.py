"""Verdicts on the predictions, what explains a miss, and how often intervals hold."""

from collections.abc import Collection, Mapping
from math import inf, isclose, isnan, nan

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.estimate.estimates import LEVEL, Estimate, Interval
from millprint.estimate.judge import BOTH, DIFFERS, NOT_RUN, OPEN, Allowed, Verdict, judge
from millprint.validation.measured import DEM, UNITS, UNKNOWN

NOT_EXPLAINED = "not explained"


def values_at(predictions: pd.DataFrame, quantity: str, places: pd.Series) -> np.ndarray:
    """The predictions of a model for a quantity at places; NaN where it predicts nothing.

    predictions: of one model; places: x, empty for a single number.
    """
    own = predictions[predictions["quantity"] == quantity]
    x, value = own["x"].to_numpy(dtype=float), own["predicted"].to_numpy(dtype=float)
    found = np.full(len(places), np.nan)
    for row, place in enumerate(places.to_numpy(dtype=float)):
        same = value[np.isclose(x, place, rtol=1e-9, atol=1e-12, equal_nan=True)]
        found[row] = same[0] if len(same) else np.nan
    return found


def met_by(model: str, numbers: pd.DataFrame, variants: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Which numbers our prediction (column `ours`) and a variant (`variant`) meet, of the numbers that both predict.

    numbers: rows of the verdicts; variants: predictions of all variants, by set-up.
    """
    value = pd.Series(np.nan, index=numbers.index)
    for (setup, quantity), group in numbers.groupby(["setup", "quantity"]):
        if str(setup) in variants:
            own = variants[str(setup)]
            value[group.index] = values_at(own[own["model"] == model], str(quantity), group["x"])
    met = pd.DataFrame({"id": numbers["id"]})
    for name, predicted in (("ours", numbers["predicted"]), ("variant", value)):
        met[name] = (predicted - numbers["measured"]).abs() <= numbers["tolerance"] * (1 + 1e-9)
    return met[value.notna() & numbers["predicted"].notna()]


def explain(numbers: pd.DataFrame, missed: pd.Series, variants: Mapping[str, pd.DataFrame]) -> pd.Series:
    """A text for each missed number: the variant that meets it and passes the test, or why none does.

    numbers: rows of the verdicts, all of one class; missed: which of them; variants: their predictions, by set-up.
    """
    models = {model: None for own in variants.values() for model in own["model"]}
    judged = {model: met_by(model, numbers, variants) for model in models}
    places = numbers.index[missed]
    return pd.Series([_explanation(place, judged) for place in places], index=places, dtype=object)


def _explanation(place: int, judged: Mapping[str, pd.DataFrame]) -> str:
    refused = []
    for model, met in judged.items():
        if place not in met.index or not met.loc[place, "variant"]:
            continue
        row = met[met["id"] == met.loc[place, "id"]]
        gained, lost = (met["variant"] & ~met["ours"]).sum(), (met["ours"] & ~met["variant"]).sum()
        counts = f"{met['variant'].sum()} of all {len(met)} numbers that it predicts, ours {met['ours'].sum()}"
        if row["variant"].all() and gained > 1 and not lost:
            return f"met by: {model}. It meets {counts}"
        refused.append(f"{model} meets this number, and {row['variant'].sum()} of {len(row)} of its row, {counts}")
    return "; ".join([NOT_EXPLAINED, *refused])


TENTH, NEAR, OFF, NO_SETUP = "within 10 %", "near", "off", "set-up unknown"
REASONS = (BOTH, TENTH, NEAR, OFF, NO_SETUP, NOT_RUN)
SHARE = 0.10
VERDICT_COLUMNS = (
    *("id", "setup", "quantity", "x", "measured", "measured_uncertainty", "unit", "class"),
    *("predicted", "predicted_lower", "predicted_upper", "interval", "ratio", "tolerance", "verdict", "reason"),
    *("note", "explanation"),
)


def tolerance_of(series: pd.DataFrame) -> tuple[pd.Series, str]:
    """The tolerated deviation of each point of one measured row, and the reason to accept a smaller one."""
    absolute = UNITS[series["unit"].iloc[0]]
    sizes = series["measured"].abs()
    if absolute is not None:
        return pd.Series(absolute, index=series.index), NEAR
    if series["measured"].min() < 0 < series["measured"].max():
        return SHARE * sizes.clip(lower=sizes.mean()), NEAR
    return SHARE * sizes, TENTH


def judge_number(point: dict, tolerance: float, close: str) -> Verdict:
    """The verdict on one measured number by its prediction; keys as in the columns of both tables.

    close: the reason to accept a deviation within the tolerance.
    """
    if point["setup"] == UNKNOWN:
        return Verdict(OPEN, NO_SETUP)
    measured, ends = point["measured"], Interval(point["measured_lower"], point["measured_upper"])
    value = Estimate(point["predicted"], point["unit"])
    if isnan(value.value):
        return judge(None, value)
    predicted = value.having({} if isnan(point["lower"]) else {"repeats": Interval(point["lower"], point["upper"])})
    both = judge(predicted, Estimate(measured, point["unit"], repeats=ends))
    if both.reason == BOTH:
        return both
    reach = tolerance * (1 + 1e-9)
    near = judge(value, Allowed(measured - reach, measured + reach))
    return Verdict(near.word, close if near.agrees else OFF)


def _predicted_at(predictions: pd.DataFrame, id: str, x: float) -> dict:
    """The prediction of a measured number, by its id and x; without numbers if there is none."""
    rows = predictions[(predictions["id"] == id) & (predictions["model"] == DEM)]
    same = [(x != x and each != each) or isclose(x, each, rel_tol=1e-9, abs_tol=1e-12) for each in rows["x"]]
    found = rows[np.asarray(same, dtype=bool)]
    names = ("predicted", "lower", "upper")
    if found.empty:
        return dict.fromkeys(names, nan) | {"interval": "", "unit": None}
    return {name: float(found[name].iloc[0]) for name in names} | {
        "interval": found["interval"].iloc[0],
        "unit": found["unit"].iloc[0],
    }


def give_verdicts(
    points: pd.DataFrame, predictions: Mapping[str, pd.DataFrame], variants: Mapping[str, Collection[str]]
) -> pd.DataFrame:
    """A row (VERDICT_COLUMNS) for each measured number.

    points: of `measured_points`. By set-up: predictions, if it was run; variants: beginnings of names of models that
    may explain a miss. Where a set-up was not run, the verdict is open.
    Raises ValueError for a prediction in another unit than the measured value.
    """
    together = pd.concat(predictions.values())
    rows = []
    for id, series in points.groupby("id", sort=False):
        tolerances, close = tolerance_of(series)
        for place, point in series.iterrows():
            found = _predicted_at(together, str(id), point["x"])
            if found["unit"] not in (None, point["unit"]):
                raise ValueError(f"{id}: predicted in {found['unit']}, measured in {point['unit']}")
            both = {**point.to_dict(), **{name: value for name, value in found.items() if name != "unit"}}
            verdict = judge_number(both, tolerances[place], close)
            half = (point["measured_upper"] - point["measured_lower"]) / 2
            rows.append(
                {
                    **both,
                    "measured_uncertainty": half if half < inf else nan,
                    "predicted_lower": found["lower"],
                    "predicted_upper": found["upper"],
                    "ratio": found["predicted"] / point["measured"] if point["measured"] else nan,
                    "tolerance": tolerances[place],
                    "verdict": verdict.word,
                    "reason": verdict.reason,
                    "explanation": "",
                }
            )
    verdicts = pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))
    other = {name: own[own["model"].str.startswith(tuple(variants.get(name, ())))] for name, own in predictions.items()}
    for _, numbers in verdicts.groupby("class"):
        texts = explain(numbers, numbers["verdict"] == DIFFERS, other)
        verdicts.loc[texts.index, "explanation"] = texts
    return verdicts


def count_verdicts(verdicts: pd.DataFrame) -> pd.DataFrame:
    """How many numbers of each set-up have each reason of a verdict: a row for a set-up, a column for a reason."""
    counts = pd.crosstab(verdicts["setup"], verdicts["reason"]).reindex(columns=list(REASONS), fill_value=0)
    return counts.reset_index().rename_axis(None, axis=1)


EVERY = "all"


def tabulate_coverage(verdicts: pd.DataFrame) -> pd.DataFrame:
    """A row for each set-up and kind of interval, for each kind, and for all: how many numbers the intervals hold.

    verdicts: of `give_verdicts`. Only measured numbers count, not results of other codes, and only with a prediction
    that has an interval and is judged. Columns: setup, interval, numbers; held: numbers within the predicted interval;
    share; lower, upper: Clopper and Pearson's interval of the share, as if the numbers were independent; overlapping:
    numbers whose stated uncertainty reaches the predicted interval.
    """
    measured = verdicts["class"].str.startswith("measured") & (verdicts["reason"] != NO_SETUP)
    known = verdicts[measured & verdicts["predicted_lower"].notna()]
    value, half = known["measured"], known["measured_uncertainty"].fillna(0.0)
    low, high = known["predicted_lower"], known["predicted_upper"]
    known = known.assign(held=value.between(low, high), overlapping=(value + half >= low) & (value - half <= high))
    groups = [known, known.assign(setup=EVERY), known.assign(setup=EVERY, interval=EVERY)]
    rows = []
    for (setup, interval), group in pd.concat(groups).groupby(["setup", "interval"], sort=False):
        held, numbers = int(group["held"].sum()), len(group)
        lower, upper = proportion_confint(held, numbers, alpha=1 - LEVEL, method="beta")
        rows.append(
            {
                "setup": setup, "interval": interval, "numbers": numbers, "held": held, "share": held / numbers,
                "lower": lower, "upper": upper, "overlapping": int(group["overlapping"].sum()),
            }
        )  # fmt: skip
    columns = ["setup", "interval", "numbers", "held", "share", "lower", "upper", "overlapping"]
    return pd.DataFrame(rows, columns=columns)
