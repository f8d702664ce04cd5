"""The settings of mills that one may own that do most nearly what another does, or that give the most power.

Normal power breaks; shear wears balls and walls (Archard: wear grows with the work of sliding), so a limit of shear
power is a limit of wear. The search is differential evolution (scipy.optimize) over values of the atlas; the optimum
is to be simulated once, since an optimum is where a model is most likely to flatter.

For each mill and each size of balls that is sold, number of balls and speed are searched over all that the atlas knows:
a grid in logarithms with those that are wanted, then finer ones around the nearest. Alike are E*_n and E*_t; how often
they come is made up by time. A search asks for values only; verdicts are by the intervals of both mills.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millprint.atlas.atlas_model import KindModel
from millprint.atlas.estimate_mill import MillEstimate, estimate, estimate_many
from millprint.atlas.kind_groups import MOST_BALLS, Kind, Values
from millprint.atlas.kinds import KINDS, recognise
from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from millprint.estimate.estimates import Estimate, Interval, ratio_of
from millprint.estimate.judge import AGREES, Verdict, judge_all
from millprint.fingerprint.condition_search import verdict_on
from millprint.run.files import read_table

ASSUMED = "assumed"
# The jar, which makes a mill of a maker's machine; its fastest speed, or the only one that it has.
JAR = {"radius_mm", "height_mm"}
FASTEST, ONLY = {"speed_max_rpm": 1 / 60, "speed_max_hz": 1.0}, {"speed_rpm": 1 / 60, "speed_hz": 1.0}


def makers_mills(path: str | Path, kinds: list[Kind]) -> list[dict[str, Any]]:
    """The mills of makers whose jar the table gives: further dimensions that it lacks as the included mill of the kind
    has them.

    slowest_hz, fastest_hz: of the machine, 0 and None where they are not known; known: how each of the dimensions is
    known that nobody assumed.
    """
    table = read_table(path)
    found: list[dict[str, Any]] = []
    for (name, kind_name), rows in table.groupby(["mill", "kind"], sort=False):
        kind = next((kind for kind in kinds if kind.name == kind_name), None)
        values = dict(zip(rows["quantity"], rows["value"], strict=True))
        known = recognise(load_mill(kind.name)) if kind else None
        own = {each.name for each in kind.dimensions} & set(values) if kind else set()
        if kind is None or known is None or not own >= JAR:
            continue
        dimensions = known[1] | {each: values[each] for each in own}
        fastest = [values[key] * factor for key, factor in (FASTEST | ONLY).items() if key in values]
        found.append({
            "title": name, "kind": kind.name, "dimensions": dimensions,
            "slowest_hz": fastest[0] if fastest and not set(FASTEST) & set(values) else 0.0,
            "fastest_hz": fastest[0] if fastest else None,
            "known": {row["quantity"]: row["how_known"] for row in rows.to_dict("records")
                      if row["quantity"] in own and not row["how_known"].startswith(ASSUMED)},
        })  # fmt: skip
    return found


def own_mill(title: str, kind: Kind, dimensions: Values, made: list[dict[str, Any]]) -> dict[str, Any]:
    """A mill of which only the dimensions are told; its speeds are those of the maker's that has the same."""
    same = (own for own in made if own["kind"] == kind.name and _is_one(own["dimensions"], dimensions))
    slowest, fastest = next(((own["slowest_hz"], own["fastest_hz"]) for own in same), (0.0, None))
    speeds = {"slowest_hz": slowest, "fastest_hz": fastest}
    return {"title": title, "kind": kind.name, "dimensions": dimensions, **speeds, "known": None}


def fastest_of_kinds(made: list[dict[str, Any]]) -> dict[str, float]:
    """What the fastest of makers' mills of a kind reach [Hz], but for kinds with a critical speed of their own."""
    fastest: dict[str, float] = {}
    for own in made:
        if own["fastest_hz"] and "critical" not in KINDS[own["kind"]].names:
            fastest[own["kind"]] = max(own["fastest_hz"], fastest.get(own["kind"], 0.0))
    return fastest


# Two mills are one where no dimension differs by more than this.
ONE_MILL = 0.02


def _is_one(own: Values, other: Values) -> bool:
    return np.allclose([*own.values()], [other[name] for name in own], ONE_MILL)


def listed_mills(made: list[dict[str, Any]], included: list[str], kinds: list[Kind]) -> list[dict[str, Any]]:
    """The included mills of a kind and those of makers (made) whose dimensions the atlas knows, each once: one in both
    tables is the maker's."""
    mills = []
    for name in included:
        mill = load_mill(name)
        built = recognise(mill)
        if built and built[0] in kinds:
            mills.append(own_mill(mill.title, *built, made))

    def is_made(own: dict[str, Any]) -> bool:
        return any(each["kind"] == own["kind"] and _is_one(each["dimensions"], own["dimensions"]) for each in made)

    listed = [*(own for own in mills if not is_made(own)), *made]
    return [own for own in listed if KINDS[own["kind"]].knows(own["dimensions"])]


