"""Descriptors of dissipation: a row for each condition, the mean over its seeds."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from millprint.config.charge import ONE_SIZE
from millprint.config.counting import CountingRule, recorded_count
from millprint.config.sweep import as_tabulated
from millprint.dem.collisions import ROUNDING
from millprint.dem.turns import (
    NEGLIGIBLE,
    Drift,
    drift_of_turns,
    has_impacts,
    mean_of_turns,
    motion_repeats,
    scale_of_hits,
)
from millprint.fingerprint.readers import collisions_by, read_contacts
from millprint.observables.counted_collisions import CHANNELS, PARTS, Collisions
from millprint.observables.definitions import COMPUTED, DESCRIPTORS, MEASURED, STATISTICS, Measured
from millprint.run.files import read_table
from millprint.run.numbers import prefix_of, three

# The columns that define a condition. `varied` names what a sweep changed of mill or balls; NOTHING if as built.
# `charge` names balls of several sizes; ONE_SIZE for others.
CHARGE = "charge"
CONDITION_TEXT = ["mill", "contact", "varied", CHARGE]
CONDITION_NUMBERS = ["ball_diameter_mm", "fill_ratio", "speed_rpm", "density_kg_m3", "amplitude_m"]
CONDITION = [*CONDITION_TEXT, *CONDITION_NUMBERS]
NOTHING = "nothing"
OVERRIDES = {"amplitude_mm": "amplitude", "density_kg_m3": "density"}

# Columns that later stages need.
OF_RULE = ["counting_rule", "collisions_by"]
MOTION_TEXT = ["motion", "lasting_motions"]
DESCRIPTOR_TEXT = [*CONDITION_TEXT, *OF_RULE, *MOTION_TEXT]
DESCRIPTOR_NUMBERS = [*CONDITION_NUMBERS, *(name for name, column in DESCRIPTORS.items() if not column.optional)]


def condition_of(summary: dict) -> dict:
    """The condition of a run: CONDITION by name."""
    case = summary["case"]
    changed = [word for key, word in OVERRIDES.items() if case.get(key) is not None]
    return {
        "mill": summary["mill"],
        "contact": summary["contact"],
        "varied": " and ".join(changed) or NOTHING,
        CHARGE: (case.get("mixture") or {}).get("name", ONE_SIZE),
        **as_tabulated(case),
        **{name: summary[name] for name in ("density_kg_m3", "amplitude_m")},
    }


def read_descriptors(path: str | Path) -> pd.DataFrame:
    """Read descriptors.tsv; raises ConfigError as `millprint.run.files.read_table`."""
    table = read_table(path, numeric=DESCRIPTOR_NUMBERS, text=DESCRIPTOR_TEXT)
    # pandas reads an empty cell as NaN, which groupby would drop.
    return table.assign(**{name: table[name].fillna("") for name in (CHARGE, *MOTION_TEXT) if name in table})


def as_built(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the unchanged mill and balls, without sweeps over amplitude or density."""
    return table[table["varied"] == NOTHING]


def said_of(table: pd.DataFrame, name: str) -> pd.Series:
    """Whether each condition has the word of a motion, by its name in MOTIONS, for some of its simulations or all."""
    return table["motion"].fillna("").map(lambda told: name in motions_in(told)).astype(bool)


def with_impacts(table: pd.DataFrame) -> pd.DataFrame:
    """The conditions in which balls hit anything, whose curves the others would bend; all of them where the mill as
    built has none.
    """
    kept = table[~said_of(table, "no_impacts")]
    return kept if len(as_built(kept)) else table


def run_row(summary: dict, rule_name: str) -> dict:
    """The measured columns of a run, with collisions counted by the rule of that name, which has no threshold."""
    summary = _without_rounding(summary)
    rule = recorded_count(summary, rule_name)
    collisions = _collisions_of(summary, rule)
    return {
        **condition_of(summary),
        "counting_rule": rule["name"],
        "collisions_by": rule["by"],
        **{own.name: own.of_run(summary, rule, collisions) for own in MEASURED},
        **_turns_row(summary, rule["frequency_hz"] / summary["frequency_hz"]),
        **_scatter_row(summary, collisions),
    }


