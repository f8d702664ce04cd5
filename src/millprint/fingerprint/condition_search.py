"""Conditions, among those a user can set, whose descriptors come nearest to a target.

What a match is to meet, and the one verdict on it, from the bands of both mills.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from millprint.config.charge import Quantity
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import AskedSet, DescriptorSet, MatchConfig, SearchConfig, TargetConfig
from millprint.estimate.estimates import Estimate, Interval, columns_of, odds_of, ratio_of
from millprint.estimate.judge import NO_INTERVAL, OPEN, Allowed, Verdict, judge, judge_all
from millprint.fingerprint.bands import FURTHER
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.model import LAYERS, NO_IMPACTS, Fingerprint
from millprint.fingerprint.plausible import check_near
from millprint.fingerprint.predicted_values import Prediction
from millprint.observables.condition import Condition
from millprint.observables.definitions import ASKED_DESCRIPTORS, ASKED_SETS, DESCRIPTOR_SETS, POWER, SHARE

# Variables of a condition in sentences and tables.
VARIABLE_WORDS = {
    "fill_ratio": "fill",
    "speed_hz": "speed",
    "ball_diameter_m": "ball size",
    "density_kg_m3": "density",
    "amplitude_m": "amplitude",
}


@dataclass(frozen=True)
class Target:
    """What a match asks for, and what else is known of the condition that it is to be like.

    wanted: descriptors with their intervals; asked: those that are to be met; power_W_kg: power of the walls over the
    mass of the balls, for which milling time makes up; probability: of the intervals; outside: variables of the
    condition that were not simulated; said: what stands with its numbers.
    """

    wanted: Mapping[str, Estimate]
    asked: tuple[str, ...]
    power_W_kg: Estimate = field(default=Estimate(math.nan, "W/kg"))
    probability: float | None = None
    outside: tuple[str, ...] = ()
    said: str = ""

    @classmethod
    def of_numbers(cls, given: Mapping[str, float]) -> "Target":
        """A target of numbers, all of which are asked for."""
        return cls({name: Estimate(value, "-") for name, value in given.items()}, tuple(given))

    @property
    def values(self) -> dict[str, float]:
        """The values that are asked for."""
        return {name: self.wanted[name].value for name in self.asked}

    def ratio(self, name: str, found: Estimate, probability: float) -> Estimate:
        """A descriptor over the wanted one, as `over`; of a share, its odds."""
        one, other = (odds_of(each) if name == SHARE.name else each for each in (found, self.wanted[name]))
        return self.over(one, other, probability)

    def over(self, found: Estimate, wanted: Estimate, probability: float) -> Estimate:
        """found / wanted [-]: of a number, with the intervals of what is found; else of both, as `ratio_of`.

        Intervals of different probabilities make none.
        """
        if self.probability is None:
            return replace(found * (1 / wanted.value), unit="-")
        if not math.isclose(self.probability, probability):
            return Estimate(found.value / wanted.value, "-")
        return ratio_of(found, wanted)


def comparable(name: str, value: Quantity) -> Quantity:
    """What of a descriptor is put over that of the target: of a share its odds, since 0.97 of 0.75 is not near."""
    return value / (1 - value) if name == SHARE.name else value


def power_of_mass(prediction: Prediction, condition: Condition[float]) -> Estimate:
    """Power of the walls over the mass of the balls [W/kg]."""
    ball_kg = condition.density_kg_m3 * math.pi / 6 * condition.ball_diameter_m**3
    return replace(prediction.known[POWER] * (1 / (prediction.balls * ball_kg or math.nan)), unit="W/kg")


def interval_of(ratio: Estimate) -> Interval | None:
    """The interval that decides: of the mean of very many simulations, which is what hours of milling are."""
    return ratio.mean or ratio.scatter


def verdict_on(ratio: Estimate, near_percent: float) -> Verdict:
    """Whether found over wanted is 1 to within `near_percent`: equivalence, not a difference that nobody saw.

    It agrees if the whole interval of the ratio is from 1 / (1 + p) to 1 + p, differs if none of it is, and is open
    otherwise, or if no interval is known.
    """
    if (interval := interval_of(ratio)) is None:
        return Verdict(OPEN, NO_INTERVAL)
    factor = 1 + near_percent / 100
    return judge(replace(ratio, mean=interval), Allowed(1 / factor, factor), by=("mean",))


def variables_in_words(names: tuple[str, ...]) -> str:
    """Variables of a condition: "speed, ball size"."""
    return ", ".join(VARIABLE_WORDS.get(name, name) for name in names)


def verdicts_on(
    ratios: Mapping[str, Estimate], near_percent: float, outside: tuple[str, ...], of_target: tuple[str, ...]
) -> dict[str, Verdict]:
    """`verdict_on` each ratio; open where the condition, or that which it is to be like, was not simulated."""
    for what, names in (("this condition", outside), ("the target", of_target)):
        if names:
            return dict.fromkeys(ratios, Verdict(OPEN, f"{what}: {variables_in_words(names)} not simulated"))
    return {name: verdict_on(ratio, near_percent) for name, ratio in ratios.items()}


# Fill ratios and speeds of the grid before the refinement; the curves have few turns, all far wider than a step.
GRID = (81, 61)
# The distance of what is not known, farther than all others.
UNKNOWN = 1e3
# Sizes that balls are sold in [mm].
SOLD_MM = (0.5, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 15, 20, 25, 30, 40, 50)
# Decimals of the distance to which conditions come equally near.
EQUALLY_NEAR = 2
# What distinguishes two results of the search, and to how many decimals.
PLACE = ["mill", "contact", CHARGE, "ball_diameter_mm", "density_kg_m3"]
DECIMALS = {"fill_ratio": 3, "speed_rpm": 0}


def descriptors_shown(target: Iterable[str]) -> list[str]:
    """The descriptors of every set that a target has one of, and others that it names."""
    named = set(target)
    sets = (names for chosen, names in ASKED_SETS.items() if chosen in DESCRIPTOR_SETS or SHARE.name in named)
    shown = {name for names in sets if named.intersection(names) for name in names}
    return [name for name in ASKED_DESCRIPTORS if name in shown | named]


def distance(found: dict[str, np.ndarray], target: dict[str, float], weights: dict[str, float]) -> np.ndarray:
    """Weighted root mean square of log(found / target) over the descriptors of the target, of odds for a share."""
    total = sum(weights[name] for name in target)
    ratios = {name: comparable(name, found[name]) / comparable(name, target[name]) for name in target}
    return np.sqrt(sum(weights[name] * np.log(ratio) ** 2 for name, ratio in ratios.items()) / total)


def _local_minima(
    fingerprint: Fingerprint, balls: Condition, charge: str, target: dict, weights: dict, fills: tuple, speeds: tuple
) -> Iterator[Condition[float]]:
    """The conditions of `balls` of a charge at every local minimum of the distance, refined from a grid in logs."""
    # Imported here: slow to import, and the fit of the jar imports this module.
    from scipy.optimize import minimize

    ranges = zip((fills, speeds), GRID, strict=True)
    axes = [np.geomspace(low, high, size if high > low else 1) for (low, high), size in ranges]

    def distances(fill: np.ndarray, speed: np.ndarray) -> np.ndarray:
        found = fingerprint.descriptors(replace(balls, fill_ratio=fill, speed_hz=speed), charge)
        return np.nan_to_num(distance(found, target, weights), nan=UNKNOWN)

    def cost(place: np.ndarray) -> float:
        return float(distances(*np.exp(place)[:, None])[0] ** 2)

    fill, speed = np.meshgrid(*axes, indexing="ij")
    grid = distances(fill.ravel(), speed.ravel()).reshape(fill.shape)
    around = sliding_window_view(np.pad(grid, 1, mode="edge"), (3, 3))
    for i, j in np.argwhere((grid < UNKNOWN) & (grid == around.min(axis=(2, 3)))):
        start = np.log([axes[0][i], axes[1][j]])
        # Squared distances are smooth, so their slope is right at a target that can be met.
        found = minimize(
            cost, start, bounds=np.log([fills, speeds]), method="L-BFGS-B", options={"ftol": 1e-14, "gtol": 1e-10}
        )
        fill_ratio, speed_hz = np.exp(found.x if found.fun < grid[i, j] ** 2 else start)
        yield replace(balls, fill_ratio=fill_ratio, speed_hz=speed_hz)


def _row(
    fingerprint: Fingerprint, condition: Condition[float], charge: str, target: Target, request: SearchConfig
) -> dict:
    """One condition: its descriptors and their ratios to the target with intervals, time, and the verdict."""
    prediction = fingerprint.predict(condition, charge=charge)
    bands = {name: getattr(prediction, name) for name in descriptors_shown(target.asked)}
    row = {
        "mill": fingerprint.about["mill"],
        "contact": fingerprint.about["contact"],
        CHARGE: charge,
        "ball_diameter_mm": condition.ball_diameter_m * 1e3,
        "density_kg_m3": condition.density_kg_m3,
        "fill_ratio": condition.fill_ratio,
        "balls": prediction.balls,
        "speed_rpm": condition.speed_hz * 60.0,
        "distance": float(
            distance({name: band.value for name, band in bands.items()}, target.values, request.all_weights)
        ),
    }
    chance = fingerprint.about["probability"]
    ratios = {name: target.ratio(name, bands[name], chance) for name in bands if name in target.wanted}
    for name, band in (bands | {f"{name}_ratio": ratio for name, ratio in ratios.items()}).items():
        row |= band.columns(name)
        for origin in ("mean", *FURTHER):
            if origin in band.intervals:
                row |= band.columns(name, origin)
    # The same dose takes the longer, the weaker the mill.
    time = target.over(target.power_W_kg, power_of_mass(prediction, condition), chance)
    asked = {name: ratios[name] for name in target.asked}
    verdicts = verdicts_on(asked, request.near_percent, prediction.outside, target.outside)
    whole = judge_all(verdicts.values())
    return row | {
        POWER: prediction.known[POWER].value,
        **(time.columns("time_ratio", "mean") if target.probability is not None else {}),
        "verdict": whole.word,
        "reason": whole.reason,
        "met": ", ".join(name for name, verdict in verdicts.items() if verdict.agrees) or "nothing",
        "outside": ", ".join(prediction.outside) or "nothing",
    }


def ranked_columns(target: Target, fingerprints: list[Fingerprint]) -> list[str]:
    """The columns of a ranking for a target, with columns for the origins of intervals that a fingerprint has.

    The charge has a column only if a fingerprint has charges of several sizes.
    """
    shown = descriptors_shown(target.asked)
    numbers = [*shown, *(f"{name}_ratio" for name in shown if name in target.wanted)]
    of_condition = target.probability is not None
    columns = [
        *(*PLACE, "fill_ratio", "balls", "speed_rpm", "distance"),
        *(column for name in numbers for column in (name, *columns_of(name, "scatter"), *columns_of(name, "mean"))),
        *(POWER, *(("time_ratio", *columns_of("time_ratio", "mean")) if of_condition else ())),
        *("verdict", "reason", "met", "outside"),
    ]
    origins = [origin for origin in FURTHER if any(origin in each.further for each in fingerprints)]
    charged = any(each.charges for each in fingerprints)
    return [
        *(name for name in columns if charged or name != CHARGE),
        *(column for origin in origins for name in numbers for column in columns_of(name, origin)),
    ]


def _candidates(fingerprints: list[Fingerprint], request: SearchConfig) -> list[list[tuple[float, str]]]:
    """Diameters [m] and charges of the requested balls that each fingerprint can predict.

    Raises ConfigError for balls that no fingerprint can.
    """
    if request.ball_diameters_mm is None:
        each = ((own, ranges_of(request, own)["ball_diameters_mm"]) for own in fingerprints)
        return [[own.balls(choice) for choice in choices] for own, choices in each]
    found: list[list[tuple[float, str]]] = [[] for _ in fingerprints]
    for choice in request.ball_diameters_mm:
        faults = []
        for own, fingerprint in zip(found, fingerprints, strict=True):
            try:
                own.append(fingerprint.balls(choice))
                check_near(fingerprint.about, ball_diameter_mm=1e3 * own[-1][0])
            except ConfigError as error:
                faults.append(error)
        if len(faults) == len(fingerprints):
            raise faults[0]
    return found


def rank_conditions(
    target: Target | Mapping[str, float], fingerprints: list[Fingerprint], request: SearchConfig
) -> pd.DataFrame:
    """The conditions nearest to `target` that the request allows, nearest first.

    target: what is asked for, or numbers by the names of descriptors. For each fingerprint, ball size and density, a
    row for every fill ratio and speed at a local minimum of the weighted root mean square of log(found / target). Of
    rows that come equally near, within about 1 %, the one comes first that changes the milling time least. NAME_ratio
    is found over wanted, with its bands of both mills, of a new simulation and of the mean; `verdict` is that by the
    latter on all that is asked for (`verdicts_on`), `reason` why, `met` names what agrees. `time_ratio` is the milling
    time over that of the target for the same energy per gram of powder, at one ball-to-powder ratio, P' / P of the
    powers of the walls over the mass of the balls. `outside` names the variables beyond the simulated range. Fill
    ratios outside the simulated ones are left out. Only charges that were simulated are searched. Descriptors have
    columns NAME_by_ORIGIN_lower and _upper for each further origin of intervals that any of the fingerprints has.
    Raises ConfigError for balls that no fingerprint can predict.
    """
    target = target if isinstance(target, Target) else Target.of_numbers(target)
    if request.first and request.first not in target.asked:
        raise ConfigError(f"first = {request.first}: must be one of {', '.join(target.asked)}, which are asked for")
    weights, rows = request.all_weights, []
    for fingerprint in fingerprints:
        fingerprint.check_known(target.asked)
    for fingerprint, media in zip(fingerprints, _candidates(fingerprints, request), strict=True):
        ranges = ranges_of(request, fingerprint)
        fills, speeds = tuple(ranges["fill_ratios"]), tuple(speed / 60.0 for speed in ranges["speeds_rpm"])
        if fills[0] > fills[1]:
            continue
        for speed in ranges["speeds_rpm"]:
            check_near(fingerprint.about, speed_rpm=speed)
        densities = request.densities_kg_m3 or [fingerprint.about["density_kg_m3"]]
        for (diameter, charge), density in itertools.product(media, densities):
            balls = fingerprint.condition(
                speed_hz=speeds[0], ball_diameter_m=diameter, fill_ratio=fills[0], density_kg_m3=density
            )
            for condition in _local_minima(fingerprint, balls, charge, target.values, weights, fills, speeds):
                rows.append(_row(fingerprint, condition, charge, target, request))
    table = pd.DataFrame(rows, columns=ranked_columns(target, fingerprints)).sort_values("distance", ignore_index=True)
    if "time_ratio" in table:
        change = np.abs(np.log(table["time_ratio"].to_numpy(float)))
        table = table.iloc[np.lexsort((change, table["distance"].astype(float).round(EQUALLY_NEAR)))]
    # Two starts of the search can lead to the same condition.
    told = [name for name in (*PLACE, *DECIMALS) if name in table]
    places = table[told].astype(dict.fromkeys(DECIMALS, float)).round(DECIMALS)
    table = table[~places.duplicated()].head(request.ranked).reset_index(drop=True)
    table.insert(0, "rank", np.arange(1, len(table) + 1))
    return table


def check_same_count(what: str, counted: Mapping[str, Any], fingerprint: Fingerprint, names: AskedSet) -> None:
    """Raise ConfigError if a fingerprint counts collisions with other pairs or another gap than `what` does.

    counted: its collisions_by and collision_gap_turns. Energies per collision and frequencies can be compared under
    one rule only; weighted descriptors need none.
    """
    about, words = fingerprint.about, "by {collisions_by} with a gap of {collision_gap_turns:g} turns"
    if names == "per_collision" and not counts_alike(counted, about):
        raise ConfigError(
            f"{what}: collisions are counted {words.format(**counted)}, those of {about['mill']}/{about['contact']} "
            f"{words.format(**about)}; use one rule for both, or descriptors: weighted"
        )


def counts_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two have the same collisions_by and collision_gap_turns."""
    gaps = (each["collision_gap_turns"] for each in (one, other))
    return one["collisions_by"] == other["collisions_by"] and math.isclose(*gaps, rel_tol=1e-6, abs_tol=1e-12)


