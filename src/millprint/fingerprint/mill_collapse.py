"""Whether the curves of a mill collapse: the spread between its conditions before and after scaling."""

import numpy as np
import pandas as pd

from millprint.estimate.estimates import Estimate
from millprint.estimate.judge import OPEN, Allowed, Verdict, judge
from millprint.fingerprint.descriptors import CHANNELS, CHARGE, as_built
from millprint.observables.condition import SCALES
from millprint.observables.definitions import PREDICTED, SCALED_BY

# Exponents in the equations, for quantities of one ball or one collision.
SUPPOSED = {
    **dict.fromkeys(
        ("normal_power_per_ball_W", "tangential_power_per_ball_W", "power_per_ball_W"), SCALES["power"].exponents
    ),
    **{name: SCALES[PREDICTED[name].scale].exponents for name in SCALED_BY},
}
# Of all that is dissipated and supplied; the thesis has normal and tangential only.
WALL_POWER = "wall_power_per_ball_W"
# Quantities per ball or per collision -> short name in the table of all mills; empty if not in it.
COLLAPSED = {
    WALL_POWER: "power",
    "normal_power_per_ball_W": "normal",
    "tangential_power_per_ball_W": "tangential",
    **dict.fromkeys(SCALED_BY, ""),
    "weighted_normal_energy_J": "weighted_energy",
    "weighted_normal_frequency_hz": "weighted_frequency",
    "specific_frequency_hz": "frequency",
}
VARIED = {"omega": "speed_hz", "d": "ball_diameter_m"}
# Curves collapse if the scaled power spreads by no more than this, in logarithms [-].
COLLAPSE_MAX = 0.2
UNKNOWN = Verdict(OPEN, "no fill ratio has two speeds or two sizes")
NOTHING_THERE = Verdict(OPEN, "it is 0 at some conditions")
BY_LAW, BY_OWN = "collapses by the scaling law", "collapses by exponents of its own"
BY_NONE = "collapses by no powers of speed and ball size"


def with_power_per_ball(descriptors: pd.DataFrame) -> pd.DataFrame:
    """The descriptors with powers per ball [W]: normal, tangential, their sum as in the thesis, and of the walls."""
    normal, tangential = (descriptors[f"{channel}_power_W"] / descriptors["balls"] for channel in CHANNELS)
    of_walls = descriptors["wall_power_W"] / descriptors["balls"]
    return descriptors.assign(
        normal_power_per_ball_W=normal, tangential_power_per_ball_W=tangential, power_per_ball_W=normal + tangential
    ).assign(**{WALL_POWER: of_walls})


def _about_means(values: np.ndarray, constants: np.ndarray) -> np.ndarray:
    """Values (n,) less the mean of their group; constants (n, groups): 1 for the group of the row."""
    return values - constants @ np.linalg.lstsq(constants, values, rcond=None)[0]


def _spread(logs: np.ndarray, constants: np.ndarray) -> float:
    """Standard deviation of logarithms about the mean of each fill ratio; constants (n, fills): 1 for the row's.

    NaN where no fill ratio has two conditions.
    """
    if not len(logs):
        return float("nan")
    rest = _about_means(logs, constants)
    return float(np.sqrt((rest**2).sum() / (len(logs) - constants.shape[1])))


def _own(logs: np.ndarray, constants: np.ndarray, varied: dict[str, np.ndarray], probability: float) -> dict:
    """Exponents by least squares over all fill ratios, with Student's intervals, and the spread that is left."""
    # A variable that changes only between charges cannot be fitted.
    names = [name for name, values in varied.items() if len(values) and np.ptp(_about_means(values, constants)) > 1e-9]
    empty = {f"{name}{end}": np.nan for name in varied for end in ("", "_lower", "_upper")}
    design = np.column_stack([constants, *(varied[name] for name in names)])
    if not names or len(logs) <= design.shape[1]:
        return empty | {"spread_own": np.nan}
    # Imported here: slow to import, and the claims import this module.
    from statsmodels.regression.linear_model import OLS

    fit = OLS(logs, design).fit()
    intervals = fit.conf_int(alpha=1 - probability)
    found = {"spread_own": float(np.sqrt(fit.mse_resid))}
    for place, name in enumerate(names, start=constants.shape[1]):
        found |= {name: fit.params[place], f"{name}_lower": intervals[place, 0], f"{name}_upper": intervals[place, 1]}
    return empty | found