def _without_rounding(summary: dict) -> dict:
    """The summary with 0 in place of a power that is nothing but rounding, and of its channel's weighted energy."""
    powers = {name: summary["power_W"][name] for name in PARTS}
    nothing = [name for name in PARTS if powers[name] < ROUNDING * sum(powers.values())]
    weighted = {
        name: summary["weighted"][name] | {"energy_J": 0.0, "specific_frequency_hz": 0.0}
        for name in nothing
        if name in CHANNELS
    }
    return summary | {
        "power_W": summary["power_W"] | dict.fromkeys(nothing, 0.0),
        "weighted": summary["weighted"] | weighted,
    }


def _collisions_of(summary: dict, rule: dict) -> Collisions | None:
    """The collisions of a run by a counting rule, where an observable needs them and it has a table of them."""
    if "run_path" not in summary or not STATISTICS:
        return None
    contacts = read_contacts(summary["run_path"], everything=True)
    return collisions_by(contacts, CountingRule.of_count(rule), summary["frequency_hz"]) if contacts else None


def _turns_row(summary: dict, collisions: float) -> dict:
    """For a run: whether balls hit anything, independent turns, and whether the motion repeats.

    collisions: per turn.
    """
    energies = {name: summary["per_revolution"].get(f"{name}_J", []) for name in CHANNELS}
    known = {name: mean_of_turns(own) for name, own in energies.items()}
    independent = [of_turns.independent if of_turns else float(len(energies[name])) for name, of_turns in known.items()]
    # Without shear, what is dissipated by it has no turns that repeat.
    dissipated = [own for own in energies.values() if any(own)]
    locked = bool(dissipated) and all(motion_repeats(own, collisions) for own in dissipated)
    hits = has_impacts(energies["normal"] or [_of_a_turn(summary)], scale_of_hits(summary))
    # A summary of an earlier version has no such number.
    stuck = (summary.get("speed_over_vessel") or 1.0) < STUCK
    return {
        "runs_with_impacts": int(hits),
        "stuck_runs": int(stuck),
        "independent_turns": min(independent),
        "repeating_runs": int(locked),
        **{f"{name}_{part}": own for name in CHANNELS for part, own in _memory_of(energies[name], locked).items()},
        **{f"{name}_{part}": own for name in CHANNELS for part, own in _drift_of(energies, name, locked).items()},
    }


def _drift_of(energies: Mapping[str, Sequence[float]], name: str, locked: bool) -> dict[str, float]:
    """The `drift_of_turns` of a channel; 0 without one, for a motion that repeats and of next to no power."""
    told = drift_of_turns(energies[name])
    if not told or locked or sum(energies[name]) < NEGLIGIBLE * sum(map(sum, energies.values())):
        told = Drift(0.0, 0.0, 0)
    return {"drift": told.change, "drift_variance": told.error**2, "drift_freedom": told.freedom}


def _memory_of(energies: Sequence[float], locked: bool) -> dict[str, float]:
    """Of turns about their mean: their number, the sum of their squares, and that of the products of neighbours.

    Both are 0 for a motion that repeats, whose turns vary by next to nothing.
    """
    apart = (0.0 if locked else 1.0) * (np.asarray(energies, dtype=float) - np.mean(energies or [0.0]))
    return {"turns": len(apart), "squares": float(apart @ apart), "products": float(apart[1:] @ apart[:-1])}


def _of_a_turn(summary: dict) -> float:
    """Normal dissipation of all balls per turn [J]."""
    return summary["power_W"]["normal"] / summary["frequency_hz"]


# Quantities whose scatter is known from turns and seeds.
SCATTERED = (
    *(f"{name}_power" for name in CHANNELS),
    *("power", "power_ratio", "rolling_power", "wall_power", "rolling_ratio"),
    *(f"weighted_{name}_{kind}" for name in CHANNELS for kind in ("energy", "frequency")),
    *(own.name for own in STATISTICS),
)


