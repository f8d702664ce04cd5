"""The descriptors of one condition: their bands, and intervals by contact parameters and by the shape of the jar."""

import math

import pandas as pd

from millprint.card.card_inputs import CardSettings, Runs
from millprint.card.card_model import Descriptors, Ends, Quantity
from millprint.card.scatter import read_window, spread
from millprint.fingerprint.bands import FURTHER, factor_of
from millprint.fingerprint.condition import SCALED_BY
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.seeds import MOTIONS

SHARE = "tangential_share"
# A descriptor without a curve, and so without factors.
BALL_COLLISIONS = "collisions_of_a_ball_hz"
# The curve of a fingerprint whose factors apply to a descriptor; the share rises with the ratio Pt / Pn.
CURVE_OF = {
    **SCALED_BY,
    "normal_power_W": "Pn",
    "tangential_power_W": "Pt",
    "power_W": "P",
}
COLUMN_UNITS = {"J": "J", "W": "W", "hz": "1/s"}
UNITS = {name: COLUMN_UNITS[name.rpartition("_")[2]] for name in (*CURVE_OF, BALL_COLLISIONS)} | {SHARE: "-"}


def describe_runs(
    runs: Runs, settings: CardSettings, fingerprint: Fingerprint | None
) -> tuple[Descriptors, dict[str, str], list[str]]:
    """The descriptors with their intervals, why an interval is not known, and why the bands may be wrong."""
    rule = settings.counting_rule
    each = [_values(tabulate_descriptors([summary], rule)) for summary in runs.summaries]
    table = tabulate_descriptors(runs.summaries, rule)
    value = _values(table)
    windows = [read_window(*run, rule) for run in zip(runs.summaries, runs.paths, strict=True)]
    widths = spread(windows, each, settings.interval)
    missing = {} if widths else dict.fromkeys(("scatter", "mean"), "one simulation of fewer than two turns")
    fill = float(table["fill_ratio"].iloc[0])
    factors = {}
    for origin in FURTHER:
        if fingerprint is None:
            missing[origin] = "not analysed"
        elif reason := fingerprint.missing(fill).get(origin):
            missing[origin] = reason
        else:
            factors[origin] = fingerprint.further[origin].at(table["fill_ratio"].to_numpy())
    found = {}
    for name, own in value.items():
        further = {}
        for origin, ends in factors.items():
            if name == BALL_COLLISIONS:
                continue
            if name in CURVE_OF:
                low, high = own * ends[CURVE_OF[name]][:, 0]
            else:
                low, high = (1 / (1 + (1 / own - 1) / end) for end in ends["ratio"][:, 0])
            if math.isfinite(low):
                further[origin] = Ends(lower=float(low), upper=float(high))
        halves = widths.get(name)
        scatter, mean = [_around(own, half, name) for half in halves] if halves else (None, None)
        found[name] = Quantity(value=own, unit=UNITS[name], scatter=scatter, mean=mean, **further)
    words = table["motion"].iloc[0].split(", ")
    against = [f"{motion.word}: {motion.meaning}" for motion in MOTIONS.values() if motion.word in words]
    return Descriptors(**found), missing, against


def _around(value: float, half: float, name: str) -> Ends | None:
    """Ends from half the width of the interval of the logarithm; a share is at most 1. None if they are not known."""
    factor = float(factor_of(half))
    if math.isnan(factor):
        return None
    return Ends(lower=value / factor, upper=min(value * factor, 1.0) if name == SHARE else value * factor)


def _values(table: pd.DataFrame) -> dict[str, float]:
    """The descriptors of the one condition of a table."""
    row = table.iloc[0]
    power = row["normal_power_W"] + row["tangential_power_W"]
    own = {"power_W": power, SHARE: row["tangential_power_W"] / power}
    return {name: float(own.get(name, row.get(name))) for name in UNITS}
