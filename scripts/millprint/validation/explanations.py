"""Why a prediction misses a measured number: what the tables show and other numbers confirm, or `not explained`.

Some set-ups have variants: predictions that change one thing of ours, such as the contact law in an impact or the
contact set in a drum. A variant that meets a missed number explains it only if it stands the test on the other
measured numbers of the set-up:

- it meets at least one more number that our prediction misses, and
- it misses none that our prediction meets.

A number is met within the tolerance of its verdict. Numbers of another class, such as those of another code, do not
count. All else that may be the cause was not tested, and is not said.
"""

from collections.abc import Collection

import numpy as np
import pandas as pd

NOT_EXPLAINED = "not explained"


def values_at(predictions: pd.DataFrame, quantity: str, places: pd.Series) -> np.ndarray:
    """What a model predicts of a quantity at places; not a number where it predicts nothing.

    predictions: of one model; places: x, empty for a single number.
    """
    own = predictions[predictions["quantity"] == quantity]
    x, value = own["x"].to_numpy(dtype=float), own["predicted"].to_numpy(dtype=float)
    found = np.full(len(places), np.nan)
    for row, place in enumerate(places.to_numpy(dtype=float)):
        same = value[np.isclose(x, place, rtol=1e-9, atol=1e-12, equal_nan=True)]
        found[row] = same[0] if len(same) else np.nan
    return found


def met_by(numbers: pd.DataFrame, predictions: pd.DataFrame) -> pd.DataFrame:
    """Which measured numbers our prediction (column `ours`) and a variant (`variant`) meet; those that both predict.

    numbers: rows of the verdicts of a set-up; predictions: of the variant.
    """
    value = pd.Series(np.nan, index=numbers.index)
    for quantity, group in numbers.groupby("quantity"):
        value[group.index] = values_at(predictions, str(quantity), group["x"])
    deviations = {"ours": numbers["predicted"] - numbers["measured"], "variant": value - numbers["measured"]}
    met = pd.DataFrame({name: each.abs() <= numbers["tolerance"] * (1 + 1e-9) for name, each in deviations.items()})
    return met[value.notna() & numbers["predicted"].notna()]


def explain(missed: Collection[int], numbers: pd.DataFrame, predictions: pd.DataFrame) -> dict[int, str]:
    """A text for each missed number: the variant that meets it and stands the test, or why none does.

    missed: places in `numbers`, the verdicts on the numbers of one set-up and one class; predictions: of its variants.
    """
    judged = {str(name): met_by(numbers, own) for name, own in predictions.groupby("model", sort=False)}
    return {place: _explanation(place, judged) for place in missed}


def _explanation(place: int, judged: dict[str, pd.DataFrame]) -> str:
    refused = []
    for name, met in judged.items():
        if place not in met.index or not met.loc[place, "variant"]:
            continue
        gained, lost = (met["variant"] & ~met["ours"]).sum(), (met["ours"] & ~met["variant"]).sum()
        theirs, ours = met["variant"].sum(), met["ours"].sum()
        counts = f"{theirs} of the {len(met)} numbers of this set-up that it predicts, ours {ours}"
        if gained > 1 and not lost:
            return f"met by: {name}. It meets {counts}"
        refused.append(f"{name} meets this number, but {counts}" if lost else f"{name} meets this number only")
    return "; ".join([NOT_EXPLAINED, *refused])
