"""The scaling of chapter 3: curves averaged over speeds and balls, their exponents by regression, and its inverse."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.sweep import ball_count
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import OPEN, judge
from millprint.fingerprint.condition_search import descriptors_shown
from millprint.fingerprint.descriptors import CHARGE, CONDITION, as_built, condition_of
from millprint.fingerprint.mill_collapse import SUPPOSED, with_power_per_ball
from millprint.observables.condition import Condition, Quantity, specific_frequency
from millprint.observables.definitions import (
    CURVES,
    DESCRIPTOR_SETS,
    SCALED_BY,
    TARGET_DESCRIPTORS,
    descriptors_of,
    scaled_quantities,
)

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
    """The conditions of one mill and contact set; raises ConfigError if there are none."""
    chosen = descriptors[(descriptors["mill"] == mill) & (descriptors["contact"] == contact)]
    if chosen.empty:
        raise ConfigError(f"sweeps: no simulation of mill {mill} with contact set {contact}; add one to a sweep")
    return chosen


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
    factor = universal_factor(scaled["effective_restitution"])
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
KEPT = {
    "both energies": {"normal_energy_J": 1.0, "tangential_energy_J": 1.0},
    "normal energy": {"normal_energy_J": 1.0},
    "tangential energy": {"tangential_energy_J": 1.0},
    "specific frequency": {"specific_frequency_hz": 1.0},
    "all three": dict.fromkeys(DESCRIPTOR_SETS["per_collision"], 1.0),
    "both weighted energies": dict.fromkeys(DESCRIPTOR_SETS["weighted"][:2], 1.0),
    "weighted normal energy": {"weighted_normal_energy_J": 1.0},
    "weighted tangential energy": {"weighted_tangential_energy_J": 1.0},
    "both weighted frequencies": dict.fromkeys(DESCRIPTOR_SETS["weighted"][2:], 1.0),
    "all weighted": dict.fromkeys(DESCRIPTOR_SETS["weighted"], 1.0),
}


def nearest_speed(
    target: dict[str, float], basic: Mapping[str, float], condition: Condition[float], weights: dict[str, float]
) -> Condition[float]:
    """The condition at the speed whose descriptors come nearest to `target`; the given speed is ignored.

    basic: Pn, Pt and f at its fill ratio, and En_star, Et_star and f90 for weighted descriptors [-]. Least squares of
    the weighted log residuals: each descriptor is c omega^p with p from SPEED_POWERS, so log(omega) = sum w p
    log(target / c) / sum w p^2. That is exact where one descriptor, or descriptors that agree, have a weight. Raises
    ValueError if every weight is zero.
    """
    unit = descriptors_of(replace(condition, speed_hz=1.0), scaled_quantities(basic))
    weighing = {name: power for name, power in SPEED_POWERS.items() if weights.get(name, 0.0) > 0}
    if not weighing:
        raise ValueError("at least one descriptor must have a weight over 0")
    below = sum(weights[name] * power**2 for name, power in weighing.items())
    above = sum(weights[name] * power * np.log(target[name] / unit[name]) for name, power in weighing.items())
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
    for kept, weights in KEPT.items():
        if not set(weights) <= set(target):
            continue
        nearest = nearest_speed(target, basic, condition, weights)
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


def universal_factor(effective: Quantity) -> Quantity:
    """Factor (1 - eps)^(1/2) of Eqs 3.31 and 3.32 [-], eps the effective restitution of Eq. 3.30."""
    return np.sqrt(1.0 - effective)
