"""What the atlas tells about a mill of one's own: observables with intervals, exponents, and refusals."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from millprint.atlas.atlas_model import HITS, MARKS, NORMAL, PREDICTED, KindModel, combined, inputs_of, read_model
from millprint.atlas.kind_groups import BEYOND, MOST_BALLS, PACKED, SETTINGS, Kind, Values, within_limits
from millprint.config.errors import ConfigError
from millprint.config.load import shipped
from millprint.estimate.estimates import Estimate, Interval

MODEL = "config/atlas/model.json"
SIMULATE = "simulate it: `millprint card` for one condition, `millprint fingerprint` for the mill"
# The group that changes no power: beyond its range the end is taken, and a note says so.
STIFFNESS = "softness"
# Change of a dimension over which an exponent is taken, as a logarithm.
STEP = 0.1


@dataclass(frozen=True)
class MillEstimate:
    """What the atlas tells about a condition.

    groups: by name; hits: probability that balls hit something; known: of PREDICTED, each with the 90 % interval of one
    simulation as `scatter`; notes: lines on what was taken for something else; unsure: those of `MARKS` that are to be
    simulated here, since more than the mark is to be expected.
    """

    kind: Kind
    condition: Mapping[str, float]
    groups: Mapping[str, float]
    hits: float
    known: Mapping[str, Estimate]
    notes: tuple[str, ...] = ()
    unsure: tuple[str, ...] = ()

    @property
    def charge_kg(self) -> float:
        """Mass of all balls [kg]."""
        diameter_m = self.condition["ball_diameter_mm"] / 1e3
        return self.condition["number"] * self.condition["density_kg_m3"] * math.pi / 6 * diameter_m**3


@cache
def included_models() -> dict[str, KindModel]:
    """The models that come with the library. Raises ConfigError where there are none."""
    place = shipped(MODEL)
    if place is None:
        raise ConfigError(f"{MODEL}: no such file: this installation has no atlas; {SIMULATE}")
    return read_model(place)


def model_of(kind: Kind) -> KindModel:
    """The included model of a kind. Raises ConfigError, in one line, for a kind that was not simulated yet."""
    models = included_models()
    if kind.name not in models:
        raise ConfigError(f"{kind.name}: the atlas does not have this kind yet, only {', '.join(models)}; {SIMULATE}")
    return models[kind.name]


def check(kind: Kind, condition: Values) -> dict[str, float]:
    """The groups of a condition. Raises ConfigError, in one line, for one that cannot be, or that the atlas does not
    know: a group out of its range by more than BEYOND of it, beyond a limit of its kind, or more than MOST_BALLS
    balls."""
    number, ball, place = condition["number"], condition["ball_diameter_mm"], kind.name
    if number < 1:
        raise ConfigError(f"{place}: the charge is less than one ball of {ball:g} mm; give more, or smaller balls")
    opening = min(2 * condition["radius_mm"], condition["height_mm"])
    if ball >= opening:
        raise ConfigError(f"{place}: ball_diameter_mm = {ball:g}: such a ball does not go into a jar of {opening:g} mm")
    kind.mill_of(condition)
    groups = kind.groups_of(condition)
    if groups["fill"] > PACKED:
        raise ConfigError(
            f"{place}: {number:g} balls of {ball:g} mm have {groups['fill']:.2g} of the jar's volume; a packing has "
            f"{PACKED:g}: the jar cannot hold them"
        )
    if groups.get("critical", 0.0) >= 1:
        raise ConfigError(
            f"{place}: the speed is {groups['critical']:.3g} of the critical one, from which on a ball that does not "
            f"slide goes round with the wall; take less than {60 * condition['speed_hz'] / groups['critical']:.3g} rpm"
        )
    if groups.get("turns", 1.0) <= 0:
        raise ConfigError(
            f"{place}: ratio = {condition['ratio']:g}: jars of the atlas turn against the wheel; write -2 for 1:-2"
        )
    for group in kind.groups:
        value = groups[group.name]
        share = group.share(value) if value > 0 or not group.logarithmic else -math.inf
        if group.name != STIFFNESS and not -BEYOND <= share <= 1 + BEYOND:
            speed, hint = condition["speed_hz"], SIMULATE
            for factor, meant in ((60, f"in Hz? Write {60 * speed:g}Hz"), (1 / 60, f"in rpm? Write {speed:g}")):
                if group.name == "froude" and group.low <= value * factor**2 <= group.high:
                    hint = f"is the speed {meant}"
            raise ConfigError(
                f"{place}: {group.name}, {group.formula}, = {value:.3g}: the atlas knows {group.low:g} to "
                f"{group.high:g}; {hint}"
            )
    for limit in kind.limits:
        if (value := limit.of(groups)) > limit.most:
            raise ConfigError(
                f"{place}: {limit.formula} = {value:.3g}: {limit.reason}; the atlas knows up to {limit.most:g}; "
                f"{SIMULATE}"
            )
    if number > MOST_BALLS:
        raise ConfigError(f"{place}: {number:g} balls: the atlas knows up to {MOST_BALLS}; {SIMULATE}")
    return groups


def is_known(kind: Kind, groups: Mapping[str, Any], number: Any) -> np.ndarray:
    """Whether the atlas knows conditions (m,) with these groups and numbers of balls, as `check` says it of one."""
    known = (np.asarray(groups["fill"]) <= PACKED) & (np.asarray(number) <= MOST_BALLS)
    for group in kind.groups:
        if group.name != STIFFNESS:
            share = group.share(np.asarray(groups[group.name], dtype=float))
            known = known & (share >= -BEYOND) & (share <= 1 + BEYOND)
    return known & within_limits(kind, groups)


def estimate_many(model: KindModel, conditions: Mapping[str, Any]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Logarithms of PREDICTED in SI, each (m,), and whether balls are likely to hit something (m,), without intervals.

    conditions: as of `estimate`, with arrays (m,) or numbers. NaN and False where the atlas says nothing.
    """
    kind, count = model.kind, max(np.size(own) for own in conditions.values())

    def each(values: Any) -> np.ndarray:
        return np.broadcast_to(np.asarray(values, dtype=float), count)

    groups = {name: each(own) for name, own in kind.groups_of(conditions).items()}
    known = is_known(kind, groups, each(conditions["number"]))
    logs, hits = {name: np.full(count, math.nan) for name in PREDICTED}, np.full(count, False)
    if known.any():
        (stiffness,) = (group for group in kind.groups if group.name == STIFFNESS)
        inputs = inputs_of(
            kind,
            {name: np.clip(own[known], stiffness.low, stiffness.high) if name == STIFFNESS else own[known]
             for name, own in groups.items()},
        )  # fmt: skip
        scales = {name: np.log(each(own)[known]) for name, own in kind.scales(conditions).items()}
        for name, own in combined(model.fitted(inputs)).items():
            logs[name][known] = own + scales[PREDICTED[name]]
        hits[known] = model.probability(inputs) > HITS
    return logs, hits