def target_of(target: TargetConfig, fingerprints: Sequence[Fingerprint], request: SearchConfig) -> Target:
    """What a target asks for: its numbers, or what another mill's fingerprint predicts for its condition.

    Raises ConfigError as `check_same_count`, and for balls or a condition that the fingerprint cannot predict.
    """
    like = target.like
    if like is None:
        return Target.of_numbers(target.given)
    other = Fingerprint.read(like.fingerprint)
    diameter, charge = other.balls(like.ball_diameter_mm)
    condition = other.condition(speed_rpm=like.rpm, ball_diameter_m=diameter, **like.given)
    return target_at(other, condition, charge, fingerprints, request)


def target_at(
    other: Fingerprint,
    condition: Condition[float],
    charge: str,
    fingerprints: Sequence[Fingerprint],
    request: SearchConfig,
) -> Target:
    """What a request asks for, to be like a condition of another mill; raises ConfigError as `check_same_count`."""
    names = ASKED_SETS[request.descriptors]
    for fingerprint in fingerprints:
        check_same_count(other.about["mill"], other.about, fingerprint, request.descriptors)
    other.check_known(request.asked)
    found = other.predict(condition, charge=charge)
    if LAYERS in found.outside:
        raise ConfigError(f"{other.about['mill']}: {NO_IMPACTS}; nothing can be matched to it")
    wanted = {name: getattr(found, name) for name in names}
    power, probability = power_of_mass(found, condition), other.about["probability"]
    return Target(wanted, request.asked, power, probability, found.outside, other.few_turns_in_words())


