"""Kinetics of a yield over time or dose: first order, Avrami and a threshold, fitted and compared by AICc.

The yield y [%] of a run at x, its time or its dose:

    first order   y = 100 (1 - exp(-k x))
    Avrami        y = 100 (1 - exp(-(k x)^n))
    threshold     y = 100 (1 - exp(-k (x - x0))) above x0, 0 below it
    no effect     y = mean of the yields, whatever x is

Shear against compression: with separate rates for the normal dose x_n and the tangential dose x_t, Avrami's law is

    y = 100 (1 - exp(-(k (x_n + w x_t))^n)),    first order: n = 1

The one with the smaller AICc is taken. w = 1: only the total dose matters; above 1, shear does more than compression.

Dose: the energy that a gram of powder has received, by compression, shear and rolling, and how often it was hit.

All of the dissipated energy counts, as if every collision caught powder, since no model gives the share that does.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from scipy.constants import hour as HOUR
from scipy.optimize import brentq, least_squares, minimize_scalar

from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import DIFFERS, Allowed, judge
from millprint.estimate.quantiles import f_quantile
from millprint.observables.definitions import POWER
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_copies, refuse_rows

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint

# The doses, and the time that they are compared with: title and unit.
NORMAL, TANGENTIAL, ROLLING, TOTAL = "normal_kJ_g", "tangential_kJ_g", "rolling_kJ_g", "total_kJ_g"
HITS, TIME, YIELD = "hits_per_g", "time_h", "yield_percent"
AXES = {TIME: "time [h]", TOTAL: "dose [kJ/g]", NORMAL: "normal dose [kJ/g]", TANGENTIAL: "tangential dose [kJ/g]",
        HITS: "hits per gram [1/g]"}  # fmt: skip
CONDITION = ("fill_ratio", "speed_rpm", "ball_diameter_mm")
POSITIVE = ("powder_mass_g", TIME, *CONDITION)
# Lowest and highest of a number that people write: a microgram to a thousand tonnes, a millisecond to a century.
WRITTEN = {"powder_mass_g": (1e-6, 1e9), TIME: (1e-7, 1e6)}


def doses(
    normal_J: pd.Series, tangential_J: pd.Series, frequency_hz: pd.Series, time_h: pd.Series, powder_g: pd.Series
) -> pd.DataFrame:
    """The doses of the thesis [kJ/g], without rolling, and hits per gram [1/g] of powder after the milling time.

    E_n f t / m, E_t f t / m, their sum, and f t / m: energies of a collision E [J], collisions f [1/s] of the balls
    that share the powder m [g], time t. All balls with all powder give the same as one ball with its share of both.
    """
    hits = frequency_hz * time_h * HOUR / powder_g
    normal, tangential = normal_J * hits * 1e-3, tangential_J * hits * 1e-3
    return pd.DataFrame({NORMAL: normal, TANGENTIAL: tangential, TOTAL: normal + tangential, HITS: hits})


# Dose -> the power that gives it.
DOSE_OF = {NORMAL: "normal_power_W", TANGENTIAL: "tangential_power_W", ROLLING: "rolling_power_W", TOTAL: POWER}


def doses_of(found: Any, balls: int, time_h: float, powder_g: float) -> dict[str, Estimate]:
    """The doses of a prediction or a card, P t / m of the power and of each of its parts [kJ/g], and hits [1/g]."""
    time_s = time_h * HOUR
    known = {name: getattr(found, power) * (1e-3 * time_s / powder_g) for name, power in DOSE_OF.items()}
    known = {name: replace(own, unit="kJ/g") for name, own in known.items()}
    return known | {HITS: replace(found.specific_frequency_hz * (balls * time_s / powder_g), unit="1/g")}


def share_of_one(run: pd.Series) -> str:
    """What is wrong with a fill ratio of 1 or more."""
    fill = run["fill_ratio"]
    return "must be under 1" + (f"; write {fill / 100:g} for {fill:g} %" if 1 < fill < 100 else "")


def own_doses(path: str | Path, fingerprints: Mapping[str, "Fingerprint"]) -> pd.DataFrame:
    """Doses of a user's runs: columns case, mill, powder_mass_g, time_h, fill_ratio, speed_rpm, ball_diameter_mm.

    Adds the doses, wall_power_W, and `outside`, what is outside the simulated ranges; yield_percent is kept. Doses by
    hits are NaN at conditions without impacts and next to them, where `outside` says no_impacts. Raises ConfigError, in
    one line, for a bad cell, such as a mass of 0, and for a mill without a fingerprint.
    """
    numbers = [Number(name, *WRITTEN[name]) if name in WRITTEN else Number(name, 0, above=True) for name in POSITIVE]
    table = read_measured(path, [Text(CASE, unique=True), Text("mill"), *numbers, Number(YIELD, 0, 100, optional=True)])
    if YIELD in table:
        refuse_copies(table, path, ["mill", *POSITIVE], YIELD)
    known = ", ".join(sorted(fingerprints))
    refuse_rows(table, path, "mill", ~table["mill"].isin(fingerprints), f"unknown mill; fingerprints given: {known}")
    refuse_rows(table, path, "fill_ratio", table["fill_ratio"] >= 1, share_of_one)
    rows = []
    for run in table.itertuples():
        fingerprint = fingerprints[run.mill]
        try:
            condition = fingerprint.condition(**{name: getattr(run, name) for name in CONDITION})
        except ConfigError as error:
            raise ConfigError(f"{path}: case {run.case}: {error}") from None
        found = fingerprint.predict(condition)
        told = doses_of(found, found.balls, getattr(run, TIME), run.powder_mass_g)
        own = {name: each.value for name, each in told.items()}
        rows.append(own | {POWER: found.wall_power_W.value, "outside": ", ".join(found.outside)})
    return pd.concat([table, pd.DataFrame(rows, index=table.index)], axis=1)


NO_EFFECT = "no effect"
FEWEST_RUNS = 5
TABLE = ["x", "model", "runs", "parameters", "k", "n", "x0", "rmse_pp", "r2", "aicc", "delta_aicc", "weight"]


@dataclass(frozen=True)
class Kinetics:
    """A law of the yield over x divided by its mean; names, bounds and starts of its parameters.

    k is in units of 1 / mean(x), x0 in units of the largest x over the mean.
    """

    law: Callable[..., np.ndarray]
    names: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    starts: tuple[tuple[float, ...], ...]


def _saturating(exponent: np.ndarray) -> np.ndarray:
    return -100.0 * np.expm1(-exponent)


RATES = (0.1, 0.5, 2.0)
MODELS = {
    "first order": Kinetics(lambda x, k: _saturating(k * x), ("k",), (0.0,), (1e3,), tuple((k,) for k in RATES)),
    "Avrami": Kinetics(
        lambda x, k, n: _saturating((k * x) ** n), ("k", "n"), (1e-9, 0.01), (1e3, 20.0),
        tuple((k, n) for k in RATES for n in (0.5, 1.0, 3.0)),
    ),
    "threshold": Kinetics(
        lambda x, k, x0: _saturating(k * np.maximum(x - x0 * x.max(), 0.0)), ("k", "x0"), (0.0, 0.0), (1e3, 0.999),
        tuple((k, x0) for k in RATES for x0 in (0.02, 0.2, 0.5)),
    ),
}  # fmt: skip


def aicc(squares: float, runs: int, parameters: int) -> float:
    """Akaike's criterion for normal errors, corrected for few runs (Hurvich and Tsai 1989).

    N ln(S / N) + 2 p + 2 p (p + 1) / (N - p - 1), S the sum of squares, p the number of parameters, including the
    scatter; infinite where N does not exceed p + 1.
    """
    free = runs - parameters - 1
    if free <= 0:
        return np.inf
    return float(runs * np.log(squares / runs) + 2 * parameters + 2 * parameters * (parameters + 1) / free)


def fit_law(x: np.ndarray, yields: np.ndarray, model: Kinetics) -> tuple[np.ndarray, float]:
    """Parameters in the model's own units and the sum of squares [%^2], the best from several starts."""
    scaled = x / x.mean()
    fits = [
        least_squares(lambda p: model.law(scaled, *p) - yields, start, bounds=(model.lower, model.upper))
        for start in model.starts
    ]
    best = min(fits, key=lambda fit: fit.cost)
    return best.x, 2.0 * float(best.cost)


