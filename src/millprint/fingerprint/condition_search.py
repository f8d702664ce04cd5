"""Conditions, among those a user can set, whose descriptors come nearest to a target."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.fingerprint import DescriptorSet, LikeConfig, MatchConfig, TargetConfig
from millprint.estimate.estimates import Estimate, Interval, columns_of, ratio_of
from millprint.estimate.judge import judge
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.plausible import check_near
from millprint.fingerprint.predicted_values import Prediction
from millprint.observables.condition import Condition
from millprint.observables.definitions import DESCRIPTOR_SETS, POWER, PREDICTED, TARGET_DESCRIPTORS

# Fill ratios and speeds of the grid before the refinement; the curves have few turns, all far wider than a step.
GRID = (81, 61)
# What distinguishes two results of the search, and to how many decimals.
PLACE = ["mill", "contact", CHARGE, "ball_diameter_mm", "density_kg_m3"]
DECIMALS = {"fill_ratio": 3, "speed_rpm": 0}
# What the intervals by contact parameters do not include in a match.
SHARED_CONTACT = (
    "both mills have the contact set {contact}, whose unknown parameters act in both: a part of what they change "
    "cancels between the mills, so the match is surer than the intervals by contact parameters; the intervals of "
    "ratios take the two as independent, and so are rather too wide"
)


def descriptors_shown(target: Iterable[str]) -> list[str]:
    """The descriptors of every set that a target has one of, and others that it names."""
    named = set(target)
    shown = {name for names in DESCRIPTOR_SETS.values() if named.intersection(names) for name in names}
    return [name for name in TARGET_DESCRIPTORS if name in shown | named]


def residuals(found: dict[str, float], target: dict[str, float]) -> dict[str, float]:
    """Relative deviation of each shown descriptor from its target [%]; NaN for one that the target does not have."""
    return {
        f"{name}_residual_percent": 100.0 * (found[name] / target[name] - 1.0) if name in target else np.nan
        for name in descriptors_shown(target)
    }


def distance(found: dict[str, np.ndarray], target: dict[str, float], weights: dict[str, float]) -> np.ndarray:
    """Weighted root mean square of log(found / target) over the descriptors of the target."""
    total = sum(weights[name] for name in target)
    return np.sqrt(sum(weights[name] * np.log(found[name] / target[name]) ** 2 for name in target) / total)


def _local_minima(
    fingerprint: Fingerprint, balls: Condition, charge: str, target: dict, weights: dict, fills: tuple, speeds: tuple
) -> Iterator[Condition[float]]:
    """The conditions of `balls` of a charge at every local minimum of the distance, refined from a grid in logs."""
    # Imported here: slow to import, and the fit of the jar imports this module.
    from scipy.ndimage import minimum_filter
    from scipy.optimize import minimize

    ranges = zip((fills, speeds), GRID, strict=True)
    axes = [np.geomspace(low, high, size if high > low else 1) for (low, high), size in ranges]

    def distances(fill: np.ndarray, speed: np.ndarray) -> np.ndarray:
        found = fingerprint.descriptors(replace(balls, fill_ratio=fill, speed_hz=speed), charge)
        return distance(found, target, weights)

    def cost(place: np.ndarray) -> float:
        return float(distances(*np.exp(place)[:, None])[0] ** 2)

    fill, speed = np.meshgrid(*axes, indexing="ij")
    grid = distances(fill.ravel(), speed.ravel()).reshape(fill.shape)
    for i, j in np.argwhere(grid == minimum_filter(grid, size=3, mode="nearest")):
        start = np.log([axes[0][i], axes[1][j]])
        # Squared distances are smooth, so their slope is right at a target that can be met.
        found = minimize(
            cost, start, bounds=np.log([fills, speeds]), method="L-BFGS-B", options={"ftol": 1e-14, "gtol": 1e-10}
        )
        fill_ratio, speed_hz = np.exp(found.x if found.fun < grid[i, j] ** 2 else start)
        yield replace(balls, fill_ratio=fill_ratio, speed_hz=speed_hz)


def meets(found: Estimate, wanted: float) -> bool:
    """Whether a wanted value lies within the band of a new simulation."""
    return judge(found, Estimate(wanted, found.unit), by=("scatter",)).agrees


def _row(fingerprint: Fingerprint, condition: Condition[float], charge: str, target: dict, weights: dict) -> dict:
    """One condition with its descriptors, their intervals and residuals, and whether it was simulated."""
    prediction = fingerprint.predict(condition, charge=charge)
    bands = {name: getattr(prediction, name) for name in descriptors_shown(target)}
    found = {name: band.value for name, band in bands.items()}
    row = {
        "mill": fingerprint.about["mill"],
        "contact": fingerprint.about["contact"],
        CHARGE: charge,
        "ball_diameter_mm": condition.ball_diameter_m * 1e3,
        "density_kg_m3": condition.density_kg_m3,
        "fill_ratio": condition.fill_ratio,
        "balls": prediction.balls,
        "speed_rpm": condition.speed_hz * 60.0,
        "distance": float(distance(found, target, weights)),
    }
    for name, band in bands.items():
        row |= band.columns(name)
        for origin in fingerprint.further:
            row |= band.columns(name, origin)
    held = [name for name in target if meets(bands[name], target[name])]
    return row | {
        **residuals(found, target),
        POWER: prediction.known[POWER].value,
        "within_interval": ", ".join(held) or "nothing",
        "inside": "no" if prediction.outside else "yes",
        "outside": ", ".join(prediction.outside) or "nothing",
    }


def ranked_columns(target: Iterable[str], fingerprints: list[Fingerprint]) -> list[str]:
    """The columns of a ranking for a target, with columns for the origins of intervals that a fingerprint has.

    The charge has a column only if a fingerprint has charges of several sizes.
    """
    shown = descriptors_shown(target)
    columns = [
        *(*PLACE, "fill_ratio", "balls", "speed_rpm", "distance"),
        *(f"{name}{end}" for name in shown for end in ("", "_lower", "_upper")),
        *(f"{name}_residual_percent" for name in shown),
        *(POWER, "within_interval", "inside", "outside"),
    ]
    origins = [origin for origin in FURTHER if any(origin in each.further for each in fingerprints)]
    charged = any(each.charges for each in fingerprints)
    return [
        *(name for name in columns if charged or name != CHARGE),
        *(column for origin in origins for name in shown for column in columns_of(name, origin)),
    ]


def _candidates(fingerprints: list[Fingerprint], choices: list[float | str]) -> list[list[tuple[float, str]]]:
    """Diameters [m] and charges of the requested balls that each fingerprint can predict.

    Raises ConfigError for balls that no fingerprint can.
    """
    found: list[list[tuple[float, str]]] = [[] for _ in fingerprints]
    for choice in choices:
        faults = []
        for own, fingerprint in zip(found, fingerprints, strict=True):
            try:
                own.append(fingerprint.balls(choice))
                check_near(fingerprint, ball_diameter_mm=1e3 * own[-1][0])
            except ConfigError as error:
                faults.append(error)
        if len(faults) == len(fingerprints):
            raise faults[0]
    return found


def rank_conditions(target: dict[str, float], fingerprints: list[Fingerprint], request: MatchConfig) -> pd.DataFrame:
    """The conditions nearest to `target` that the request allows, nearest first, with the residual of each descriptor.

    target: some or all of a set of descriptors. For each fingerprint, ball size and density, a row for every fill ratio
    and speed at a local minimum of the weighted root mean square of log(found / target). `within_interval` names the
    descriptors whose target is in the condition's band of a new simulation; `outside` names the variables beyond the
    simulated range. Fill ratios outside the simulated ones are left out. Only charges that were simulated are searched.
    Descriptors have columns NAME_by_ORIGIN_lower and _upper for each further origin of intervals that any of the
    fingerprints has. Raises ConfigError for balls that no fingerprint can predict.
    """
    weights, speeds = request.all_weights, tuple(speed / 60.0 for speed in request.speeds_rpm)
    rows = []
    for fingerprint in fingerprints:
        fingerprint.check_known(target)
    candidates = _candidates(fingerprints, request.ball_diameters_mm)
    for fingerprint, media in zip(fingerprints, candidates, strict=True):
        (lowest, highest), (simulated_low, simulated_high) = request.fill_ratios, fingerprint.fill_range
        fills = max(lowest, simulated_low), min(highest, simulated_high)
        if fills[0] > fills[1]:
            continue
        for speed in request.speeds_rpm:
            check_near(fingerprint, speed_rpm=speed)
        densities = request.densities_kg_m3 or [fingerprint.about["density_kg_m3"]]
        for (diameter, charge), density in itertools.product(media, densities):
            balls = fingerprint.condition(
                speed_hz=speeds[0], ball_diameter_m=diameter, fill_ratio=fills[0], density_kg_m3=density
            )
            for condition in _local_minima(fingerprint, balls, charge, target, weights, fills, speeds):
                rows.append(_row(fingerprint, condition, charge, target, weights))
    table = pd.DataFrame(rows, columns=ranked_columns(target, fingerprints)).sort_values("distance", ignore_index=True)
    # Two starts of the search can lead to the same condition.
    told = [name for name in (*PLACE, *DECIMALS) if name in table]
    places = table[told].astype(dict.fromkeys(DECIMALS, float)).round(DECIMALS)
    table = table[~places.duplicated()].head(request.ranked).reset_index(drop=True)
    table.insert(0, "rank", np.arange(1, len(table) + 1))
    return table


def check_same_count(what: str, counted: Mapping[str, Any], fingerprint: Fingerprint, names: DescriptorSet) -> None:
    """Raise ConfigError if a fingerprint counts collisions with other pairs or another gap than `what` does.

    counted: its collisions_by and collision_gap_turns. Energies per collision and frequencies can be compared under
    one rule only; weighted descriptors need none.
    """
    about, words = fingerprint.about, "by {collisions_by} with a gap of {collision_gap_turns:g} turns"
    if names != "weighted" and not counts_alike(counted, about):
        raise ConfigError(
            f"{what}: collisions are counted {words.format(**counted)}, those of {about['mill']}/{about['contact']} "
            f"{words.format(**about)}; use one rule for both, or descriptors: weighted"
        )


def counts_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two have the same collisions_by and collision_gap_turns."""
    gaps = (each["collision_gap_turns"] for each in (one, other))
    return one["collisions_by"] == other["collisions_by"] and math.isclose(*gaps, rel_tol=1e-6, abs_tol=1e-12)