def _scatter_row(summary: dict, collisions: Collisions | None) -> dict[str, float]:
    """For a run: the value of each of SCATTERED, its relative variance from the turns, and the degrees of freedom."""
    energies = [np.asarray(summary["per_revolution"].get(f"{name}_J", []), dtype=float) for name in PARTS]
    powers = [summary["power_W"][name] for name in PARTS]
    rolling_W, rolling = powers.pop(), energies.pop()
    told = {}
    for name, power, energy in zip(CHANNELS, powers, energies, strict=True):
        error, weighted = summary["power_standard_error_W"][name], summary["weighted"][name]
        known = mean_of_turns(energy.tolist())
        told[f"{name}_power"] = (power, error and power and error / power, known.freedom if known else 0)
        squares = np.asarray(summary["per_revolution"].get(f"{name}_square_J2", []), dtype=float)
        errors = weighted_errors(energy, squares)
        for kind, key in (("energy", "energy_J"), ("frequency", "specific_frequency_hz")):
            told[f"weighted_{name}_{kind}"] = (weighted[key], *errors[kind])
    counted = np.sum(energies, axis=0)
    told["power"] = (sum(powers), *_relative(counted))
    told["rolling_power"] = (rolling_W, *_relative(rolling))
    told["wall_power"] = (summary["power_W"]["wall"], *_relative(counted + rolling))
    told["power_ratio"] = _ratio_of_parts(powers[1], powers[0], energies[1], energies[0])
    told["rolling_ratio"] = _ratio_of_parts(rolling_W, sum(powers), rolling, counted)
    frequency_hz = summary["frequency_hz"]
    told |= {own.name: _of_blocks(own, collisions, frequency_hz) for own in STATISTICS}
    row: dict[str, float] = {}
    for name, (value, error, freedom) in told.items():
        variance = np.nan if error is None else error**2
        row |= {name: value, f"{name}_variance": variance, f"{name}_freedom": 0 if error is None else freedom}
    return row


def weighted_errors(energies: np.ndarray, squares: np.ndarray) -> dict[str, tuple[float | None, int]]:
    """Relative errors of an energy-weighted mean E* and of its rate f* = P / E*, each with its degrees of freedom.

    energies: of each turn (turns,) [J]; squares: sums of squares of the contacts that begin in each turn (turns,) [J2].
    E* goes with squares / energy and f* with energy^2 / squares: errors of ratios to first order, of turns that may be
    alike (`mean_of_turns`). None for fewer than two turns.
    """
    if len(energies) < 2 or not energies.mean() or len(squares) != len(energies) or not squares.mean():
        return {"energy": (None, 0), "frequency": (None, 0)}
    of_energy, of_squares = energies / energies.mean(), squares / squares.mean()
    return {"energy": _relative(1 + of_squares - of_energy), "frequency": _relative(2 * of_energy - of_squares)}


def _ratio_of_parts(
    above: float, below: float, of_above: np.ndarray, of_below: np.ndarray
) -> tuple[float, float | None, int]:
    """A ratio of two powers, its relative error from their energies in each turn, and the degrees of freedom."""
    if len(of_above) < 2 or min(above, below) <= 0:
        return (np.nan, None, 0)
    # To first order, a ratio varies with the difference of its relative parts.
    return (above / below, *_relative(1 + of_above / of_above.mean() - of_below / of_below.mean()))


def _of_blocks(own: Measured, collisions: Collisions | None, frequency_hz: float) -> tuple[float, float | None, int]:
    """A statistic of collisions, its relative error from g blocks of turns left out in turn, and g - 1.

    v = (g - 1) / g sum (x_(j) / mean - 1)^2 (delete-a-group jackknife, Kott, J. Official Stat. 17 (2001) 521).
    """
    statistic = own.of_collisions
    if statistic is None or collisions is None or not len(collisions.values):
        return (np.nan, None, 0)
    turns, value = int(collisions.window_s * frequency_hz + 1e-9), statistic(collisions)
    blocks = turns // block_length(turns) if turns > 1 else 1
    parts = [collisions.without(block, blocks) for block in range(blocks)]
    if blocks < 2 or not all(len(part.values) for part in parts):
        return (value, None, 0)
    left = np.array([statistic(part) for part in parts])
    return (value, float(np.sqrt((blocks - 1) * np.var(left / left.mean()))), blocks - 1)


def _relative(energies: np.ndarray) -> tuple[float | None, int]:
    """The relative standard error of a mean of turns and its degrees of freedom; None for fewer than two."""
    known = mean_of_turns(energies.tolist())
    return (known.error / float(energies.mean()), known.freedom) if known and energies.mean() > 0 else (None, 0)