def fit_kinetics(runs: pd.DataFrame) -> pd.DataFrame:
    """Every law of MODELS over every axis that varies, and no effect: a row of TABLE for each, smallest AICc first.

    runs: AXES and yield_percent. k in the unit of 1/x, x0 in the unit of x. weight: Akaike's weight, exp(-delta / 2)
    over its sum. Raises ConfigError for fewer than five runs or yields that are all equal.
    """
    yields = runs[YIELD].to_numpy(dtype=float)
    if len(yields) < FEWEST_RUNS:
        many = "1 run" if len(yields) == 1 else f"{len(yields)} runs"
        raise ConfigError(f"{many} with a yield: kinetics need at least {FEWEST_RUNS}")
    spread = float(((yields - yields.mean()) ** 2).sum())
    if spread == 0:
        raise ConfigError(f"column {YIELD}: all are {yields[0]:g}; kinetics need yields that differ")
    rows = [{"x": "", "model": NO_EFFECT, "parameters": 1, "squares": spread}]
    for axis in AXES:
        x = runs[axis].to_numpy(dtype=float)
        if np.ptp(x) <= 1e-9 * x.max():
            continue
        for name, model in MODELS.items():
            values, squares = fit_law(x, yields, model)
            row = dict(zip(model.names, values, strict=True))
            row["k"] /= x.mean()
            if "x0" in row:
                row["x0"] *= x.max()
            rows.append({"x": axis, "model": name, "parameters": len(values), "squares": squares, **row})
    table = pd.DataFrame(rows).reindex(columns=[*TABLE, "squares"])
    count = len(yields)
    table["runs"] = count
    # A perfect fit, possible only with made-up yields, would have the logarithm of 0.
    squares = table.pop("squares").clip(lower=1e-12 * spread)
    table["rmse_pp"], table["r2"] = np.sqrt(squares / count), 1.0 - squares / spread
    # One more parameter is the scatter.
    table["aicc"] = [aicc(value, count, own + 1) for value, own in zip(squares, table["parameters"], strict=True)]
    table["delta_aicc"] = table["aicc"] - table["aicc"].min()
    likelihood = np.exp(-table["delta_aicc"] / 2)
    table["weight"] = likelihood / likelihood.sum()
    return table.sort_values("aicc", kind="stable", ignore_index=True)


