"""A match of two mills in sentences: whether it is met, what is missed, and which limit stands in the way."""

import math
from collections.abc import Sequence

import pandas as pd

from millprint.config.fingerprint import TARGET_DESCRIPTORS, MatchConfig
from millprint.config.mixture import ONE_SIZE, balls_in_words
from millprint.fingerprint.columns import DESCRIPTORS
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.model import Fingerprint

# A setting is at a limit if it is as near as this, as a fraction of it.
AT_LIMIT = 2e-3


def setting_in_words(row: pd.Series) -> str:
    """A setting: "balls of 10 mm, fill 0.12, 420 rpm"."""
    balls = balls_in_words(row["ball_diameter_mm"], row.get(CHARGE, ONE_SIZE))
    return f"balls of {balls}, fill {row['fill_ratio']:.3g}, {row['speed_rpm']:.0f} rpm"


def lost_in_words(row: pd.Series) -> str:
    """How a setting differs from the target: each descriptor in per cent, with the factors that intervals allow."""
    parts = []
    for name in TARGET_DESCRIPTORS:
        if f"{name}_residual_percent" not in row or math.isnan(row[f"{name}_residual_percent"]):
            continue
        text = f"{DESCRIPTORS[name].title} {row[f'{name}_residual_percent']:+.0f} %"
        if f"{name}_ratio_lower" in row:
            text += f" (ratio {row[f'{name}_ratio_lower']:.2f} to {row[f'{name}_ratio_upper']:.2f})"
        parts.append(text)
    return ", ".join(parts)


def limits_in_words(
    row: pd.Series, speeds_rpm: Sequence[float], fill_ratios: Sequence[float], balls_mm: Sequence[float]
) -> str:
    """The limits of the ranges at which the nearest setting is, so that a wider range may come nearer."""
    ranges = {
        "speed": (row["speed_rpm"], speeds_rpm, "{:.0f} rpm"),
        "fill ratio": (row["fill_ratio"], fill_ratios, "{:.3g}"),
        "ball size": (row["ball_diameter_mm"], balls_mm, "{:g} mm"),
    }
    found = [
        f"the {word} {name}, {shown.format(end)}"
        for name, (value, ends, shown) in ranges.items()
        for word, end in (("lowest", min(ends)), ("highest", max(ends)))
        if min(ends) < max(ends) and math.isclose(value, end, rel_tol=AT_LIMIT)
    ]
    if not found:
        return "no limit of the ranges stands in the way: this mill does not give these values together"
    return (
        f"{' and '.join(found)}, {'stands' if len(found) == 1 else 'stand'} in the way: a wider range may come nearer"
    )


def match_in_words(rows: pd.DataFrame, request: MatchConfig, fingerprints: Sequence[Fingerprint]) -> str:
    """The first sentence on the rows of one target, nearest first."""
    if rows.empty:
        return "no setting: none of the requested fill ratios was simulated"
    best = rows.iloc[0]
    mill = best["mill"]
    compared = [name for name in TARGET_DESCRIPTORS if not math.isnan(best.get(f"{name}_residual_percent", math.nan))]
    outside = f" (outside the simulations: {best['outside']})" if best["inside"] == "no" else ""
    if set(compared) <= set(best["within_interval"].split(", ")):
        return f"met within the scatter of a simulation on {mill}: {setting_in_words(best)}{outside}"
    own = next(each for each in fingerprints if each.about["mill"] == mill and each.about["contact"] == best["contact"])
    # Fill ratios that were not simulated are not searched.
    fills = [max(request.fill_ratios[0], own.fill_range[0]), min(request.fill_ratios[1], own.fill_range[1])]
    balls = [1e3 * own.balls(choice)[0] for choice in request.ball_diameters_mm]
    return (
        f"no setting of {mill} is within the scatter of a simulation; the nearest ({setting_in_words(best)}{outside}): "
        f"{lost_in_words(best)}; {limits_in_words(best, request.speeds_rpm, fills, balls)}"
    )