def _over_seeds(runs: pd.DataFrame) -> pd.DataFrame:
    """Mean of every measured column over the seeds of a condition, with the errors of powers and their spread.

    NAME_power_se_W: standard error of the mean, from turns and seeds, with NAME_power_freedom degrees of freedom;
    motion: why this error may be wrong, from turns and seeds, `MOTIONS`; lasting_motions: where seeds differ, the power
    of each motion and how many seeds have it.
    """
    groups = runs.groupby(CONDITION, sort=True)
    of_a_run = [f"{name}{end}" for name in SCATTERED for end in ("", "_variance", "_freedom")]
    of_a_run = [name for name in of_a_run if name not in DESCRIPTORS]
    mean = groups.mean(numeric_only=True).drop(columns=of_a_run)
    mean.insert(0, "seeds", groups.size())
    for place, name in enumerate(OF_RULE, start=1):
        mean.insert(place, name, groups[name].first())
    mean["collisions"] = groups["collisions"].sum()
    mean["closure"] = groups["closure"].agg(lambda closures: closures.abs().max())
    known = {name: groups.apply(_scatter_of, name, include_groups=False) for name in SCATTERED}
    for name, of_groups in known.items():
        mean[f"{name}_relative_se"] = [
            np.sqrt(own.variance / n) for own, n in zip(of_groups, mean["seeds"], strict=True)
        ]
    for name in CHANNELS:
        mean[f"{name}_power_se_W"] = mean.pop(f"{name}_power_relative_se") * mean[f"{name}_power_W"]
        mean[f"{name}_power_freedom"] = [own.freedom for own in known[f"{name}_power"]]
        mean[f"{name}_power_seed_sd_W"] = groups[f"{name}_power_W"].std(ddof=1)
    differ = np.any([[own.differ for own in known[f"{name}_power"]] for name in CHANNELS], axis=0)
    for name in ("collision", "strong"):
        mean[f"{name}_frequency_seed_sd_hz"] = groups[f"{name}_frequency_hz"].std(ddof=1)
    mean["balls"] = mean["balls"].round().astype(int)
    told = ["runs_with_impacts", "stuck_runs", "independent_turns", "repeating_runs"]
    of_turns = [f"{name}_{part}" for name in CHANNELS for part in (*MEMORY, *DRIFT)]
    sums = groups[[*told, *of_turns]].sum()
    remembered = [
        independent_turns(mean["seeds"].to_numpy(), *(sums[f"{name}_{part}"].to_numpy() for part in MEMORY))
        for name in CHANNELS
    ]
    rises = [
        drifts(mean["seeds"].to_numpy(), *(sums[f"{name}_{part}"].to_numpy() for part in DRIFT)) for name in CHANNELS
    ]
    # Turns that rise or fall through all windows are not turns of one motion.
    sums["independent_turns"] = np.where(
        np.any(rises, axis=0), 0, np.min([sums["independent_turns"], *remembered], axis=0)
    )
    turns = zip(mean["seeds"], *(sums[name] for name in told), differ, strict=True)
    mean["motion"] = [", ".join(said.word for said in motion_of(*own)) for own in turns]
    lasting = groups.apply(_lasting_in_words, include_groups=False)
    mean["lasting_motions"] = [words if own else "" for words, own in zip(lasting, differ, strict=True)]
    return mean.drop(columns=[*told, *of_turns]).reset_index()


def seeds_of_motions(seeds: pd.DataFrame) -> list[np.ndarray]:
    """The places of the seeds of a condition that have one lasting motion, for each; that of most seeds first.

    seeds: rows of `run_row`.
    """
    told = seeds[["wall_power_W", "wall_power_variance"]].fillna(0.0)
    places = np.argsort(told["wall_power_W"].to_numpy(), kind="stable")
    found = lasting_motions(*told.to_numpy()[places].T)
    return sorted(np.split(places, np.cumsum([len(own) for own in found])[:-1]), key=len, reverse=True)


def _lasting_in_words(seeds: pd.DataFrame) -> str:
    """The power of each lasting motion of a condition, that of most seeds first; empty for one motion."""
    motions, parts = seeds_of_motions(seeds), []
    for places in motions if len(motions) > 1 else []:
        factor, unit = prefix_of(mean_W := float(seeds["wall_power_W"].iloc[places].mean()), "W")
        parts.append(f"{three(factor * mean_W)} {unit} in {len(places)}")
    return f"{' and '.join(parts)} of {len(seeds)} simulations" if parts else ""


def _scatter_of(seeds: pd.DataFrame, name: str) -> "Run":
    """The relative variance of one run of one of SCATTERED, estimated from the seeds of a condition.

    NaN where it is not known, such as of a quantity that is 0.
    """
    values, mean = seeds[name].to_numpy(dtype=float), float(seeds[name].mean())
    if not mean > 0:
        return Run(np.nan, 0, False)
    within = zip(seeds[f"{name}_variance"], seeds[f"{name}_freedom"], strict=True)
    known = [(variance, int(freedom)) for variance, freedom in within if freedom and np.isfinite(variance)]
    return variance_of_run((values / mean).tolist(), known) or Run(np.nan, 0, False)