def _of_another_mill(
    like: LikeConfig, fingerprints: list[Fingerprint], names: DescriptorSet
) -> tuple[dict[str, Estimate], float]:
    """The descriptors of a condition of another mill with their intervals, and the probability of the intervals.

    Raises ConfigError as `check_same_count`, and for balls that the fingerprint cannot predict.
    """
    other = Fingerprint.read(like.fingerprint)
    for fingerprint in fingerprints:
        check_same_count(like.fingerprint, other.about, fingerprint, names)
    other.check_known(DESCRIPTOR_SETS[names])
    prediction = _predicted(like, other)
    return {name: getattr(prediction, name) for name in DESCRIPTOR_SETS[names]}, other.about["probability"]


def _predicted(like: LikeConfig, other: Fingerprint) -> Prediction:
    """What the fingerprint of another mill predicts for a condition of it."""
    diameter, charge = other.balls(like.ball_diameter_mm)
    check_near(other, speed_rpm=like.speed_rpm, ball_diameter_mm=1e3 * diameter)
    condition = other.condition(speed_hz=like.speed_rpm / 60.0, ball_diameter_m=diameter, **like.given)
    return other.predict(condition, charge=charge)


def extrapolated_targets(request: MatchConfig) -> list[str]:
    """A line for each condition of another mill that lies outside its simulations."""
    lines = []
    for target in request.targets:
        if target.like is None:
            continue
        other = Fingerprint.read(target.like.fingerprint)
        if outside := _predicted(target.like, other).outside:
            lines.append(
                f"{target.name}: the target itself is extrapolated: {', '.join(outside)} not simulated of "
                f"{other.about['mill']}"
            )
    return lines


