"""Master curves: scaling with speed, and whether the curves collapse (thesis chapter 3)."""

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

from millprint.config.sweep import ball_count
from millprint.dem.convergence import convergence_table
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import OPEN, judge
from millprint.fingerprint.condition_search import descriptors_shown
from millprint.fingerprint.descriptors import (
    CHARGE,
    CONDITION,
    NOTHING,
    as_built,
    block_length,
    condition_of,
    tabulate_descriptors,
)
from millprint.fingerprint.mill_collapse import SUPPOSED, with_power_per_ball
from millprint.observables.condition import Condition, specific_frequency
from millprint.observables.counted_collisions import CHANNELS, PARTS
from millprint.observables.definitions import (
    CURVES,
    DESCRIPTOR_SETS,
    SCALED_BY,
    TARGET_DESCRIPTORS,
    WEIGHTED,
    descriptors_of,
    scaled_quantities,
)
from millprint.run.job import progress
from millprint.thesis.regimes import tabulate_cycles

# Variable of the scaling -> its symbol in Eqs 3.28 and 3.29.
SYMBOLS = {"density_kg_m3": "rho", "speed_hz": "omega", "amplitude_m": "A", "ball_diameter_m": "d"}
# Eqs 3.31 and 3.32: a scaled power or frequency times (1 - eps)^(1/2) is the same for every contact set.
FACTOR = "1 - eps"
UNIVERSAL = {"Pn": -0.5, "Pt": -0.5, "P": -0.5, "f": -0.5}
# What compared runs always share. A charge of several sizes does not count as another ball size.
ALIKE = ["mill", CHARGE, "fill_ratio"]
EXPONENT_COLUMNS = [
    *("contact", "quantity", "counting_rule", "variable", "supposed", "exponent", "lower", "upper"),
    *("verdict", "levels", "conditions", "remark"),
]


# Column of a table -> key of a summary's count, in the order of a sorted table.
RULE_COLUMNS = {
    "collisions_by": "by",
    "collision_gap_turns": "gap_turns",
    "collision_peak_force_min_N": "peak_force_min_N",
    "collision_duration_min_s": "duration_min_s",
    "counting_rule": "name",
}


def tabulate_counting_rules(summaries: list[dict]) -> pd.DataFrame:
    """Collision frequency and energies per collision of every condition under every recorded counting rule.

    ball_ball_share: fraction of the counted collisions that are between balls; dropped_share: fraction of all
    collisions that a threshold of the rule drops. Energies of a rule that counts none are empty.
    """
    rows = []
    for summary in summaries:
        for rule in summary["collisions"]:
            frequency = rule["frequency_hz"]
            rows.append(
                {
                    **condition_of(summary),
                    **{column: rule[key] for column, key in RULE_COLUMNS.items()},
                    "speed_hz": summary["frequency_hz"],
                    "ball_diameter_m": summary["ball_diameter_m"],
                    "specific_frequency_hz": rule["specific_frequency_hz"],
                    "collisions_of_a_ball_hz": rule["collisions_of_a_ball_hz"],
                    "collision_frequency_hz": frequency,
                    "f": specific_frequency(frequency, summary["balls"], summary["frequency_hz"]),
                    "normal_energy_J": rule["mean_normal_J"] if frequency else np.nan,
                    "tangential_energy_J": rule["mean_tangential_J"] if frequency else np.nan,
                    "ball_ball_share": rule["shares"]["ball_ball"]["count"],
                    "dropped_share": rule["dropped"]["count"],
                }
            )
    return pd.DataFrame(rows).groupby([*CONDITION, *RULE_COLUMNS], sort=True).mean().reset_index()


def conditions_of(descriptors: pd.DataFrame, mill: str, contact: str) -> pd.DataFrame:
    """The conditions of one mill and contact set."""
    return descriptors[(descriptors["mill"] == mill) & (descriptors["contact"] == contact)]