def best_of(kinetics: pd.DataFrame, axis: str) -> pd.Series | None:
    """The row with the smallest AICc over an axis; None for an axis that did not vary."""
    rows = kinetics[kinetics["x"] == axis]
    return rows.iloc[0] if len(rows) else None


def said_of_dose(runs: pd.DataFrame, kinetics: pd.DataFrame, what: str) -> str:
    """One or two sentences, only from the tables: how much of the yields dose explains, and what it does not."""
    spread = kinetics[kinetics["model"] == NO_EFFECT].iloc[0]
    said = []
    for axis in AXES:
        if (best := best_of(kinetics, axis)) is not None:
            share = f"{100 * best['r2']:.0f} %" if best["r2"] > 0 else "nothing"
            said.append(f"{AXES[axis].split(' [')[0]} {share} ({best['model']})")
    first = kinetics.iloc[0]
    top = "no effect of time or dose" if not first["x"] else f"{first['model']} over {AXES[first['x']].split(' [')[0]}"
    text = f"{what}: of the variance of {len(runs)} yields, each with its own best law, explain: {', '.join(said)}. "
    text += f"The smallest AICc has {top} (weight {first['weight']:.2f}), {spread['delta_aicc']:.1f} below no effect"
    total, of_time = best_of(kinetics, TOTAL), best_of(kinetics, TIME)
    if total is not None and of_time is not None:
        lead = of_time["aicc"] - total["aicc"]
        text += f"; dose is {'better' if lead > 0 else 'worse'} than time by {abs(lead):.1f}"
    return f"{text}. {_unexplained_pair(runs)}"


def _unexplained_pair(runs: pd.DataFrame) -> str:
    """What dose cannot explain: the two runs whose yields differ most for doses within 25 %, and their shear."""
    ordered = runs.reset_index(drop=True)
    dose, yields = ordered[TOTAL].to_numpy(), ordered[YIELD].to_numpy()
    share = (ordered[TANGENTIAL] / ordered[TOTAL]).to_numpy()
    near = np.abs(np.log(dose[:, None] / dose)) <= np.log(1.25)
    gap = np.where(near, yields[:, None] - yields, -np.inf)
    high, low = np.unravel_index(np.argmax(gap), gap.shape)
    if gap[high, low] <= 0:
        return "No two runs have doses within 25 % of each other."
    text = (
        f"Dose does not explain runs {ordered['case'][high]} and {ordered['case'][low]}: {dose[high]:.3g} and "
        f"{dose[low]:.3g} kJ/g, but {yields[high]:g} and {yields[low]:g} %"
    )
    if abs(share[high] - share[low]) < 0.01:
        return f"{text}, at the same tangential share ({100 * share[high]:.0f} %): something else differs."
    return f"{text}, with {100 * share[high]:.0f} and {100 * share[low]:.0f} % of it tangential."


