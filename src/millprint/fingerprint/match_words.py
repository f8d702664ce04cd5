"""A match in sentences: the verdict, the time for the same dose, and what to choose where not all can be met.

Two mills: their descriptors side by side, and the conditions of one nearest to the other's.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any

import pandas as pd

from millprint.config.charge import ONE_SIZE, balls_in_words
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.included import load_mill
from millprint.config.load import check_model
from millprint.config.wording import other_unit
from millprint.estimate.estimates import columns_of, ratio_of
from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.fingerprint.bands import FURTHER, ORIGINS
from millprint.fingerprint.condition_search import (
    SOLD_MM,
    Target,
    counts_alike,
    ranges_of,
    rank_conditions,
    target_at,
    variables_in_words,
)
from millprint.fingerprint.descriptors import CHARGE
from millprint.fingerprint.mill_sheet import shown_speed
from millprint.fingerprint.model import Fingerprint
from millprint.observables.condition import Condition
from millprint.observables.definitions import DESCRIPTOR_SETS, POWER, POWER_PARTS, PREDICTED, SHARE
from millprint.run.numbers import NOT_KNOWN, three

# A setting is at a limit if it is as near as this, as a fraction of it.
AT_LIMIT = 2e-3
# Balls up to this factor outside of the simulated sizes may be proposed, if they come nearer by the other.
OTHER_SIZES, NEARER = 2.0, 0.5
# Of a share, its odds are compared.
COMPARED_TITLES, COMPARED_SIGNS = {SHARE.name: "tangential over normal power Pt/Pn"}, {SHARE.name: "Pt/Pn"}
# A number farther off than this factor is asked about its unit, if in another one it is nearer than that.
WRONG_UNIT, RIGHT_UNIT = 300, 30
HEADS = {
    AGREES: "met on {mill}",
    OPEN: "not known on {mill} ({reason}); the nearest, {within}",
    DIFFERS: "not met on {mill}; the nearest, {within}",
}


def compared_sign(name: str) -> str:
    """The symbol of what is compared of a descriptor."""
    return COMPARED_SIGNS.get(name, PREDICTED[name].symbol)


@cache
def speed_unit(mill: str) -> str:
    """The unit that a mill is set in, rpm or hz, by its file; rpm for a mill without one."""
    try:
        return load_mill(mill).speed_unit
    except ConfigError:
        return "rpm"


def speed_in_words(mill: str, speed_rpm: float) -> str:
    """A speed in the unit that the mill is set in."""
    return shown_speed(speed_unit(mill), (speed_rpm if speed_rpm < 100 else round(speed_rpm)) / 60)


def setting_in_words(row: Mapping) -> str:
    """A setting: "balls of 10 mm, fill 0.12, 420 rpm"."""
    balls = balls_in_words(row["ball_diameter_mm"], row.get(CHARGE, ONE_SIZE))
    return f"balls of {balls}, fill {row['fill_ratio']:.3g}, {speed_in_words(row['mill'], row['speed_rpm'])}"


def place_in_words(row: Mapping, fingerprints: Sequence[Fingerprint]) -> str:
    """A setting, with its mill if there are several."""
    return f"{row['mill']}, {setting_in_words(row)}" if len(fingerprints) > 1 else setting_in_words(row)


def interval_in_words(row: Mapping, name: str, of: str = "mean") -> str:
    """An interval in a row of a table: "0.31 to 0.40", or that it is not known."""
    low, high = (row.get(column, math.nan) for column in columns_of(name, of))
    return f"{three(low)} to {three(high)}" if low == low else NOT_KNOWN


def ratio_in_words(row: Mapping, name: str) -> str:
    """A descriptor over that of the target: "weighted normal energy E*n met, 1.02 times (0.91 to 1.14)"."""
    met = " met," if name in row["met"].split(", ") else ""
    ratio = f"{name}_ratio"
    title = COMPARED_TITLES.get(name, PREDICTED[name].title)
    return f"{title}{met} {three(row[ratio])} times ({interval_in_words(row, ratio)})"


def ratios_in_words(row: Mapping, names: Sequence[str]) -> str:
    """The descriptors of a row over those of the target."""
    return ", ".join(ratio_in_words(row, name) for name in names)


def farthest(row: Mapping, names: Sequence[str]) -> str:
    """How near a row comes in all of some descriptors: "within 30 %", or "within a factor of 2.1"."""
    factor = math.exp(max(abs(math.log(row[f"{name}_ratio"])) for name in names))
    return f"within {math.ceil(100 * (factor - 1)):d} %" if factor < 2 else f"within a factor of {factor:.2g}"


def best_of(rows: pd.DataFrame) -> dict:
    """The nearest row that is met; the nearest one if none is."""
    met = rows[rows["verdict"] == AGREES]
    return (met if len(met) else rows).iloc[0].to_dict()


def limits_in_words(row: Mapping, own: Fingerprint, request: SearchConfig) -> str:
    """The limits of the searched ranges at which a row is, so that a wider range may come nearer."""
    ranges = ranges_of(request, own)
    sizes = [1e3 * own.balls(choice)[0] for choice in ranges["ball_diameters_mm"]]
    searched = (
        ("speed", "speed_rpm", ranges["speeds_rpm"], lambda end: speed_in_words(row["mill"], end)),
        ("fill ratio", "fill_ratio", ranges["fill_ratios"], "{:.3g}".format),
        ("ball size", "ball_diameter_mm", sizes, "{:g} mm".format),
    )
    found = [
        f"the {word} {name}, {text(end)},"
        for name, key, values, text in searched
        for word, end in (("lowest", min(values)), ("highest", max(values)))
        if min(values) < max(values) and math.isclose(row[key], end, rel_tol=AT_LIMIT)
    ]
    if not found:
        return "no limit of the ranges stands in the way: this mill does not give these values together"
    return f"{' and '.join(found)} {'stands' if len(found) == 1 else 'stand'} in the way of coming nearer"


def time_in_words(row: Mapping, hours: float) -> str:
    """The milling time for the same dose, with its interval; empty where the target is not a condition."""
    if not row.get("time_ratio", math.nan) > 0:
        return ""
    ends = [hours * row[column] for column in columns_of("time_ratio", "mean")]
    known = f"{three(ends[0])} to {three(ends[1])} h" if ends[0] == ends[0] else NOT_KNOWN
    here = three(hours * row["time_ratio"])
    return (
        f"{hours:g} h there is {here} h here ({known}) for the same energy per gram of powder, at the same "
        "ball-to-powder ratio"
    )


def choices_in_words(
    best: Mapping, target: Target, request: SearchConfig, fingerprints: Sequence[Fingerprint]
) -> Iterator[str]:
    """What else to choose where not all can be met: one of them, with what it costs the others, or other balls."""
    told = {setting_in_words(best)}
    energies = [name for name in target.asked if PREDICTED[name].unit != "1/s" and len(target.asked) > 1]
    for name in energies:
        nearest = request.model_copy(update={"first": name, "ranked": 1})
        row = rank_conditions(target, list(fingerprints), nearest).iloc[0].to_dict()
        if name in row["met"].split(", ") and (place := setting_in_words(row)) not in told:
            told.add(place)
            others = [other for other in target.asked if other != name]
            yield f"or {ratios_in_words(row, [name, *others])}: {place_in_words(row, fingerprints)}"
    own = next(each for each in fingerprints if each.about["mill"] == best["mill"])
    known = [size for size in own.choices() if not isinstance(size, str)]
    sizes = [size for size in SOLD_MM if known and min(known) / OTHER_SIZES <= size <= OTHER_SIZES * max(known)]
    if other := [size for size in sizes if not min(known) <= size <= max(known)]:
        row = rank_conditions(target, [own], request.model_copy(update={"ball_diameters_mm": other, "ranked": 1}))
        if row["distance"].iloc[0] < NEARER * best["distance"]:
            found = row.iloc[0].to_dict()
            yield (
                f"or other balls, {farthest(found, target.asked)} by the scaling of the curves: "
                f"{setting_in_words(found)}; simulate them first"
            )


def units_in_words(row: Mapping, target: Target) -> Iterator[str]:
    """A question for each number of a target that no setting comes near to, but would in another unit."""

    def is_near(meant: float, found: float, factor: float) -> bool:
        return abs(math.log(meant / found)) < math.log(factor)

    for name, value in target.values.items() if target.probability is None else ():
        found, unit = value * row[f"{name}_ratio"], PREDICTED[name].unit
        asked = other_unit(value, unit, partial(is_near, found=found, factor=RIGHT_UNIT))
        if asked and not is_near(value, found, WRONG_UNIT):
            yield f"{compared_sign(name)} = {value:g} {unit}: {asked}"


def match_in_words(
    rows: pd.DataFrame, target: Target, request: SearchConfig, fingerprints: Sequence[Fingerprint], hours: float = 1.0
) -> list[str]:
    """Sentences on the rows of one target, nearest first, the first of which has the verdict.

    hours: milling time of the target.
    """
    if rows.empty:
        return ["no setting: none of the requested fill ratios was simulated with impacts"]
    best = best_of(rows)
    if units := list(units_in_words(best, target)):
        return [f"not met on {best['mill']}: {'; '.join(units)}"]
    head = HEADS[best["verdict"]].format(**best, within=farthest(best, target.asked))
    lines = [f"{head}: {setting_in_words(best)}: {ratios_in_words(best, target.asked)}"]
    own = next(
        each for each in fingerprints if (each.about["mill"], each.about["contact"]) == (best["mill"], best["contact"])
    )
    if best["verdict"] == DIFFERS:
        lines += [limits_in_words(best, own, request), *choices_in_words(best, target, request, fingerprints)]
    lines += [time] if (time := time_in_words(best, hours)) else []
    for origin in FURTHER:
        if any(best.get(columns_of(f"{name}_ratio", origin)[0], math.nan) > 0 for name in target.asked):
            ends = {name: interval_in_words(best, f"{name}_ratio", origin) for name in target.asked}
            known = ", ".join(f"{compared_sign(name)} {each}" for name, each in ends.items())
            lines.append(f"ratios by {ORIGINS[origin].title}, as if independent in both mills: {known}")
    if target.outside:
        lines.append(f"the target itself is extrapolated: {variables_in_words(target.outside)} not simulated")
    return [*lines, *dict.fromkeys(said for said in (target.said, own.few_turns_in_words()) if said)]


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
