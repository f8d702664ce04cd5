"""Two mills: their descriptors side by side, and the conditions of one that come nearest to the other's."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.fingerprint import DESCRIPTOR_SETS, TARGET_DESCRIPTORS, DescriptorSet, MatchConfig
from millprint.config.load import check_model
from millprint.config.mixture import ONE_SIZE
from millprint.fingerprint.bands import ENDS, Band, ratio_of
from millprint.fingerprint.columns import DESCRIPTORS
from millprint.fingerprint.condition import Condition
from millprint.fingerprint.condition_search import check_same_count, counts_alike, rank_conditions, with_ratios
from millprint.fingerprint.model import Fingerprint

# What `compare` compares, with the titles of quantities that are not columns of a table of descriptors.
TITLES = {
    **{name: DESCRIPTORS[name].title for name in TARGET_DESCRIPTORS},
    "normal_power_W": DESCRIPTORS["normal_power_W"].title,
    "tangential_power_W": DESCRIPTORS["tangential_power_W"].title,
    "power_W": "power of all balls",
}


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
        ranges = fingerprint.about["ranges"]
        content = {
            "targets": [{"name": "target", **target}],
            "speeds_rpm": self.speeds_rpm or [60 * speed for speed in ranges["speed_hz"]],
            "fill_ratios": self.fill_ratios or ranges["fill_ratio"],
            "ball_diameters_mm": self.balls or fingerprint.choices(),
            "densities_kg_m3": self.densities_kg_m3 or [],
            "ranked": self.ranked,
            "descriptors": self.descriptors,
        }
        return check_model(content, MatchConfig, "match")


ALL_SIMULATED = Wanted()


def nearest(bands: Mapping[str, Band], probability: float, fingerprint: Fingerprint, wanted: Wanted) -> pd.DataFrame:
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

    A row for each quantity of TITLES, with title and unit; columns `one`, `other` and `ratio`, each with `_lower` and
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
    for name, title in TITLES.items():
        if name in left_out:
            continue
        first, second = getattr(of_one, name), getattr(of_other, name)
        row = {"quantity": name, "title": title, "unit": DESCRIPTORS[name].unit if name in DESCRIPTORS else "W"}
        for column, band in {"one": first, "other": second, "ratio": ratio_of(second, first)}.items():
            row |= {column: band.value, **{f"{column}_{end}": getattr(band, end) for end in ENDS}}
        rows.append(row)
    return pd.DataFrame(rows).set_index("quantity")
