"""The conditions of a mill's sweep: from a table or a design, with fill ratios in place of numbers and masses."""

import math
from collections.abc import Iterable
from itertools import product, starmap

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.mill_sweep import CHARGES, FEWEST_FILLS, ConditionSection, MillSweepConfig
from millprint.config.mixture import BallMixture, diameter_of
from millprint.config.rows import read_rows
from millprint.config.section import first_repeated

# Digits of the settings of a design, enough for the names of its cases.
DIGITS = 5


def with_fill_ratios(sweep: MillSweepConfig, volume_ml: float, density_kg_m3: float, place: str) -> MillSweepConfig:
    """The sweep with fill ratios only, and its conditions one by one where they are not a star of lists.

    volume_ml: nominal volume of the jar; density: of the balls. Raises ConfigError, in one line that begins with
    `place` or the table, for balls that fill the jar, fewer than three fill ratios, and a condition given twice.
    """
    if sweep.conditions or sweep.table:
        given = sweep.conditions or read_conditions(sweep.table or "")
        found = [_filled(each, volume_ml, density_kg_m3, sweep.table or place) for each in given]
        return _one_by_one(sweep, found, sweep.table or place)
    key = next(key for key in CHARGES if getattr(sweep, key))
    size = (sweep.ball_diameters_mm or [])[0]
    about = {"packing_fraction": sweep.packing_fraction, "ball_diameter_mm": size, "speed_rpm": 1}
    charges = [ConditionSection(**about, **{CHARGES[key]: value}) for value in getattr(sweep, key)]
    fills = [_filled(each, volume_ml, density_kg_m3, place).fill_ratio for each in charges]
    lists = sweep.model_copy(update={key: None, "fill_ratios": fills})
    if sweep.design == "star":
        return lists if key != "fill_ratios" else sweep
    if sweep.design == "factorial":
        return _one_by_one(sweep, starmap(condition, product(lists.balls, lists.speeds, fills)), place)
    return _one_by_one(sweep, spread(lists, sweep.points or 0, seed=0, digits=DIGITS), place)


def read_conditions(path: str) -> list[ConditionSection]:
    """The conditions of a table. Raises ConfigError, a line for each fault, as `read_rows` and `check_model`."""
    rows = enumerate(read_rows(path), start=1)
    return [check_model(row, ConditionSection, f"{path}: row {number}") for number, row in rows]


def spread(sweep: MillSweepConfig, number: int, seed: int, digits: int = 17) -> list[ConditionSection]:
    """Conditions spread evenly in logarithm over the ranges of a sweep, with any of its balls (a Sobol sequence).

    seed: seed of the scrambling; digits: significant digits of speeds and fill ratios. Raises ConfigError if scipy is
    not installed.
    """
    if number == 0:
        return []
    # Imported here: slow to import, and needed by few runs.
    try:
        from scipy.stats import qmc
    except ModuleNotFoundError:
        raise ConfigError(
            "mills.held_out, and design: space_filling, need scipy in the environment of Snakemake: install it there, "
            "or set mills.held_out to 0 and give lists or a table"
        ) from None

    low, high = ([math.log(end(ends)) for ends in (sweep.fills, sweep.speeds)] for end in (min, max))
    shares = qmc.Sobol(3, scramble=True, rng=seed).random_base2(max(0, number - 1).bit_length())[:number]
    found = []
    for own in shares:
        fill, speed = (math.exp(a + (b - a) * share) for a, b, share in zip(low, high, own[:2], strict=True))
        size = sweep.balls[int(own[2] * len(sweep.balls))]
        found.append(condition(size, float(f"{speed:.{digits}g}"), float(f"{fill:.{digits}g}")))
    return found


def condition(balls: float | BallMixture, speed_rpm: float, fill_ratio: float) -> ConditionSection:
    """One condition of a sweep, from elements of its lists."""
    return ConditionSection(ball_diameter_mm=balls, speed_rpm=speed_rpm, fill_ratio=fill_ratio)


def _filled(section: ConditionSection, volume_ml: float, density_kg_m3: float, place: str) -> ConditionSection:
    """A condition with its fill ratio in place of another measure."""
    try:
        fill = section.fill_in(volume_ml, diameter_of(section.ball_diameter_mm), density_kg_m3)
    except ValueError as error:
        raise ConfigError(f"{place}: {error}") from None
    speed = {"speed_hz": section.speed_hz, "speed_rpm": section.speed_rpm}
    return ConditionSection(ball_diameter_mm=section.ball_diameter_mm, fill_ratio=fill, **speed)


def _one_by_one(sweep: MillSweepConfig, conditions: Iterable[ConditionSection], place: str) -> MillSweepConfig:
    """A sweep of these conditions with the seeds and durations of another."""
    found = list(conditions)
    named = (f"balls of {_named(each)}, fill ratio {each.fill_ratio:.4f}, {each.rpm:g} rpm" for each in found)
    if twice := first_repeated(named):
        raise ConfigError(f"{place}: two conditions are the same: {twice}; for a repetition give `seeds`")
    if len(fills := {each.fill_ratio for each in found}) < FEWEST_FILLS:
        raise ConfigError(f"{place}: has {len(fills)} fill ratios; a fingerprint needs {FEWEST_FILLS} at least")
    kept = {key: getattr(sweep, key) for key in ("seeds", "discard_turns", "window_turns")}
    return MillSweepConfig(conditions=found, **kept)


def _named(condition: ConditionSection) -> str:
    size = condition.ball_diameter_mm
    return size.name if isinstance(size, BallMixture) else f"{size:g} mm"