def target_descriptors(target: TargetConfig, fingerprints: list[Fingerprint], names: DescriptorSet) -> dict[str, float]:
    """The descriptors of a target by name: as given, or a set predicted by another mill's fingerprint.

    Raises ConfigError if a condition of another mill cannot be compared or is not known.
    """
    if target.like is None:
        return target.given
    return {name: band.value for name, band in _of_another_mill(target.like, fingerprints, names)[0].items()}


def with_ratios(table: pd.DataFrame, target: dict[str, Estimate]) -> pd.DataFrame:
    """A ranking with columns NAME_ratio of the found descriptors over the target's, and their intervals.

    Intervals by the scatter, and by each further origin that both have (`ratio_of`); empty where one lacks it.
    """
    columns: dict[str, list[float]] = {}
    for name, of_target in target.items():
        ratios = [ratio_of(_stored(row, name), of_target) for row in table.to_dict("records")]
        columns[f"{name}_ratio"] = [each.value for each in ratios]
        for origin in ("scatter", *FURTHER):
            if origin == "scatter" or any(origin in each.intervals for each in ratios):
                for place, column in enumerate(columns_of(f"{name}_ratio", origin)):
                    columns[column] = [each.ends(origin)[place] for each in ratios]
    return table.assign(**columns)


def _stored(row: dict, name: str) -> Estimate:
    """A descriptor with its intervals in a row of a ranking."""
    ends = {own: [row.get(column, np.nan) for column in columns_of(name, own)] for own in ("scatter", *FURTHER)}
    known = {own: Interval(*each) for own, each in ends.items() if np.isfinite(each).all()}
    return Estimate(row[name], PREDICTED[name].unit).having(known)


