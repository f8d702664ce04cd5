"""The verdict on every measured number: the prediction, both intervals, the ratio, and why a prediction is off.

- `within both intervals`: the predicted value lies within the measured interval, and the measured value within the
  predicted one. Where either has no interval, this verdict is not given.
- `within 10 %`: the deviation is at most 10 % of the measured value. For angles, places and counts it is at most the
  tolerance of their unit (millprint.validation.measured.UNITS); in a series that changes its sign, at most 10 % of the
  measured value or of the mean size of the series, since a ratio says nothing near zero. The column `tolerance` has the
  number that was used.
- `off`: anything else. The explanation is that of explanations.yaml, or `unexplained`.
- `set-up unknown`: the source does not say enough for a prediction. Where there is a number all the same, it is an
  order of magnitude and is not judged.
"""

from collections.abc import Collection
from dataclasses import dataclass
from math import inf, isclose, nan
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from millprint.validation.measured import UNITS, UNKNOWN
from millprint.validation.predictions import DEM

BOTH, NEAR, OFF, NO_SETUP = "within both intervals", "within 10 %", "off", "set-up unknown"
NOT_RUN = "not run"
VERDICTS = (BOTH, NEAR, OFF, NO_SETUP, NOT_RUN)
UNEXPLAINED = "unexplained"
SHARE = 0.10
VERDICT_COLUMNS = (
    *("id", "setup", "quantity", "x", "measured", "measured_uncertainty", "unit", "class"),
    *("predicted", "predicted_lower", "predicted_upper", "interval", "ratio", "tolerance", "verdict"),
    *("settings", "explanation"),
)


@dataclass(frozen=True)
class Explanation:
    """Why predictions of a measured row are off, or what is known of it; from x `low` to `high`."""

    id: str
    text: str
    low: float = -inf
    high: float = inf

    def fits(self, id: str, x: float) -> bool:
        """Whether it is about this number."""
        return self.id == id and (x != x or self.low <= x <= self.high)


EXPLANATIONS = [
    # YAML reads an id such as 9 as a number.
    Explanation(**{**each, "id": str(each["id"])})
    for each in yaml.safe_load(Path(__file__).with_name("explanations.yaml").read_text())
]


def tolerance_of(series: pd.DataFrame) -> pd.Series:
    """The tolerated deviation of each point of one measured row; see the head of this file."""
    absolute = UNITS[series["unit"].iloc[0]]
    sizes = series["measured"].abs()
    if absolute is not None:
        return pd.Series(absolute, index=series.index)
    if series["measured"].min() < 0 < series["measured"].max():
        return SHARE * sizes.clip(lower=sizes.mean())
    return SHARE * sizes


def verdict_of(point: dict, tolerance: float, unknown: Collection[str] = ()) -> str:
    """The verdict on one measured number with its prediction; keys as in the columns of both tables.

    unknown: set-ups of which too little is known.
    """
    if point["setup"] in (UNKNOWN, *unknown):
        return NO_SETUP
    predicted, measured = point["predicted"], point["measured"]
    if predicted != predicted:
        return NOT_RUN
    # Comparisons with a bound that is not a number are false.
    if point["measured_lower"] <= predicted <= point["measured_upper"] and point["lower"] <= measured <= point["upper"]:
        return BOTH
    return NEAR if abs(predicted - measured) <= tolerance * (1 + 1e-9) else OFF


def find_explanation(id: str, x: float, verdict: str, explanations: list[Explanation]) -> str:
    """The texts about a number; `unexplained` for a miss without one, empty for a hit without one."""
    texts = [each.text.strip() for each in explanations if each.fits(id, x)]
    if texts and verdict != BOTH:
        return " ".join(texts)
    return UNEXPLAINED if verdict == OFF else ""


def _predicted_at(predictions: pd.DataFrame, id: str, x: float) -> dict:
    """The prediction of a measured number: that of its id at its x; without numbers if there is none."""
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
    predictions: pd.DataFrame,
    settings: dict[str, str],
    explanations: list[Explanation] = EXPLANATIONS,
    unknown: Collection[str] = (),
) -> pd.DataFrame:
    """A row (VERDICT_COLUMNS) for each measured number.

    points: of `measured_points`; predictions: of all set-ups that were run, together; settings: for each, whether its
    settings are those that were fixed, in words; unknown: set-ups of which too little is known for a verdict. A set-up
    that was not run has the verdict `not run`.
    Raises ValueError for a prediction in another unit than the measured value.
    """
    rows = []
    for id, series in points.groupby("id", sort=False):
        tolerances = tolerance_of(series)
        for place, point in series.iterrows():
            found = _predicted_at(predictions, str(id), point["x"])
            if found["unit"] not in (None, point["unit"]):
                raise ValueError(f"{id}: predicted in {found['unit']}, measured in {point['unit']}")
            both = {**point.to_dict(), **{name: value for name, value in found.items() if name != "unit"}}
            verdict = verdict_of(both, tolerances[place], unknown)
            half = (point["measured_upper"] - point["measured_lower"]) / 2
            rows.append(
                {
                    **both,
                    "measured_uncertainty": half if half < inf else nan,
                    "predicted_lower": found["lower"],
                    "predicted_upper": found["upper"],
                    "ratio": found["predicted"] / point["measured"] if point["measured"] else nan,
                    "tolerance": tolerances[place],
                    "verdict": verdict,
                    "settings": settings.get(point["setup"], ""),
                    "explanation": find_explanation(str(id), point["x"], verdict, explanations),
                }
            )
    return pd.DataFrame(rows, columns=list(VERDICT_COLUMNS))


def count_verdicts(verdicts: pd.DataFrame) -> pd.DataFrame:
    """How many numbers of each set-up have each verdict: a row for each set-up, a column for each verdict."""
    counts = pd.crosstab(verdicts["setup"], verdicts["verdict"]).reindex(columns=list(VERDICTS), fill_value=0)
    return counts.reset_index().rename_axis(None, axis=1)