def _pooled_spread(groups: list[np.ndarray]) -> float:
    """Relative spread of a quantity between conditions, over all fill ratios that have several; NaN if none has."""
    squares, freedom = 0.0, 0
    for values in groups:
        squares += float(((values / values.mean() - 1.0) ** 2).sum())
        freedom += len(values) - 1
    return float(np.sqrt(squares / freedom)) if freedom else float("nan")


def average_curves(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Mean and spread of every quantity at each simulated fill ratio (thesis Figs 3.11, 3.12).

    `Q_lower` and `Q_upper` are the mean minus and plus one standard deviation between speeds and ball sizes. A fill
    ratio with one condition takes the relative deviation pooled over the other fill ratios or, if no fill ratio has
    two conditions, the run's own standard error.
    """
    by_fill = sorted(descriptors.groupby("fill_ratio").indices.items())
    rows = [{"fill_ratio": fill} for fill, _ in by_fill]
    for quantity in CURVES:
        values = descriptors[quantity].to_numpy()
        groups = [values[at] for _, at in by_fill]
        for row, group, (_, at) in zip(rows, groups, by_fill, strict=True):
            mean = group.mean()
            spread = group.std(ddof=1) if len(group) > 1 else mean * _pooled_spread(groups)
            if np.isnan(spread):
                spread = descriptors[f"{quantity}_se"].iloc[at[0]]
            row |= {quantity: mean, f"{quantity}_lower": mean - spread, f"{quantity}_upper": mean + spread}
    return pd.DataFrame([row | {"conditions": len(at)} for row, (_, at) in zip(rows, by_fill, strict=True)])


def at_shared_fills(descriptors: pd.DataFrame) -> pd.DataFrame:
    """The conditions at the fill ratios that every contact set has, where sets can be compared or averaged."""
    sets = descriptors.groupby("fill_ratio")["contact"].nunique()
    return descriptors[descriptors["fill_ratio"].isin(sets[sets == descriptors["contact"].nunique()].index)]


def universal_descriptors(descriptors: pd.DataFrame) -> pd.DataFrame:
    """Descriptors with powers and frequency times (1 - eps)^(1/2) (Eqs 3.31, 3.32); energies and ratio stay."""
    scaled = descriptors.copy()
    factor = np.sqrt(1.0 - scaled["effective_restitution"])
    rates = [quantity for name, quantity in SCALED_BY.items() if name.endswith("_hz")]
    for quantity in ("Pn", "Pt", "P", *rates):
        scaled[quantity] *= factor
        scaled[f"{quantity}_se"] *= factor
    return scaled


def _exponent(
    runs: pd.DataFrame, quantity: str, variable: str, supposed: float, alike: list[str], probability: float
) -> dict:
    """The exponent of `variable` over groups of otherwise equal runs: log y = c(group) + p log x.

    Ordinary least squares with a constant for each group that has at least two levels, and Student's interval. The
    interval grows with the differences between groups: an exponent that holds only at some fill ratios is uncertain.
    """
    # Imported here: slow to import, and the claims import this module.
    from statsmodels.regression.linear_model import OLS

    levels = runs.groupby(alike, sort=True)[variable].transform("nunique")
    compared = runs[levels > 1]
    row = {
        "quantity": quantity,
        "variable": SYMBOLS.get(variable, variable),
        "supposed": supposed,
        "levels": compared[variable].nunique(),
        "conditions": len(compared),
        "verdict": OPEN,
    }
    if compared.empty:
        return row | {"remark": "not varied with all else kept"}
    constants = pd.get_dummies(compared.groupby(alike, sort=True).ngroup(), dtype=float)
    if len(compared) - constants.shape[1] < 2:
        return row | {"remark": "too few conditions for an interval"}
    design = constants.assign(exponent=np.log(compared[variable]))
    fit = OLS(np.log(compared[quantity]).to_numpy(), design.to_numpy()).fit()
    lower, upper = fit.conf_int(alpha=1.0 - probability)[-1]
    found = Estimate(fit.params[-1], "-", repeats=Interval(lower, upper))
    return row | {
        "exponent": fit.params[-1],
        "lower": lower,
        "upper": upper,
        "verdict": judge(found, Estimate(supposed, "-")).word,
        "remark": f"{constants.shape[1]} groups alike in all else",
    }


def _exponents(
    runs: pd.DataFrame, quantity: str, supposed: Mapping[str, float], probability: float, rule: str
) -> list[dict]:
    """The exponents of all variables in a quantity of one contact set."""
    rows = []
    for name, symbol in SYMBOLS.items():
        alike = [*ALIKE, *(other for other in SYMBOLS if other != name)]
        row = _exponent(runs, quantity, name, supposed[symbol], alike, probability)
        rows.append(row | {"contact": runs["contact"].iloc[0], "counting_rule": rule})
    return rows


def fit_exponents(descriptors: pd.DataFrame, counting_rules: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Exponents of rho, omega, A and d with confidence intervals, for each contact set and quantity.

    The compared runs differ in only one variable: they share fill ratio, mill, charge and the other three variables.
    The specific frequency is also given by every counting rule without thresholds. Last, over all contact sets, the
    exponent of 1 - eps in the scaled quantities (Eqs 3.31, 3.32 suppose -1/2), from runs that differ only in the
    contact set.
    """
    table = with_power_per_ball(descriptors)
    rule = table["counting_rule"].iloc[0]
    rows = []
    for _, runs in table.groupby("contact", sort=True):
        for quantity, supposed in SUPPOSED.items():
            rows += _exponents(runs, quantity, supposed, probability, rule)
    whole = (counting_rules["collision_peak_force_min_N"] == 0) & (counting_rules["collision_duration_min_s"] == 0)
    others = counting_rules[whole & (counting_rules["counting_rule"] != rule)]
    for (_, name), runs in others.groupby(["contact", "counting_rule"], sort=True):
        rows += _exponents(runs, "specific_frequency_hz", SUPPOSED["specific_frequency_hz"], probability, name)
    built = as_built(descriptors)
    built = built.assign(**{FACTOR: 1.0 - built["effective_restitution"]})
    for quantity, exponent in UNIVERSAL.items():
        row = _exponent(built, quantity, FACTOR, exponent, [*ALIKE, *SYMBOLS], probability)
        rows.append(row | {"contact": "all", "counting_rule": rule})
    return pd.DataFrame(rows, columns=EXPONENT_COLUMNS)


# Descriptor -> the exponent of the mill's speed in it, at a fixed fill ratio and ball (Eqs 3.28, 3.29).
SPEED_POWERS = {name: 2 if name.endswith("_J") else 1 for name in TARGET_DESCRIPTORS}

# Descriptors to keep: both energies as in the thesis, each descriptor by itself, or all at once.
KEPT: dict[str, Sequence[str]] = {
    "both energies": ("normal_energy_J", "tangential_energy_J"),
    "normal energy": ("normal_energy_J",),
    "tangential energy": ("tangential_energy_J",),
    "specific frequency": ("specific_frequency_hz",),
    "all three": DESCRIPTOR_SETS["per_collision"],
    "both weighted energies": DESCRIPTOR_SETS["weighted"][:2],
    "weighted normal energy": ("weighted_normal_energy_J",),
    "weighted tangential energy": ("weighted_tangential_energy_J",),
    "both weighted frequencies": DESCRIPTOR_SETS["weighted"][2:],
    "all weighted": DESCRIPTOR_SETS["weighted"],
}


def nearest_speed(
    target: dict[str, float], basic: Mapping[str, float], condition: Condition[float], kept: Sequence[str]
) -> Condition[float]:
    """The condition at the speed whose descriptors `kept` come nearest to `target`; the given speed is ignored.

    basic: Pn, Pt and f at its fill ratio, and En_star, Et_star and f90 for weighted descriptors [-]. Least squares of
    the log residuals: each descriptor is c omega^p with p from SPEED_POWERS, so log(omega) = sum p log(target / c) /
    sum p^2. That is exact where one descriptor is kept, or descriptors that agree.
    """
    unit = descriptors_of(replace(condition, speed_hz=1.0), scaled_quantities(basic))
    below = sum(SPEED_POWERS[name] ** 2 for name in kept)
    above = sum(SPEED_POWERS[name] * np.log(target[name] / unit[name]) for name in kept)
    return replace(condition, speed_hz=float(np.exp(above / below)))


def residuals(found: dict[str, float], target: dict[str, float]) -> dict[str, float]:
    """Relative deviation of each shown descriptor from its target [%]; NaN for one that the target does not have."""
    return {
        f"{name}_residual_percent": 100.0 * (found[name] / target[name] - 1.0) if name in target else np.nan
        for name in descriptors_shown(target)
    }


def invert_speed(
    target: dict[str, float], basic: Mapping[str, float], condition: Condition[float], volume_m3: float
) -> pd.DataFrame:
    """Speeds that keep the target at a fixed fill ratio and ball size, a row for each choice of what can be kept.

    The arguments are as in `nearest_speed`, and the volume of the jar. The residuals show what is lost: energies
    grow with omega^2 and frequencies with omega, so one speed can keep all of them only where the scale of the
    balls has not changed.
    """
    rows = []
    for kept, names in KEPT.items():
        if not set(names) <= set(target):
            continue
        nearest = nearest_speed(target, basic, condition, names)
        found = descriptors_of(nearest, scaled_quantities(basic))
        found = {name: found[name] for name in descriptors_shown(target)}
        rows.append(
            {
                "kept": kept,
                "fill_ratio": nearest.fill_ratio,
                "ball_diameter_mm": nearest.ball_diameter_m * 1e3,
                "balls": ball_count(nearest.fill_ratio, volume_m3, nearest.ball_diameter_m),
                "speed_rpm": nearest.speed_hz * 60.0,
                **found,
                **residuals(found, target),
            }
        )
    return pd.DataFrame(rows)


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


# What is known of each revolution: energies, and sums of squares of the energies of contacts.
OF_TURN = [*(f"{name}_J" for name in PARTS), *(f"{name}_square_J2" for name in CHANNELS)]


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
    """A run with these values of its revolutions (n, OF_TURN) in place of its own; its wall power goes with its parts.

    What is always zero, such as shear of balls that bounce straight up, stays so.
    """
    ratios, before = np.ones(len(OF_TURN)), run["power_W"]
    if len(own):
        means = own.mean(axis=0)
        np.divide(energies.mean(axis=0), means, out=ratios, where=means != 0)
    factor, squares = dict(zip(PARTS, ratios, strict=False)), dict(zip(CHANNELS, ratios[len(PARTS) :], strict=True))
    parts = {name: before[name] * factor[name] for name in PARTS}
    power = before | parts | {"wall": before["wall"] * sum(parts.values()) / sum(before[name] for name in PARTS)}
    revolutions = run["per_revolution"] | {key: energies[:, i].tolist() for i, key in enumerate(OF_TURN)}
    weighted = dict(run["weighted"])
    for name in CHANNELS:
        # E* goes with squares over energy, its rate with energy over E*.
        change = squares[name] / factor[name]
        energy, rate = (weighted[name][key] for key in ("energy_J", "specific_frequency_hz"))
        own_values = {"energy_J": energy * change, "specific_frequency_hz": rate * factor[name] / change}
        weighted[name] = weighted[name] | own_values
    chance, rules = rng.standard_normal(), []
    for rule in run["collisions"]:
        count = rule["count"]
        # A number of collisions is not negative.
        rate = np.exp(chance * np.sqrt(spread.get(rule["name"], 1.0) / count)) if count else 1.0
        names = ("count", "frequency_hz", "specific_frequency_hz", "collisions_of_a_ball_hz")
        changed = {name: rule[name] * rate for name in names}
        means = {f"mean_{name}_J": rule[f"mean_{name}_J"] * factor[name] / rate for name in CHANNELS}
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