def with_descriptors(table: pd.DataFrame) -> pd.DataFrame:
    """Add the computed descriptors to the measured ones, then a column NAME_se for each that has a standard error."""
    table = table.copy()
    for column in COMPUTED:
        table[column.name] = column.values(table)
    for column in COMPUTED:
        if column.standard_error:
            table[f"{column.name}_se"] = column.standard_error(table)
    return table


def tabulate_descriptors(summaries: list[dict], rule_name: str) -> pd.DataFrame:
    """Descriptors of every condition, one row each; raises ConfigError if a run lacks the counting rule."""
    runs = pd.DataFrame([run_row(summary, rule_name) for summary in summaries])
    # A number that no run has is empty, and not left out.
    unknown = runs.columns[runs.isna().all()]
    return with_descriptors(_over_seeds(runs.astype(dict.fromkeys(unknown, float))))


# Probability of taking seeds of the same motion for several motions; independent turns that suffice.
CHANCE, FEWEST_TURNS = 0.01, 8
# Seeds whose scatter says as much as that of all their turns, which does not show that a motion lasts, nor that it goes
# to and fro from turn to turn.
ENOUGH_SEEDS = 3
# Balls stick to the wall where their speed relative to the vessel is under this share of the vessel's [-].
STUCK = 0.1


# Powers of two motions differ by more than this share [-], and this number of standard errors.
APART, SURELY = 0.05, 3


class Run(NamedTuple):
    """Variance of one run about the mean of many, its degrees of freedom, and whether seeds differ beyond chance."""

    variance: float
    freedom: int
    differ: bool