def estimate(kind: Kind, condition: Values, model: KindModel | None = None) -> MillEstimate:
    """What the atlas tells about a condition: dimensions of the mill and all of `kinds.SETTINGS`. Raises ConfigError as
    `check` and `model_of`."""
    groups = check(kind, condition)
    model = model or model_of(kind)
    (stiffness,) = (group for group in kind.groups if group.name == STIFFNESS)
    notes = []
    if not stiffness.low <= groups[STIFFNESS] <= stiffness.high:
        groups = groups | {STIFFNESS: min(max(groups[STIFFNESS], stiffness.low), stiffness.high)}
        notes.append("balls are stiffer or softer than the atlas knows; shear is told as at the end of its range")
    inputs = inputs_of(kind, groups)
    scales = kind.scales(condition)
    units = {"power": "W", "energy": "J", "frequency": "1/s"}
    known = {}
    for name, (value, width) in model.logarithms(inputs).items():
        scale = scales[PREDICTED[name]]
        low, middle, high = (scale * math.exp(float(value[0]) + side * float(width[0])) for side in (-1, 0, 1))
        known[name] = Estimate(middle, units[PREDICTED[name]], scatter=Interval(low, high))
    unsure = tuple(name for name, mark in MARKS.items() if model.widths[name].typical(inputs)[0] > mark)
    return MillEstimate(kind, condition, groups, float(model.probability(inputs)[0]), known, tuple(notes), unsure)


def exponents(kind: Kind, condition: Values, model: KindModel | None = None) -> dict[str, dict[str, Estimate]]:
    """How each of PREDICTED grows with each dimension and setting, the others kept: local exponents d ln y / d ln x.

    From differences over STEP to each side, or to one at the end of a range, with the 90 % interval of the process. A
    number of balls counts as any other. By observable, then dimension.
    """
    model = model or model_of(kind)
    names, lengths, ends = [], [], []
    for name in (*(own.name for own in kind.dimensions), *(own.name for own in SETTINGS)):
        if not condition[name]:
            continue
        sides = [_moved(kind, condition, name, side) for side in (-STEP, STEP)]
        if length := STEP * sum(moved is not None for moved in sides):
            names.append(name)
            lengths.append(length)
            ends.append([condition if moved is None else moved for moved in sides])
    before, after = (
        np.vstack([inputs_of(kind, kind.groups_of(end)) for end in own]) for own in zip(*ends, strict=True)
    )
    found: dict[str, dict[str, Estimate]] = {}
    for own, (slopes, errors) in _slopes(model, before, after).items():
        scales = np.array([[kind.scales(end)[PREDICTED[own]] for end in both] for both in ends])
        values = (slopes + np.log(scales[:, 1] / scales[:, 0])) / lengths
        halves = NORMAL * errors / lengths
        found[own] = {
            name: Estimate(value, "-", scatter=Interval(value - half, value + half))
            for name, value, half in zip(names, values.tolist(), halves.tolist(), strict=True)
        }
    return found


def _moved(kind: Kind, condition: Values, name: str, step: float) -> dict[str, float] | None:
    """The condition with one value times exp(step); None where the atlas does not know it."""
    moved = {**condition, name: condition[name] * math.exp(step)}
    try:
        check(kind, moved)
    except ConfigError:
        return None
    return moved


def _slopes(model: KindModel, before: np.ndarray, after: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Differences (m,) of the logarithm of each of PREDICTED over its scale, and their errors, from the surfaces."""
    first, last = model.fitted(before), model.fitted(after)
    low, high = combined(first), combined(last)
    # The motion is kept.
    motion = model.completed(before)[:, -1]
    start, end = np.column_stack([before, motion]), np.column_stack([after, motion])
    errors = {name: own.slope_error(start, end, model.centres) for name, own in model.surfaces.items()}
    squared = dict.fromkeys(PREDICTED, 0.0)
    for each, error in errors.items():
        # What a small change of each surface does to the logarithms.
        moved = combined({**last, each: last[each] + 1e-4})
        for name in PREDICTED:
            squared[name] = squared[name] + ((moved[name] - high[name]) * 1e4 * error) ** 2
    return {name: (high[name] - low[name], np.sqrt(squared[name])) for name in PREDICTED}
