"""Two mills: their descriptors side by side, and the conditions of one nearest to the other's."""

import math
from typing import Any

import pandas as pd

from millprint.config.charge import ONE_SIZE
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.load import check_model
from millprint.estimate.estimates import ratio_of
from millprint.fingerprint.condition_search import counts_alike, rank_conditions, target_at
from millprint.fingerprint.model import Fingerprint
from millprint.observables.condition import Condition
from millprint.observables.definitions import DESCRIPTOR_SETS, POWER, POWER_PARTS, PREDICTED

# What `compare` compares: what mills are matched by, then the power and its parts.
COMPARED = (*(name for names in DESCRIPTOR_SETS.values() for name in names), POWER, *POWER_PARTS)


def match(
    one: Fingerprint, condition: Condition[float], other: Fingerprint, *, charge: str = ONE_SIZE, **keys: Any
) -> pd.DataFrame:
    """What to set on the `other` mill to get the collisions of a condition of `one`, nearest first.

    charge: the charge of `condition`, if its balls have several sizes. keys: of `SearchConfig`, what can be set, and
    what is asked for, such as `speeds_rpm=[300, 600]`, `ball_diameters_mm=[8, 10]`, `equal_frequency=True`. A row for
    each local minimum of the distance, the root mean square of log(found / wanted); columns as of `rank_conditions`.
    Raises ConfigError for invalid keys, and for descriptors per collision with different counting rules.
    """
    request = check_model(keys, SearchConfig, "match")
    return rank_conditions(target_at(one, condition, charge, [other], request), [other], request)


def compare(
    one: Fingerprint, condition: Condition[float], other: Fingerprint, other_condition: Condition[float]
) -> pd.DataFrame:
    """The descriptors of one condition on each of two mills, and their ratio other / one, each with its interval.

    A row for each of COMPARED, with title and unit; columns `one`, `other` and `ratio`, each with `_lower` and
    `_upper`, from the bands of a new simulation (`ratio_of`). Descriptors per collision are left out where the two
    count by different rules. Raises ConfigError for intervals of different probabilities.
    """
    chances = one.about["probability"], other.about["probability"]
    if not math.isclose(*chances):
        raise ConfigError(
            f"intervals of {one.about['mill']} are of probability {chances[0]:g}, those of {other.about['mill']} of "
            f"{chances[1]:g}; use one for both"
        )
    of_one, of_other = one.predict(condition), other.predict(other_condition)
    rows = []
    left_out = () if counts_alike(one.about, other.about) else DESCRIPTOR_SETS["per_collision"]
    for name in COMPARED:
        if name in left_out:
            continue
        first, second = getattr(of_one, name), getattr(of_other, name)
        row = {"quantity": name, "title": PREDICTED[name].title, "unit": PREDICTED[name].unit}
        for column, band in {"one": first, "other": second, "ratio": ratio_of(second, first)}.items():
            row |= band.columns(column)
        rows.append(row)
    return pd.DataFrame(rows).set_index("quantity")