def match_targets(request: MatchConfig, fingerprints: list[Fingerprint]) -> pd.DataFrame:
    """The nearest conditions for every target: `rank_conditions` with a column `target`.

    A target that is a condition of another mill also has the ratios to it with their intervals, if all intervals have
    the same probability.
    """
    tables = []
    for target in request.targets:
        like, names = target.like, request.descriptors
        bands, probability = _of_another_mill(like, fingerprints, names) if like else ({}, None)
        values = {name: band.value for name, band in bands.items()} or target.given
        table = rank_conditions(values, fingerprints, request)
        table.insert(0, "target", target.name)
        alike = all(each.about["probability"] == probability for each in fingerprints)
        tables.append(with_ratios(table, bands) if alike else table)
    return pd.concat(tables, ignore_index=True)


def simulated_ranges(fingerprints: Sequence[Fingerprint]) -> dict[str, list]:
    """The keys of a request for everything that was simulated for some mills: ranges of speed and fill, all balls."""
    speeds = [60 * speed for each in fingerprints for speed in each.about["ranges"]["speed_hz"]]
    fills = [fill for each in fingerprints for fill in each.fill_range]
    balls = dict.fromkeys(choice for each in fingerprints for choice in each.choices())
    ranges = {"speeds_rpm": [min(speeds), max(speeds)], "fill_ratios": [min(fills), max(fills)]}
    return {**ranges, "ball_diameters_mm": list(balls)}


def simulated_request(fingerprint: Fingerprint, names: DescriptorSet) -> MatchConfig:
    """A request for everything that was simulated for a fingerprint.

    The target has a set of descriptors of one condition: middle fill ratio, slowest speed and first balls.
    """
    low, high = fingerprint.fill_range
    diameter, charge = fingerprint.balls(fingerprint.choices()[0])
    slowest = fingerprint.about["ranges"]["speed_hz"][0]
    middle = fingerprint.condition(speed_hz=slowest, ball_diameter_m=diameter, fill_ratio=(low * high) ** 0.5)
    found = fingerprint.predict(middle, charge=charge)
    target = TargetConfig(name="middle", **{name: getattr(found, name).value for name in DESCRIPTOR_SETS[names]})
    return MatchConfig(targets=[target], descriptors=names, **simulated_ranges([fingerprint]))


def shared_contact(request: MatchConfig, fingerprints: list[Fingerprint]) -> list[str]:
    """SHARED_CONTACT, for each contact set that a mill of a target and a fingerprint with such intervals both have."""
    known = {each.about["contact"] for each in fingerprints if "contact" in each.further}
    likes = [target.like for target in request.targets if target.like]
    asked = {Fingerprint.read(like.fingerprint).about["contact"] for like in likes} if known else set()
    return [SHARED_CONTACT.format(contact=contact) for contact in sorted(known & asked)]