def match_targets(request: MatchConfig, fingerprints: list[Fingerprint]) -> pd.DataFrame:
    """The nearest conditions for every target: `rank_conditions` with a column `target`."""
    tables = []
    for target in request.targets:
        table = rank_conditions(target_of(target, fingerprints, request), fingerprints, request)
        table.insert(0, "target", target.name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def ranges_of(request: SearchConfig, fingerprint: Fingerprint) -> dict[str, list]:
    """What is searched on a mill: speeds_rpm, fill_ratios and ball_diameters_mm, as requested, or as simulated.

    Fill ratios that were not simulated are left out, so that the range may be empty.
    """
    low, high = fingerprint.fill_range
    fills = request.fill_ratios or [low, high]
    speeds = [60 * speed for speed in fingerprint.about["ranges"]["speed_hz"]]
    simulated = fingerprint.choices()
    sizes = sorted({*_sizes_between(fingerprint), *(size for size in simulated if not isinstance(size, str))})
    return {
        "speeds_rpm": request.speeds_rpm or speeds,
        "fill_ratios": [max(low, fills[0]), min(high, fills[1])],
        "ball_diameters_mm": request.ball_diameters_mm
        or [*sizes, *(choice for choice in simulated if isinstance(choice, str))],
    }


def _sizes_between(fingerprint: Fingerprint) -> list[float]:
    """Sizes that balls are sold in, between the smallest and the largest simulated ones of one size [mm]."""
    sizes = [choice for choice in fingerprint.choices() if not isinstance(choice, str)]
    return [size for size in SOLD_MM if sizes and min(sizes) < size < max(sizes)]


def simulated_request(fingerprint: Fingerprint, names: DescriptorSet) -> MatchConfig:
    """A request for everything that was simulated for a fingerprint.

    The target has a set of descriptors of one condition: middle fill ratio, slowest speed and first balls, or what was
    simulated with impacts next to it.
    """
    low, high = fingerprint.fill_range
    diameter, charge = fingerprint.balls(fingerprint.choices()[0])
    slowest = fingerprint.about["ranges"]["speed_hz"][0]
    middle = fingerprint.condition(speed_hz=slowest, ball_diameter_m=diameter, fill_ratio=(low * high) ** 0.5)
    if fingerprint.near_layers(middle, charge).any():
        middle = fingerprint.nearest_with_impacts(middle, charge)
    found = fingerprint.predict(middle, charge=charge)
    target = TargetConfig(name="middle", **{name: getattr(found, name).value for name in DESCRIPTOR_SETS[names]})
    return MatchConfig(targets=[target], descriptors=names, **ranges_of(SearchConfig(), fingerprint))