# Members of a generation for each setting, generations, seed; how much a thing that cannot be counts.
MEMBERS, GENERATIONS, SEED, IMPOSSIBLE = 12, 60, 0, 1e3


def best_settings(
    model: KindModel, condition: Values, bounds: Mapping[str, tuple[float, float]], most_shear_W_kg: float | None = None
) -> MillEstimate:
    """The condition with the most normal power per mass of balls, the settings of `bounds` within them.

    condition: dimensions and settings that are kept; most_shear_W_kg: of tangential power per mass of balls. Raises
    ConfigError, in one line, where the atlas knows nothing within the bounds.
    """
    # Imported here: slow to import.
    from scipy.optimize import differential_evolution

    names = list(bounds)

    def cost(places: np.ndarray) -> np.ndarray:
        return _cost(model, {**condition, **dict(zip(names, np.exp(places), strict=True))}, most_shear_W_kg)

    found = differential_evolution(
        cost, [tuple(np.log(bounds[name])) for name in names], popsize=MEMBERS, maxiter=GENERATIONS, rng=SEED,
        vectorized=True, updating="deferred", polish=False,
    )  # fmt: skip
    if found.fun >= IMPOSSIBLE:
        limit = "" if most_shear_W_kg is None else f" with at most {most_shear_W_kg:g} W/kg of shear"
        raise ConfigError(f"--within: the atlas knows no condition{limit} within these bounds; widen them")
    best = {**condition, **dict(zip(names, map(float, np.exp(found.x)), strict=True))}
    return estimate(model.kind, _whole(best), model)


def _whole(condition: dict[str, Any]) -> dict[str, Any]:
    """The condition with a whole number of balls."""
    return condition | {"number": np.round(condition["number"])}


def _cost(model: KindModel, condition: dict[str, Any], most_shear_W_kg: float | None) -> np.ndarray:
    """-log of the normal power per mass of balls (m,); IMPOSSIBLE and more beyond the limit, where the atlas says
    nothing, or where balls hardly hit."""
    condition = _whole(condition)
    logs, hits = estimate_many(model, condition)
    ball_kg = condition["density_kg_m3"] * np.pi / 6 * (condition["ball_diameter_mm"] / 1e3) ** 3
    mass = np.log(condition["number"] * ball_kg)
    cost = mass - logs["normal_power_W"]
    if most_shear_W_kg is not None:
        beyond = logs["tangential_power_W"] - mass - np.log(most_shear_W_kg)
        cost = np.where(beyond > 0, IMPOSSIBLE + beyond, cost)
    return np.where(hits, cost, 2 * IMPOSSIBLE)


# What is to be alike.
ALIKE = ("weighted_normal_energy_J", "weighted_tangential_energy_J")
# What is searched, in the order of `_bounds`.
SEARCHED = ("number", "speed_hz")
# Numbers of balls and speeds of the first grid and of the finer ones, how many of these there are, and how much finer.
LOOK, AROUND, ROUNDS = 14, 5, 3


@dataclass(frozen=True)
class Found:
    """A condition that was found: its estimate, the ratios of ALIKE to what is wanted, and its power per mass of balls
    over the wanted one, each with the interval of both mills; distance: root mean square of the ratios' logarithms."""

    title: str
    estimate: MillEstimate
    ratios: Mapping[str, Estimate]
    strength: Estimate
    distance: float

    def verdict(self, near_percent: float) -> Verdict:
        """Whether all of ALIKE are surely within `near_percent` of what is wanted."""
        return judge_all(verdict_on(own, near_percent) for own in self.ratios.values())


def power_of_mass(own: MillEstimate) -> Estimate:
    """Power over the mass of the balls [W/kg]."""
    return own.known["wall_power_W"] * (1 / own.charge_kg)


def is_at(own: MillEstimate, other: MillEstimate) -> bool:
    """Whether two estimates are of the same point of the atlas."""
    if own.kind is not other.kind:
        return False
    points = [own.kind.groups_of(each.condition) for each in (own, other)]
    return all(math.isclose(points[0][name], points[1][name], rel_tol=1e-9) for name in own.kind.names)


def ratio_at(one: Estimate, other: Estimate, same: bool) -> Estimate:
    """one / other; same: whether they are of the same point of the atlas, whose error both have: the interval has no
    width."""
    ratio = ratio_of(one, other)
    return Estimate(ratio.value, ratio.unit, scatter=Interval(ratio.value, ratio.value)) if same else ratio


