"""Two mills: their descriptors side by side, the conditions of one nearest to the other's, and a match in sentences."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.fingerprint import DescriptorSet, MatchConfig
from millprint.config.load import check_model
from millprint.config.mixture import ONE_SIZE, balls_in_words
from millprint.estimate.estimates import Estimate, ratio_of
from millprint.fingerprint.condition_search import (
    check_same_count,
    counts_alike,
    rank_conditions,
    simulated_ranges,
    with_ratios,
)
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.model import Fingerprint
from millprint.observables.condition import Condition
from millprint.observables.definitions import (
    DESCRIPTOR_SETS,
    DESCRIPTORS,
    POWER,
    POWER_PARTS,
    PREDICTED,
    TARGET_DESCRIPTORS,
)

# What `compare` compares: what mills are matched by, then the power and its parts.
COMPARED = (*(name for names in DESCRIPTOR_SETS.values() for name in names), POWER, *POWER_PARTS)


@dataclass(frozen=True)
class Wanted:
    """What a user can set on a mill; None: everything that was simulated."""

    speeds_rpm: list[float] | None = None
    fill_ratios: list[float] | None = None
    balls: list[float | str] | None = None
    densities_kg_m3: list[float] | None = None
    ranked: int = 10
    descriptors: DescriptorSet = "weighted"

    def request(self, fingerprint: Fingerprint, target: Mapping[str, float]) -> MatchConfig:
        """The request for the conditions nearest to a target's descriptors; raises ConfigError for invalid ones."""
        given = {
            "speeds_rpm": self.speeds_rpm,
            "fill_ratios": self.fill_ratios,
            "ball_diameters_mm": self.balls,
            "densities_kg_m3": self.densities_kg_m3,
        }
        content = simulated_ranges([fingerprint]) | {key: value for key, value in given.items() if value}
        target_of = {"targets": [{"name": "target", **target}], "ranked": self.ranked, "descriptors": self.descriptors}
        return check_model(content | target_of, MatchConfig, "match")


ALL_SIMULATED = Wanted()


def nearest(
    bands: Mapping[str, Estimate], probability: float, fingerprint: Fingerprint, wanted: Wanted
) -> pd.DataFrame:
    """The conditions of a mill nearest to descriptors with their bands, as `rank_conditions`.

    With the ratios of `with_ratios`, if all intervals have the same probability.
    """
    values = {name: band.value for name, band in bands.items()}
    table = rank_conditions(values, [fingerprint], wanted.request(fingerprint, values))
    alike = math.isclose(probability, fingerprint.about["probability"])
    return with_ratios(table, dict(bands)) if alike else table


def match(
    one: Fingerprint,
    condition: Condition[float],
    other: Fingerprint,
    *,
    charge: str = ONE_SIZE,
    speeds_rpm: list[float] | None = None,
    fill_ratios: list[float] | None = None,
    balls: list[float | str] | None = None,
    densities_kg_m3: list[float] | None = None,
    ranked: int = 10,
    descriptors: DescriptorSet = "weighted",
) -> pd.DataFrame:
    """What to set on the `other` mill to get the collisions of a condition of `one`, nearest first.

    speeds_rpm, fill_ratios: from and to; balls: diameters [mm] or names of charges; densities_kg_m3: of the balls. If
    left out, everything that was simulated. charge: the charge of `condition`, if its balls have several sizes.
    descriptors: `weighted`, which need no counting rule, or `per_collision`, as in the thesis.
    A row for each local minimum of the distance, the root mean square of log(found / wanted) over these descriptors;
    columns as of `rank_conditions`, with the ratio of each descriptor to the wanted one and its interval. Raises
    ConfigError for descriptors per collision with different counting rules.
    """
    check_same_count(one.about["mill"], one.about, other, descriptors)
    prediction = one.predict(condition, charge=charge)
    bands = {name: getattr(prediction, name) for name in DESCRIPTOR_SETS[descriptors]}
    wanted = Wanted(speeds_rpm, fill_ratios, balls, densities_kg_m3, ranked, descriptors)
    return nearest(bands, one.about["probability"], other, wanted)


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
