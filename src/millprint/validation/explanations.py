"""Why a prediction misses a measured number: a cause that other numbers confirm, or `not explained`.

Some set-ups have variants: predictions that change one thing of ours, such as the contact law in an impact or the
contact set in a drum. A variant explains a missed number only if it passes the test on all others:

- it meets every number of the same measured row, such as all speeds of a mill,
- it meets at least one more number that our prediction misses, in this set-up or in another one, and
- it misses none that our prediction meets, in any set-up.

A number is met within the tolerance of its verdict. Only numbers that the variant predicts count, and only numbers of
the same class: results of another code do not confirm an explanation of a measurement. Other possible causes were not
tested, and are not stated.
"""

from collections.abc import Mapping

import numpy as np
import pandas as pd

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
