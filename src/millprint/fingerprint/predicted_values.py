"""What a fingerprint predicts for a condition: its quantities with their bands."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.estimate.estimates import Estimate, Interval, columns_of, known_ends
from millprint.fingerprint.condition import CURVES, WEIGHTED_BASIC, scaled_quantities
from millprint.fingerprint.processes import Told

# The quantities that are read from curves, from which all others are calculated. Power and its parts are the power and
# the ratio of these parts, so that the parts add up to the whole, and their bands do not exceed it.
KNOWN = ("P", "ratio", "f", *WEIGHTED_BASIC)


@dataclass(frozen=True)
class Prediction:
    """Descriptors of one condition, each with its bands; `outside` names the variables outside the simulated range.

    missing: why an interval of a further origin (contact parameters, shape of the jar) is None, by origin.
    """

    balls: int
    weighted_normal_energy_J: Estimate
    weighted_tangential_energy_J: Estimate
    weighted_normal_frequency_hz: Estimate
    weighted_tangential_frequency_hz: Estimate
    strong_frequency_hz: Estimate
    normal_energy_J: Estimate
    tangential_energy_J: Estimate
    specific_frequency_hz: Estimate
    normal_power_W: Estimate
    tangential_power_W: Estimate
    power_W: Estimate
    tangential_share: Estimate
    outside: tuple[str, ...]
    missing: Mapping[str, str]


def bands(table: pd.DataFrame) -> dict[str, Estimate]:
    """The quantities of the first row of a table of `banded`, each with its two bands."""
    row = {name: float(value) for name, value in table.iloc[0].items()}
    found = {}
    for name in CURVES:
        ends = {own: Interval(*(row[column] for column in columns_of(name, own))) for own in ("scatter", "mean")}
        known = {own: each for own, each in ends.items() if not np.isnan(each.lower + each.upper)}
        found[name] = Estimate(row[name], "-").having(known)
    return found


def from_curves(read: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Every scaled quantity [-] from those of KNOWN that have a curve; NaN for what needs one that is missing.

    Pn = P / (1 + ratio), Pt = P - Pn. Without a ratio, Pn is read from a curve of its own.
    """
    missing = np.full_like(read["P"], np.nan)
    normal = read["P"] / (1 + read["ratio"]) if "ratio" in read else read.get("Pn", missing)
    basic = {name: read.get(name, missing) for name in ("f", *WEIGHTED_BASIC)}
    found = scaled_quantities({**basic, "Pn": normal, "Pt": read["P"] - normal if "ratio" in read else missing})
    return {**found, "P": read["P"]}


def _of_part(share: np.ndarray, ends: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Logarithms (2, m) of the ends of a part's band over its value: below and above.

    share: of the part in the whole (m,); ends: of this share (2, m); whole: half the width of the band of the whole
    (m,). The distances of two independent factors add up in squares, so that no end of a part is beyond the whole.
    """
    return np.array([-1, 1])[:, None] * np.hypot(whole, np.log(ends / share))


def banded(told: Mapping[str, Told], width: float) -> pd.DataFrame:
    """For each quantity: Q, Q_lower and Q_upper of a new simulation, and Q_mean_lower and Q_mean_upper of the mean.

    Ends that are not known are NaN.
    told: logarithms and deviations (m,) of each quantity that has a curve; width: of the bands, in deviations.
    """
    values = from_curves({name: np.exp(own.logs) for name, own in told.items()})
    table: dict[str, np.ndarray] = {}
    for name in CURVES:
        table[name] = values[name]
        for columns, part in ((columns_of(name, "scatter"), "of_new"), (columns_of(name, "mean"), "of_mean")):
            halves = {own: width * getattr(told[own], part) for own in ("P", "ratio", name) if own in told}
            if name in PARTS and "ratio" in told:
                ratios = values["ratio"] * np.exp(np.outer([1, -1] if name == "Pn" else [-1, 1], halves["ratio"]))
                shares = PARTS[name](np.vstack([ratios, values["ratio"]]))
                logs = _of_part(shares[2], shares[:2], halves["P"])
            else:
                logs = np.outer([-1, 1], halves.get(name, np.full_like(values[name], np.nan)))
            table |= dict(zip(columns, values[name] * np.exp(known_ends(logs)), strict=True))
    return pd.DataFrame(table)


# Parts of the power -> their share in it, by the ratio of tangential to normal.
PARTS = {"Pn": lambda ratio: 1 / (1 + ratio), "Pt": lambda ratio: ratio / (1 + ratio)}
