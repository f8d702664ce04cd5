"""Whether curves of all balls and mills fall on one, and curves drawn again from their windows."""

import json
from collections import defaultdict
from typing import Any

import numpy as np
import pandas as pd

from millprint.dem.convergence import convergence_table
from millprint.fingerprint.descriptors import NOTHING, as_built, block_length, tabulate_descriptors
from millprint.fingerprint.mill_collapse import with_power_per_ball
from millprint.observables.definitions import SCALED_BY, WEIGHTED
from millprint.run.progress import progress
from millprint.thesis.curves.cycles import tabulate_cycles
from millprint.thesis.curves.scaling import at_shared_fills, average_curves, conditions_of, universal_descriptors

# Scaled quantity -> the column that it scales; none for the ratio, which has no unit.
DIMENSIONAL = {
    "Pn": "normal_power_per_ball_W",
    "Pt": "tangential_power_per_ball_W",
    "f": "specific_frequency_hz",
    "ratio": None,
    **{quantity: name for name, quantity in SCALED_BY.items() if quantity in WEIGHTED},
}
COLLAPSE_COLUMNS = [
    *("scope", "compared", "quantity", "fill_ratio", "conditions"),
    *("spread_dimensional", "spread_scaled", "spread_universal"),
]
# What differs between the compared conditions, by what a sweep varied.
MACHINE = "speed and ball size"


def _spread(values: np.ndarray) -> float:
    return float(values.std(ddof=1) / values.mean())


def _rows(descriptors: pd.DataFrame, scope: str, compared: str = MACHINE) -> list[tuple]:
    universal, descriptors = universal_descriptors(descriptors), with_power_per_ball(descriptors)
    # As arrays: the claims are computed from hundreds of such tables, for their intervals.
    before = {name: descriptors[column].to_numpy() for name, column in DIMENSIONAL.items() if column}
    after = {name: (descriptors[name].to_numpy(), universal[name].to_numpy()) for name in DIMENSIONAL}
    rows = []
    for fill, at in sorted(descriptors.groupby("fill_ratio").indices.items()):
        for quantity in DIMENSIONAL if len(at) > 1 else ():
            dimensional = _spread(before[quantity][at]) if quantity in before else np.nan
            spreads = [_spread(values[at]) for values in after[quantity]]
            rows.append((scope, compared, quantity, fill, len(at), dimensional, *spreads))
    return rows


def _with_reference(runs: pd.DataFrame, varied: str) -> pd.DataFrame:
    """The conditions of a sweep over amplitude or density, and the otherwise equal ones as built."""
    alike = ["ball_diameter_mm", "fill_ratio", "speed_rpm"]
    swept = runs[runs["varied"] == varied]
    built = as_built(runs)
    return pd.concat([swept, built.merge(swept[alike].drop_duplicates(), on=alike)], ignore_index=True)