def settings_near(
    title: str, model: KindModel, base: Values, wanted: MillEstimate, speeds_hz: tuple[float, float]
) -> Found | None:
    """The number of balls and the speed of a mill that do most nearly what is wanted; None where the atlas knows none.

    base: its dimensions, and the balls' size, density and coefficients; speeds_hz: the range of the mill.
    """
    kind = model.kind
    goal = np.log([wanted.known[name].value for name in ALIKE])
    bounds = _bounds(kind, base, speeds_hz)
    if any(low > high for low, high in bounds):
        return None
    axes = [np.geomspace(low, high, LOOK) for low, high in bounds]
    asked_for = [np.clip(wanted.condition[name], *bound) for name, bound in zip(SEARCHED, bounds, strict=True)]
    best: tuple[float, dict[str, float]] = (math.inf, {})
    for _ in range(1 + ROUNDS):
        number, speed = map(np.append, np.meshgrid(*axes), asked_for)
        asked: dict[str, Any] = {**base, "number": np.round(number), "speed_hz": _as_set(kind, speed, bounds[1])}
        far = _distances(model, asked, goal)
        nearest = int(far.argmin())
        if far[nearest] < best[0]:
            best = float(far[nearest]), {name: float(np.broadcast_to(own, far.shape)[nearest])
                                         for name, own in asked.items()}  # fmt: skip
        if not best[1]:
            return None
        steps = [(own[-1] / own[0]) ** (1 / (len(own) - 1)) for own in axes]
        axes = [
            np.clip(np.geomspace(best[1][name] / step, best[1][name] * step, AROUND), low, high)
            for name, step, (low, high) in zip(SEARCHED, steps, bounds, strict=True)
        ]
    own = estimate(kind, best[1], model)
    same = is_at(own, wanted)
    ratios = {name: ratio_at(own.known[name], wanted.known[name], same) for name in ALIKE}
    return Found(title, own, ratios, ratio_at(power_of_mass(own), power_of_mass(wanted), same), best[0])


def nearest_settings(
    title: str, model: KindModel, dimensions: Values, balls: Values, diameters_mm: Sequence[float],
    wanted: MillEstimate, speeds_hz: tuple[float, float] = (0.0, math.inf),
) -> list[Found]:  # fmt: skip
    """The nearest settings of a mill, one for each size of balls that the atlas knows there, nearest first."""
    each = (
        settings_near(title, model, {**dimensions, **balls, "ball_diameter_mm": size}, wanted, speeds_hz)
        for size in diameters_mm
    )
    return sorted((own for own in each if own is not None), key=lambda own: own.distance)


def _as_set(kind: Kind, speed_hz: np.ndarray, within: tuple[float, float]) -> np.ndarray:
    """Speeds as a mill is set, and within its bounds: whole turns per minute, or tenths of hertz."""
    step = 0.1 if kind.speed_unit == "hz" else 1 / 60
    slowest, fastest = within
    least, most = np.ceil(slowest / step * (1 - 1e-9)), np.floor(fastest / step * (1 + 1e-9))
    # A machine of one speed may have none of these between its bounds.
    return np.clip(np.clip(np.round(speed_hz / step), max(least, 1), most) * step, slowest, fastest)


def _bounds(kind: Kind, base: Values, speeds_hz: tuple[float, float]) -> list[tuple[float, float]]:
    """The least and the most of number of balls and of speed that groups allow, each with the other's 1."""
    one = kind.groups_of({**base, "number": 1.0, "speed_hz": 1.0})
    ranges = {group.name: group for group in kind.groups}
    fill = ranges["fill"]
    speed, power = (ranges["froude"], 0.5) if "froude" in ranges else (ranges["critical"], 1.0)
    slowest, fastest = ((end / one[speed.name]) ** power for end in (speed.low, speed.high))
    fewest, most = (end / one["fill"] for end in (fill.low, fill.high))
    return [(max(1.0, math.ceil(fewest)), min(math.floor(most), MOST_BALLS)),
            (max(slowest, speeds_hz[0]), min(fastest, speeds_hz[1]))]  # fmt: skip


# Distances under this are equal: intervals of the atlas are some ten times as wide.
EQUAL = 0.05


def ranked(found: list[Found], near_percent: float) -> list[Found]:
    """What is surely near first, then by distance; of what is equally near, what takes the least time."""
    return sorted(
        found,
        key=lambda own: (
            own.verdict(near_percent).word != AGREES, max(own.distance, EQUAL), -own.strength.value,
        ),
    )  # fmt: skip


def _distances(model: KindModel, asked: dict[str, Any], goal: np.ndarray) -> np.ndarray:
    """Root mean square of the logarithms of ALIKE over what is wanted; infinite where the atlas knows nothing."""
    logs, hits = estimate_many(model, asked)
    apart = np.stack([logs[name] for name in ALIKE], axis=1) - goal
    return np.where(hits, np.sqrt((apart**2).mean(axis=1)), math.inf)