def block_length(revolutions: int) -> int:
    """Length of a bootstrap block [revolutions]; at most half of `revolutions`, so that draws differ."""
    return max(1, min(int(np.ceil(revolutions ** (1 / 3) - 1e-9)), revolutions // 2))


def variance_of_run(values: Sequence[float], within: Sequence[tuple[float, int]]) -> Run | None:
    """The variance of one run, estimated from k seeds; None for a single run without an estimate.

    values: of the runs (k,). within: variance and degrees of freedom of each run whose window gives them. w is the mean
    of these variances weighted by their degrees of freedom, v in all, and b the variance of the values. The result is b
    with k - 1 degrees where b / w is beyond the F distribution's quantile 1 - CHANCE, else max(b, pooled),
    pooled = (v w + (k - 1) b) / (v + k - 1), with v of k - 1 at most from ENOUGH_SEEDS on. The mean of the runs has 1/k
    of the variance of one run.
    """
    seeds = len(values)
    between = float(np.var(values, ddof=1)) if seeds > 1 else 0.0
    inside = sum(freedom for _, freedom in within)
    squares = sum(variance * freedom for variance, freedom in within)
    freedom = inside + seeds - 1
    if freedom == 0:
        return None
    differ = False
    # Seeds that agree to the last digits of a number do not differ.
    if seeds > 1 and inside and np.ptp(values) > 1e-9 * np.max(np.abs(values)):
        # Imported here: slow to import, and most conditions have one seed.
        from millprint.estimate.quantiles import f_exceeded

        differ = between > float(f_exceeded(CHANCE, seeds - 1, inside)) * squares / inside
    if differ:
        return Run(between, seeds - 1, True)
    if inside and seeds >= ENOUGH_SEEDS:
        # The turns count for as much as the seeds.
        squares, inside = squares / inside * (seeds - 1), seeds - 1
    freedom = inside + seeds - 1
    return Run(max(between, (squares + (seeds - 1) * between) / freedom), freedom, False)


# What `independent_turns` takes of each channel.
MEMORY = ("turns", "squares", "products")


def independent_turns(seeds: np.ndarray, turns: np.ndarray, squares: np.ndarray, products: np.ndarray) -> np.ndarray:
    """The equivalent number of independent turns of conditions, from how much a turn is like the one before.

    turns, squares, products: sums over the seeds of what `_memory_of` says. r = products / squares is the correlation
    of neighbours; of n independent turns of a window it is -1/n, within 1 / sqrt(turns). Beyond chance, it is
    phi = (r + 1/n) / (1 - 3/n) without its bias (Kendall, Biometrika 41 (1954) 403), and a turn is worth
    (1 - phi) / (1 + phi) of an independent one. The blocks of `mean_of_turns`, eight at least, cannot show this.
    """
    # Imported here: slow to import, and what only reads tables does not need it.
    from millprint.estimate.quantiles import normal_exceeded

    n = np.maximum(turns / np.maximum(seeds, 1), 1)
    above = np.divide(products, squares, out=np.zeros(len(n)), where=squares > 0) + 1 / n
    phi = np.clip(above / np.maximum(1 - 3 / n, 1e-9), 0, 1)
    beyond = above > normal_exceeded(CHANCE) / np.sqrt(np.maximum(turns, 1))
    return np.where(beyond, turns * (1 - phi) / (1 + phi), turns)


# What `drifts` takes of each channel; and the least drift of a window that counts [-].
DRIFT, DRIFTED = ("drift", "drift_variance", "drift_freedom"), 0.1


def drifts(seeds: np.ndarray, change: np.ndarray, variance: np.ndarray, freedom: np.ndarray) -> np.ndarray:
    """Whether a power rises or falls through the windows of conditions, by over DRIFTED and beyond chance.

    seeds: their number; change, variance, freedom: sums over them of what `_drift_of` says.
    """
    # Imported here, as in `independent_turns`.
    from millprint.estimate.quantiles import student_exceeded

    beyond = student_exceeded(CHANCE / 2, np.maximum(freedom, 1)) * np.sqrt(variance)
    return (freedom > 0) & (np.abs(change) > np.maximum(DRIFTED * seeds, beyond))


def lasting_motions(powers_W: np.ndarray, variances: np.ndarray) -> list[np.ndarray]:
    """The powers of seeds, in rising order (k,), of which each array holds those of one motion.

    Neighbours are of two motions where they differ by more than APART, and by more than SURELY standard errors of their
    turns, variances (k,), relative.
    """
    steps, errors = np.diff(np.log(powers_W)), np.sqrt(variances[1:] + variances[:-1])
    return np.split(powers_W, np.flatnonzero((steps > APART) & (steps > SURELY * errors)) + 1)


class Motion(NamedTuple):
    """A reason why a standard error may be wrong: a word, and what it means with what to do."""

    word: str
    meaning: str


MOTIONS: Mapping[str, Motion] = {
    "no_impacts": Motion(
        "no impacts",
        "all balls move with the wall or slide on it, as one layer that goes round or rests, and nothing hits; curves "
        "leave it out, and nothing is known from there to the next fill ratio with impacts: take a higher one, or "
        "another speed",
    ),
    "stuck": Motion(
        "stuck",
        f"all balls of a simulation move with the wall, within {100 * STUCK:g} % of its speed, as where powder sticks "
        "or a drum turns too fast, and hardly anything is milled in it: try another speed, more balls, or less or "
        "drier powder",
    ),
    "few_turns": Motion(
        "few turns",
        f"fewer than {FEWEST_TURNS} independent turns were recorded, or a power drifts through all of them, so that "
        "mean and scatter of a run are hardly known: record a longer window, and discard more turns (discard_turns)",
    ),
    "repeats": Motion(
        "repeats",
        "the motion is locked to the drive and repeats itself, so that turns do not show other lasting motions: "
        "simulate more seeds",
    ),
    "seeds_differ": Motion(
        "seeds differ",
        "seeds differ by more than their turns explain, as where several motions last: simulate more seeds, and take "
        "the mean as one over these motions",
    ),
}


def motion_of(seeds: int, impacts: int, stuck: int, independent: float, repeating: int, differ: bool) -> list[Motion]:
    """Why the standard errors of a condition may be wrong, from its turns and seeds: some of MOTIONS.

    seeds: their number; impacts: of them, whose balls hit anything; stuck: whose balls move with the wall; independent:
    turns of all seeds; repeating: seeds whose motion repeats; differ: whether seeds differ beyond chance. What holds
    for some of the seeds has their number with its word.
    """
    holding = {
        "no_impacts": seeds * (impacts == 0),
        "stuck": stuck,
        "few_turns": seeds * (independent < FEWEST_TURNS),
        "repeats": repeating,
        "seeds_differ": seeds * differ,
    }
    limits = {name: "" if number == seeds else f" in {number} of {seeds}" for name, number in holding.items()}
    return [own._replace(word=f"{own.word}{limits[name]}") for name, own in MOTIONS.items() if holding[name]]


def motions_in(told: str) -> dict[str, Motion]:
    """The motions in a cell of the column `motion`, by their names in MOTIONS, each with the word that it has there."""
    words = told.split(", ")
    return {
        name: own._replace(word=word)
        for name, own in MOTIONS.items()
        for word in words
        if word == own.word or word.startswith(f"{own.word} in ")
    }