def tabulate_collapse(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Standard deviation over mean at each fill ratio with two or more conditions, for each contact set and for all.

    spread_dimensional: of power [W] or frequency [1/s] over the balls, or of an energy [J], before any scaling;
    spread_scaled: after Eqs 3.28 and 3.29; spread_universal: after Eqs 3.31 and 3.32. `scope` is a contact set, or
    `universal` for all together, which is left out unless there are at least two. `compared` says what differs between
    the conditions: speed and ball size, or what a sweep varied besides (amplitude, density).
    """
    rows = []
    contacts = sorted(descriptors["contact"].unique())
    for contact in contacts:
        runs = descriptors[descriptors["contact"] == contact]
        rows += _rows(as_built(runs), contact)
        for varied in sorted(set(runs["varied"]) - {NOTHING}):
            rows += _rows(_with_reference(runs, varied), contact, varied)
    if len(contacts) > 1:
        rows += _rows(at_shared_fills(as_built(descriptors)), "universal")
    return pd.DataFrame(rows, columns=COLLAPSE_COLUMNS)


CHANNELS = ("normal", "tangential")
# What is known of each revolution: energies, and sums of squares of the energies of contacts.
OF_TURN = [*(f"{name}_J" for name in CHANNELS), *(f"{name}_square_J2" for name in CHANNELS)]


def draw_blocks(series: list[np.ndarray], length: int, rng: np.random.Generator) -> np.ndarray:
    """`length` rows of blocks drawn from several series (n, columns), each taken as a circle."""
    block = block_length(min(len(values) for values in series))
    sizes = np.array([len(values) for values in series])
    starts = rng.integers(sizes.sum(), size=-(-length // block))
    which = np.searchsorted(np.cumsum(sizes), starts, side="right")
    first = starts - (np.cumsum(sizes) - sizes)[which]
    parts = [series[run][(at + np.arange(block)) % sizes[run]] for run, at in zip(which, first, strict=True)]
    return np.concatenate(parts)[:length]


def dispersions(groups: list[list[dict]]) -> dict[str, float]:
    """Variance over mean of the number of collisions between seeds, by counting rule; at least 1 (independent).

    groups: the runs of each condition; conditions with one seed are left out. Pooled over the conditions.
    """
    squares: dict[str, float] = defaultdict(float)
    freedom = 0
    for runs in groups:
        freedom += len(runs) - 1
        for place, rule in enumerate(runs[0]["collisions"]):
            count = np.array([run["collisions"][place]["count"] for run in runs], dtype=float)
            rate = np.array([run["collisions"][place]["frequency_hz"] for run in runs], dtype=float)
            if len(runs) > 1 and rate.mean() > 0:
                squares[rule["name"]] += float(count.mean() * ((rate / rate.mean() - 1) ** 2).sum())
    return {name: max(1.0, value / freedom) for name, value in squares.items()} if freedom else {}


def same_conditions(summaries: list[dict]) -> list[list[dict]]:
    """The runs of each condition: they differ only in their seed, and in a step that had to be shortened."""
    groups: dict[str, list[dict]] = defaultdict(list)
    for summary in summaries:
        named = {"mill": summary["mill"], "contact": summary["contact"]}
        own = summary["case"] | named | {"seed": None, "rayleigh_fraction": None}
        groups[json.dumps(own, sort_keys=True)].append(summary)
    return list(groups.values())


def redraw(summaries: list[dict], rng: np.random.Generator) -> list[dict]:
    """The summaries of runs, with powers, energies per revolution and numbers of collisions drawn again.

    A run with fewer than two whole revolutions keeps its powers.
    """
    groups = same_conditions(summaries)
    spread, drawn = dispersions(groups), {}
    for runs in groups:
        series = [np.column_stack([run["per_revolution"].get(key, []) for key in OF_TURN]) for run in runs]
        for run, own in zip(runs, series, strict=True):
            enough = min(len(values) for values in series) >= 2
            drawn[id(run)] = _with(run, own, draw_blocks(series, len(own), rng) if enough else own, spread, rng)
    return [drawn[id(summary)] for summary in summaries]


def draw_tables(
    summaries: list[dict], of_modulus: list[dict], draws: int, seed: int, **settings: Any
) -> list[dict[str, pd.DataFrame]]:
    """A number of draws of `redrawn_tables`, with the settings of that function."""
    rng, found = np.random.default_rng(seed), []
    with progress(draws, None, "draw") as bar:
        for _ in range(draws):
            found.append(redrawn_tables(summaries, of_modulus, rng, **settings))
            bar.update()
    return found


def _with(run: dict, own: np.ndarray, energies: np.ndarray, spread: dict[str, float], rng: np.random.Generator) -> dict:
    """A run with these values of its revolutions (n, OF_TURN) in place of its own."""
    factor = energies.mean(axis=0) / own.mean(axis=0) if len(own) else np.ones(len(OF_TURN))
    power = run["power_W"] | {name: run["power_W"][name] * factor[i] for i, name in enumerate(CHANNELS)}
    revolutions = run["per_revolution"] | {key: energies[:, i].tolist() for i, key in enumerate(OF_TURN)}
    weighted = dict(run["weighted"])
    for i, name in enumerate(CHANNELS):
        # E* goes with squares over energy, its rate with energy over E*.
        change = factor[len(CHANNELS) + i] / factor[i]
        energy, rate = (weighted[name][key] for key in ("energy_J", "specific_frequency_hz"))
        own_values = {"energy_J": energy * change, "specific_frequency_hz": rate * factor[i] / change}
        weighted[name] = weighted[name] | own_values
    chance, rules = rng.standard_normal(), []
    for rule in run["collisions"]:
        count = rule["count"]
        # A number of collisions is not negative.
        rate = np.exp(chance * np.sqrt(spread.get(rule["name"], 1.0) / count)) if count else 1.0
        names = ("count", "frequency_hz", "specific_frequency_hz", "collisions_of_a_ball_hz")
        changed = {name: rule[name] * rate for name in names}
        means = {f"mean_{name}_J": rule[f"mean_{name}_J"] * factor[i] / rate for i, name in enumerate(CHANNELS)}
        rules.append(rule | changed | means)
    return run | {"power_W": power, "per_revolution": revolutions, "weighted": weighted, "collisions": rules}


def tables_of(summaries: list[dict], mill: str, contacts: list[str], counting_rule: str) -> dict[str, pd.DataFrame]:
    """The tables of chapter 3 that follow only from the described runs, by path from the results folder."""
    descriptors = tabulate_descriptors(summaries, counting_rule)
    own = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    tables = {
        "fingerprint/descriptors.tsv": descriptors,
        "fingerprint/cycles.tsv": tabulate_cycles(summaries),
        "fingerprint/collapse.tsv": tabulate_collapse(own),
    }
    for contact in contacts:
        means = average_curves(as_built(conditions_of(descriptors, mill, contact)))
        tables[f"fingerprint/means_{contact}.tsv"] = means
    return tables


def redrawn_tables(
    summaries: list[dict],
    of_modulus: list[dict],
    rng: np.random.Generator,
    mill: str,
    contacts: list[str],
    counting_rule: str,
    further_rules: list[str],
) -> dict[str, pd.DataFrame]:
    """One draw of the tables of chapter 3 that follow only from simulations, by path from the results folder.

    summaries: of the described runs; of_modulus: of the runs with several Young's moduli; the rest as in the rules that
    write these tables.
    """
    tables = tables_of(redraw(summaries, rng), mill, contacts, counting_rule)
    if of_modulus:
        table = convergence_table(redraw(of_modulus, rng), "young_modulus_gpa", counting_rule, further_rules)
        tables["convergence/modulus.tsv"] = table
    return tables
