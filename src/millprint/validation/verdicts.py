"""The verdict on every measured number: the prediction, both intervals, the ratio, and why a prediction is off.

- `within both intervals`: the predicted value is within the measured interval, and the measured value within the
  predicted one. This verdict needs both intervals.
- `within 10 %`: the deviation is at most 10 % of the measured value.
- `near`: where a ratio has little meaning, the deviation is at most a fixed tolerance. For angles, places and counts,
  the unit sets it (millprint.validation.measured.UNITS); in a series that changes its sign, it is 10 % of the measured
  value or of the mean size of the series. The column `tolerance` has the number that was used.
- `off`: anything else, with a text from millprint.validation.explanations.
- `set-up unknown`: the source does not state enough for a prediction. If there is a number, it is an order of magnitude
  and is not judged.
"""

from collections.abc import Collection, Mapping
from math import inf, isclose, nan

import numpy as np
import pandas as pd

from millprint.validation.explanations import explain
from millprint.validation.measured import UNITS, UNKNOWN
from millprint.validation.predictions import DEM

BOTH, TENTH, NEAR, OFF, NO_SETUP = "within both intervals", "within 10 %", "near", "off", "set-up unknown"
NOT_RUN = "not run"
VERDICTS = (BOTH, TENTH, NEAR, OFF, NO_SETUP, NOT_RUN)
SHARE = 0.10
VERDICT_COLUMNS = (
    *("id", "setup", "quantity", "x", "measured", "measured_uncertainty", "unit", "class"),
    *("predicted", "predicted_lower", "predicted_upper", "interval", "ratio", "tolerance", "verdict"),
    *("settings", "note", "explanation"),
)


def tolerance_of(series: pd.DataFrame) -> tuple[pd.Series, str]:
    """The tolerated deviation of each point of one measured row, and the verdict on a smaller one."""
    absolute = UNITS[series["unit"].iloc[0]]
    sizes = series["measured"].abs()
    if absolute is not None:
        return pd.Series(absolute, index=series.index), NEAR
    if series["measured"].min() < 0 < series["measured"].max():
        return SHARE * sizes.clip(lower=sizes.mean()), NEAR
    return SHARE * sizes, TENTH


def verdict_of(point: dict, tolerance: float, close: str, unknown: Collection[str] = ()) -> str:
    """The verdict on one measured number with its prediction; keys as in the columns of both tables.

    close: the verdict on a deviation within the tolerance; unknown: set-ups of which too little is known.
    """
    if point["setup"] in (UNKNOWN, *unknown):
        return NO_SETUP
    predicted, measured = point["predicted"], point["measured"]
    if predicted != predicted:
        return NOT_RUN
    # Comparisons with a NaN bound are false.
    if point["measured_lower"] <= predicted <= point["measured_upper"] and point["lower"] <= measured <= point["upper"]:
        return BOTH
    return close if abs(predicted - measured) <= tolerance * (1 + 1e-9) else OFF


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
    points: pd.DataFrame,
    predictions: Mapping[str, pd.DataFrame],
    settings: Mapping[str, str],
    variants: Mapping[str, Collection[str]],
    unknown: Collection[str] = (),
) -> pd.DataFrame:
    """A row (VERDICT_COLUMNS) for each measured number.

    points: of `measured_points`. By set-up: predictions, if it was run; settings: whether they are as fixed, in words;
    variants: beginnings of the names of models that may explain a miss. unknown: set-ups with too little information
    for a verdict. A set-up that was not run has the verdict `not run`.
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
            half = (point["measured_upper"] - point["measured_lower"]) / 2
            rows.append(
                {
                    **both,
                    "measured_uncertainty": half if half < inf else nan,
                    "predicted_lower": found["lower"],
                    "predicted_upper": found["upper"],
                    "ratio": found["predicted"] / point["measured"] if point["measured"] else nan,
                    "tolerance": tolerances[place],
                    "verdict": verdict_of(both, tolerances[place], close, unknown),
                    "settings": settings.get(point["setup"], ""),
                    "explanation": "",
                }
            )
    verdicts = pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))
    other = {name: own[own["model"].str.startswith(tuple(variants.get(name, ())))] for name, own in predictions.items()}
    for _, numbers in verdicts.groupby("class"):
        texts = explain(numbers, numbers["verdict"] == OFF, other)
        verdicts.loc[texts.index, "explanation"] = texts
    return verdicts


def count_verdicts(verdicts: pd.DataFrame) -> pd.DataFrame:
    """How many numbers of each set-up have each verdict: a row for each set-up, a column for each verdict."""
    counts = pd.crosstab(verdicts["setup"], verdicts["verdict"]).reindex(columns=list(VERDICTS), fill_value=0)
    return counts.reset_index().rename_axis(None, axis=1)