def judge_collapse(thesis: float, own: float) -> Verdict:
    """Whether the thesis's scaling leaves a spread [-] of at most COLLAPSE_MAX, and else, whether its own does."""
    if np.isnan(thesis):
        return UNKNOWN
    by_law, by_own = (judge(Estimate(spread, "-"), Allowed(upper=COLLAPSE_MAX)) for spread in (thesis, own))
    return by_law._replace(reason=BY_LAW if by_law.agrees else BY_OWN if by_own.agrees else BY_NONE)


def tabulate_mill_collapse(descriptors: pd.DataFrame, probability: float) -> pd.DataFrame:
    """The spread between speeds and ball sizes of one mill and contact set, a row for each quantity.

    Each spread is a standard deviation of log y about the mean of a fill ratio, pooled over the fill ratios, so that
    0.1 is about 10 %: `spread_before` of the quantity itself, `spread_thesis` after division by omega^p d^q with the
    exponents of Eqs 3.28 and 3.29 (omega_supposed, d_supposed), `spread_own` after those of a regression (omega, d,
    with intervals of `probability`). `collapse` is the verdict on the thesis's scaling, which agrees at COLLAPSE_MAX or
    less, and `reason` says whether its own would do. A single condition at a fill ratio gives no spread; density and
    amplitude are the mill's. A charge of several sizes is compared only with itself, at other speeds.
    """
    whole = with_power_per_ball(as_built(descriptors))
    groups = whole.groupby(["fill_ratio", CHARGE])
    is_compared = groups["fill_ratio"].transform("size") > 1
    table = whole[is_compared]
    constants = pd.get_dummies(groups.ngroup()[is_compared]).to_numpy(dtype=float)
    varied = {name: np.log(table[column].to_numpy(dtype=float)) for name, column in VARIED.items()}
    rows = []
    for quantity in COLLAPSED:
        supposed = SCALES["power"].exponents if quantity == WALL_POWER else SUPPOSED[quantity]
        is_there = bool((whole[quantity] > 0).all())
        logs = np.log(table[quantity].to_numpy(dtype=float)) if is_there else np.full(len(table), np.nan)
        scaled = logs - sum(supposed[name] * values for name, values in varied.items())
        row = {
            "mill": whole["mill"].iloc[0],
            "contact": whole["contact"].iloc[0],
            "quantity": quantity,
            "conditions": len(table),
            "fill_ratios": table["fill_ratio"].nunique(),
            "spread_before": _spread(logs, constants),
            "spread_thesis": _spread(scaled, constants),
            **_own(logs, constants, varied if is_there else dict.fromkeys(varied, np.empty(0)), probability),
            **{f"{name}_supposed": supposed[name] for name in VARIED},
        }
        word, reason = judge_collapse(row["spread_thesis"], row["spread_own"]) if is_there else NOTHING_THERE
        rows.append(row | {"collapse": word, "reason": reason})
    return pd.DataFrame(rows)


def one_row_a_mill(tables: list[pd.DataFrame]) -> pd.DataFrame:
    """The collapse of several mills, a row for each mill; columns NAME_* for the names in COLLAPSED."""
    kept = [f"spread_{name}" for name in ("before", "thesis", "own")]
    kept += [f"{name}{end}" for name in VARIED for end in ("", "_lower", "_upper")]
    rows = []
    for table in tables:
        first = table.iloc[0]
        row = {name: first[name] for name in ("mill", "contact", "conditions")}
        for quantity, name in COLLAPSED.items():
            if not name:
                continue
            own = table[table["quantity"] == quantity].iloc[0]
            row |= {f"{name}_collapse": own["collapse"], f"{name}_reason": own["reason"]}
            row |= {f"{name}_{column}": own[column] for column in kept}
        rows.append(row)
    return pd.DataFrame(rows)