LAWS = ("first order", "Avrami")
# w is searched between 1 / MOST_WORTH and MOST_WORTH.
MOST_WORTH = 1e3
# Runs whose tangential shares differ by less give no information on w [%].
SMALLEST_SPREAD = 5.0


@dataclass(frozen=True)
class ShearWorth:
    """How many kJ of compression one kJ of shear equals by the yields: w of the weighted law, and its evidence.

    lower, upper: 95 % interval by the profile of the likelihood; an end is 0 or infinite if the yields do not bound it.
    aicc: of the law with w free. gain_aicc: AICc with w = 1 less aicc; above 0, a free w is worth its parameter.
    """

    law: str
    worth: float
    lower: float
    upper: float
    aicc: float
    gain_aicc: float


def shear_worth(runs: pd.DataFrame) -> ShearWorth:
    """Fit w between 1 / MOST_WORTH and MOST_WORTH by the law of LAWS with the smallest AICc.

    runs: normal_kJ_g, tangential_kJ_g and yield_percent. The interval is the profile of normal errors: each w at which
    the sum of squares is below S_min (1 + F / (N - p)), F the 95 % quantile of F(1, N - p), p the parameters of the law
    and w.
    """
    return min((_worth_by(runs, law) for law in LAWS), key=lambda found: found.aicc)


def _worth_by(runs: pd.DataFrame, law: str) -> ShearWorth:
    yields = runs[YIELD].to_numpy(dtype=float)
    normal, tangential = (runs[name].to_numpy(dtype=float) for name in (NORMAL, TANGENTIAL))
    count, model = len(yields), MODELS[law]

    def squares(worth: float) -> float:
        return fit_law(normal + worth * tangential, yields, model)[1]

    grid = np.geomspace(1 / MOST_WORTH, MOST_WORTH, 41)
    profile = np.array([squares(worth) for worth in grid])
    place = int(np.argmin(profile))
    near = np.log(grid[max(place - 1, 0)]), np.log(grid[min(place + 1, len(grid) - 1)])
    found = minimize_scalar(lambda log_w: squares(np.exp(log_w)), bounds=near, method="bounded")
    worth, least = float(np.exp(found.x)), max(float(found.fun), 1e-12 * float(profile.max()))
    free = count - len(model.names) - 1
    bound = least * (1 + f_quantile(0.95, 1, free) / free) if free > 0 else np.inf

    def end(beyond: np.ndarray, otherwise: float) -> float:
        if not len(beyond):
            return otherwise
        return float(
            np.exp(brentq(lambda log_w: squares(np.exp(log_w)) - bound, np.log(beyond[0]), found.x, xtol=1e-3))
        )

    out = profile > bound
    lower = end(grid[out & (grid < worth)][::-1], 0.0)
    upper = end(grid[out & (grid > worth)], np.inf)
    even = max(squares(1.0), least)
    # The scatter is a parameter too.
    own = aicc(least, count, len(model.names) + 2)
    return ShearWorth(law, worth, lower, upper, own, aicc(even, count, len(model.names) + 1) - own)


def said_of_shear(runs: pd.DataFrame) -> str:
    """A sentence on shear against compression, only from the runs and the fit."""
    share = 100 * runs[TANGENTIAL] / runs[TOTAL]
    spread = f"{share.min():.0f} to {share.max():.0f} % of the dose is tangential"
    if len(runs) < FEWEST_RUNS:
        return f"Shear against compression: {spread}, in {len(runs)} runs, too few for a rate for each."
    if np.ptp(share) < SMALLEST_SPREAD:
        return f"Shear against compression: {spread} in every run, which cannot tell the two apart."
    found = shear_worth(runs)
    worth = f"{found.worth:.2g}" if found.worth < 0.99 * MOST_WORTH else f"{MOST_WORTH:g} or more"
    ends = f"{found.lower:.2g} to {'no upper end' if np.isinf(found.upper) else f'{found.upper:.2g}'}"
    same = judge(Estimate(found.worth, "-", repeats=Interval(found.lower, found.upper)), Allowed(1.0, 1.0))
    apart = "are told apart" if same.word == DIFFERS else "are not told apart"
    change = f"{'falls' if found.gain_aicc > 0 else 'rises'} by {abs(found.gain_aicc):.1f}"
    return (
        f"Shear against compression: {spread}; by {found.law} kinetics a kJ of shear is worth {worth} kJ of "
        f"compression (95 % interval {ends}), so the two {apart}; with a rate for each, AICc {change}."
    )
