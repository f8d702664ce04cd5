"""The fit of the atlas.

Each row has its own noise, known from its turns; what else scatters is one further variance, and rows far off count
less. Lengths and variances are those of the largest marginal likelihood. Widths come from residuals of rows that are
left out, with the lengths kept.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from millprint.atlas.atlas_model import (
    FITTED,
    FORMAT,
    LEVEL,
    NORMAL,
    PREDICTED,
    KindModel,
    Surface,
    Width,
    combined,
    inputs_of,
)
from millprint.atlas.design import FAILED, HELD_OUT, SKIPPED
from millprint.atlas.kind_groups import Kind, within_limits
from millprint.estimate.gaussian_process import Conditioned, Covariance, Kernel, Likelihood

# Strengths of the ridges of power laws of numbers and of widths, in rows.
RIDGE, SHRINK = 0.3, 10.0
# Noise of the logarithm of a row: least, most, and where turns do not tell it [-].
LEAST_NOISE, MOST_NOISE, OTHER_NOISE = 0.003, 1.0, 0.02
# The relative standard error of each of FITTED, as far as turns tell it.
NOISE_OF = {
    "power": "wall_power_relative_se",
    "normal_energy": "weighted_normal_energy_relative_se",
    "normal_frequency": "weighted_normal_frequency_relative_se",
    "tangential_energy": "weighted_tangential_energy_relative_se",
    "tangential_frequency": "weighted_tangential_frequency_relative_se",
}
# Of the process, as a share of what power laws leave: start and bounds of its variance, of its lengths in ranges of the
# groups, and of the further noise.
VARIANCE, LENGTH, NOISE = (1.0, 1e-3, 1e2), (1.5, 0.15, 40.0), (0.1, 1e-5, 2.0)
# Steps of the search for them, at first and in each round of weights; more of them change no error.
ITERATIONS, FURTHER_ITERATIONS = 25, 12
# Rows that the search takes, the first, which fill the ranges as all do: its time grows with their cube. With half as
# many, the mean errors of other rows were larger for every number that was tried.
SEARCHED = 800
# Rounds of weights, degrees of freedom of Student's distribution, a normal standard deviation over the median error.
ROUNDS, FREEDOM, NORMAL_OF_MEDIAN = 4, 2.0, 1.4826
# Parts of the rows that are left out in turn.
TENTHS = 10
# Noise that the power law allows for, in addition to that of each row.
LAW_NOISE = 0.05
# Rows of these words have no hits, nor those whose E*n is under this share of m (2 pi f A)^2: of 50 planetary mills,
# hardly one lies between e^-5 and e^-7.
NO_HITS, LEAST_ENERGY = ("no impacts", "moves with the wall"), 1 / 400
# Labels of rows with and without hits, and their noise: the logistic function of 3 is 0.95.
LABEL, LABEL_NOISE = 3.0, 0.5


@dataclass(frozen=True)
class Rows:
    """Rows of the table of the atlas as a fit takes them.

    inputs (n, p); hits (n,): whether balls hit anything; fitted, noise: logarithms of FITTED over their scales, and the
    noise of each (n,), NaN where there is none; table: the rows themselves; within (n,): whether the limits of the kind
    allow it. Rows beyond train, and are not judged.
    """

    inputs: np.ndarray
    hits: np.ndarray
    fitted: Mapping[str, np.ndarray]
    noise: Mapping[str, np.ndarray]
    table: pd.DataFrame
    within: np.ndarray

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.inputs)

    def some(self, chosen: np.ndarray) -> "Rows":
        """Those rows."""
        fitted, noise = ({name: own[chosen] for name, own in each.items()} for each in (self.fitted, self.noise))
        table, within = self.table.iloc[chosen].reset_index(drop=True), self.within[chosen]
        return Rows(self.inputs[chosen], self.hits[chosen], fitted, noise, table, within)

    def asked(self) -> "Rows":
        """Those that the atlas may be asked for."""
        return self.some(np.flatnonzero(self.within))


def simulated(table: pd.DataFrame, kind: Kind, part: str) -> pd.DataFrame:
    """The rows of a kind that were simulated to their end: the held-out ones, or for `training` all others."""
    own = table[(table["kind"] == kind.name) & ((table["part"] == HELD_OUT) == (part == HELD_OUT))]
    return own[~own["motion"].fillna("").str.startswith((FAILED, SKIPPED))].reset_index(drop=True)


def scaled(table: pd.DataFrame, kind: Kind) -> pd.DataFrame:
    """Logarithms of PREDICTED over their scales, a row each."""
    scales = [kind.scales(kind.condition_of(row)) for row in table.to_dict("records")]
    with np.errstate(divide="ignore", invalid="ignore"):
        columns = {name: np.log(table[name] / [own[scale] for own in scales]) for name, scale in PREDICTED.items()}
    return pd.DataFrame(columns).replace([np.inf, -np.inf], np.nan)


def rows_of(table: pd.DataFrame, kind: Kind, part: str) -> Rows:
    """The rows of a part of a kind for a fit."""
    own = simulated(table, kind, part)
    logs = scaled(own, kind)
    words = own["motion"].fillna("")
    hits = ~np.any([words.str.contains(word) for word in NO_HITS], axis=0)
    hits &= (logs["weighted_normal_energy_J"] > math.log(LEAST_ENERGY)).to_numpy()
    channels = ("normal", "tangential")
    fitted = {
        "power": logs["wall_power_W"],
        **{f"{name}_energy": logs[f"weighted_{name}_energy_J"] for name in channels},
        **{f"{name}_frequency": logs[f"weighted_{name}_frequency_hz"] for name in channels},
        "rolling_ratio": logs["rolling_power_W"] - logs["tangential_power_W"],
        "strong_frequency": logs["strong_frequency_hz"],
    }
    noise = dict.fromkeys(FITTED, np.full(len(own), OTHER_NOISE))
    noise |= {name: own[column].fillna(MOST_NOISE).clip(LEAST_NOISE, MOST_NOISE) for name, column in NOISE_OF.items()}
    return Rows(
        inputs_of(kind, own),
        hits,
        {name: np.asarray(value) for name, value in fitted.items()},
        {name: np.asarray(value) for name, value in noise.items()},
        own,
        within_limits(kind, own),
    )


@dataclass(frozen=True)
class Fit:
    """A power law and a process of what it leaves, for values (n,) with known variances (n,).

    linear (p + 1,); spread: that of what the law leaves, in which the process is scaled; theta: its parameters;
    deviations (n,): of each value from that of the others (Rasmussen and Williams 2006, Eq. 5.12).
    """

    linear: np.ndarray
    spread: float
    theta: np.ndarray
    process: Conditioned
    deviations: np.ndarray

    @classmethod
    def of(
        cls, inputs: np.ndarray, values: np.ndarray, known: np.ndarray, theta: np.ndarray | None, steps: int
    ) -> "Fit":
        """From inputs (n, p); theta: where the search for the largest likelihood starts, which ends after `steps`."""
        width = inputs.shape[1]
        design = np.column_stack([np.ones(len(inputs)), inputs])
        weight = 1 / (known + LAW_NOISE**2)
        penalty = np.diag([0.0, *[RIDGE * weight.mean()] * width])
        linear = np.linalg.solve(design.T @ (design * weight[:, None]) + penalty, design.T @ (weight * values))
        left = values - design @ linear
        spread = float(np.std(left)) or 1.0
        kernel = Kernel(("Matern 5/2",), np.zeros(1, dtype=int), np.arange(1, 1 + width)[None])
        start, *bounds = np.log([VARIANCE, *[LENGTH] * width, NOISE]).T
        theta = start if theta is None else theta
        if steps:
            likelihood = Likelihood(kernel, inputs, left / spread, known / spread**2)
            theta, _ = likelihood.maximise([theta], np.transpose(bounds), steps)
        noise = known / spread**2 + math.exp(theta[-1])
        process = Conditioned.fit(Covariance(kernel, theta), inputs, left / spread, noise)
        return cls(linear, spread, theta, process, left - spread * process.left_out(left / spread)[0])

    def at(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The values (m,) at inputs (m, p), and their standard deviations, with the noise that all rows share."""
        mean, deviation = self.process.with_deviation(inputs)
        value = self.linear[0] + inputs @ self.linear[1:] + self.spread * mean
        return value, self.spread * np.sqrt(deviation**2 + math.exp(self.theta[-1]))


def fit_robust(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, theta: np.ndarray | None = None
) -> tuple[Fit, np.ndarray]:
    """The fit of values (n,) with noise (n,), and the variances (n,) that it took: few values far off do not bend it.

    Deviations of rows that are left out count as of Student's distribution of FREEDOM degrees: each round takes the
    variance of a row as s^2 (1 / w - 1) larger, with w = (nu + 1) / (nu + e^2 / s^2) and s their spread, by the median
    (Lange, Little, Taylor, J. Am. Stat. Assoc. 84 (1989) 881). theta: parameters that are kept, if they are known; they
    are searched with SEARCHED rows.
    """
    if theta is None and len(values) > SEARCHED:
        theta = fit_robust(inputs[:SEARCHED], values[:SEARCHED], noise[:SEARCHED])[0].theta
    searched = theta is None
    fit = Fit.of(inputs, values, known := noise**2, theta, ITERATIONS if searched else 0)
    for _ in range(ROUNDS):
        spread = NORMAL_OF_MEDIAN * np.median(np.abs(fit.deviations))
        weights = (FREEDOM + 1) / (FREEDOM + (fit.deviations / max(spread, LEAST_NOISE)) ** 2)
        known = noise**2 + spread**2 * (1 / np.minimum(weights, 1.0) - 1)
        fit = Fit.of(inputs, values, known, fit.theta, FURTHER_ITERATIONS if searched else 0)
    return fit, known


def fit_surface(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, rows: np.ndarray
) -> tuple[Surface, np.ndarray]:
    """The surface of values (n,) at inputs (n, p) with noise (n,), and theta.

    rows (n,): their numbers among all simulations of the kind.
    """
    fit, known = fit_robust(inputs, values, noise)
    amplitude, *lengths, further = np.exp(fit.theta)
    own = fit.spread**2
    weights = fit.spread * amplitude * fit.process.weights
    surface = Surface(fit.linear, np.array(lengths), weights, rows, known + own * further, own * amplitude)
    return surface, fit.theta


def without_own(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, theta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Value and standard deviation (n,) at each row of a fit without its tenth of the rows, with known theta.

    Not the closed form for a row that is left out, since the weights of its neighbours know it.
    """
    tenth, found = np.arange(len(values)) % TENTHS, np.empty((2, len(values)))
    for number in range(TENTHS):
        others, own = tenth != number, tenth == number
        found[:, own] = fit_robust(inputs[others], values[others], noise[others], theta)[0].at(inputs[own])
    return found[0], found[1]


def growth(values: np.ndarray, noise: np.ndarray, told: np.ndarray, deviation: np.ndarray) -> float:
    """`Surface.factor`, from values (n,) with their noise, and what a process without them told with its deviation."""
    off = np.abs(values - told) / np.hypot(deviation, noise)
    return max(1.0, float(np.quantile(off, LEVEL)) / NORMAL)


def fit_width(inputs: np.ndarray, residuals: np.ndarray) -> Width:
    """The width that holds LEVEL of the residuals (n,): a power law of their size, and the quantile short of it; their
    median by the same law.

    The quantile is of residuals over a size that was fitted without their tenth of the rows (split conformal intervals:
    Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, J. Am. Stat. Assoc. 113 (2018) 1094).
    """
    known = np.isfinite(residuals)
    size = np.log(np.abs(residuals[known]) + 1e-3)
    design = np.column_stack([np.ones(known.sum()), inputs[known]])

    def power_law(rows: np.ndarray) -> np.ndarray:
        part = design[rows]
        return np.linalg.solve(part.T @ part + np.diag([0.0, *[SHRINK] * inputs.shape[1]]), part.T @ size[rows])

    tenth = np.arange(len(size)) % TENTHS
    laws = [power_law(tenth != number) for number in range(TENTHS)]
    fitted = np.exp([own @ laws[number] for own, number in zip(design, tenth, strict=True)])
    over = np.abs(residuals[known]) / fitted
    place = min(1.0, math.ceil((len(over) + 1) * LEVEL) / len(over))
    return Width(power_law(tenth >= 0), float(np.quantile(over, place)), float(np.median(over)))


def of_number(rows: Rows, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Inputs, values and noise of one of FITTED, and the rows that have it: the power of all rows, the rest of those
    in which balls hit something."""
    own = np.flatnonzero(np.isfinite(rows.fitted[name]) & (rows.hits | (name == "power")))
    inputs = np.column_stack([rows.inputs, rows.hits]) if name == "power" else rows.inputs
    return inputs[own], rows.fitted[name][own], rows.noise[name][own], own


def fit_kind(kind: Kind, rows: Rows) -> KindModel:
    """The model of a kind."""
    surfaces, without = {}, {}
    for name in FITTED:
        inputs, values, noise, own = of_number(rows, name)
        surface, theta = fit_surface(inputs, values, noise, own)
        told, deviation = without_own(inputs, values, noise, theta)
        surfaces[name] = replace(surface, factor=growth(values, noise, told, deviation))
        without[name] = np.full(len(rows), np.nan)
        without[name][own] = told
    residuals = scaled(rows.table, kind) - pd.DataFrame(combined(without), index=rows.table.index)
    widths = {
        name: fit_width(
            rows.inputs, np.where(rows.within & (rows.hits | (name == "wall_power_W")), residuals[name], np.nan)
        )
        for name in PREDICTED
    }
    return KindModel(kind, np.column_stack([rows.inputs, rows.hits]), surfaces, widths, fit_hits(rows))


def fit_hits(rows: Rows) -> Surface:
    """The surface whose logistic function is the probability that balls hit something: of labels, smoothed."""
    labels = np.where(rows.hits, LABEL, -LABEL)
    everything = np.arange(len(rows))
    if rows.hits.all() or not rows.hits.any():
        zero = np.zeros(rows.inputs.shape[1])
        return Surface(np.array([labels[0], *zero]), zero + 1.0, np.zeros(1), everything[:1], np.ones(1), 0.0)
    return fit_surface(rows.inputs, labels, np.full(len(rows), LABEL_NOISE), everything)[0]


def fit_atlas(rows: Mapping[Kind, Rows]) -> dict:
    """The content of the file of the atlas: its models of some kinds, and what they were made from."""
    models = {kind.name: fit_kind(kind, own).plain() | {"about": _about(own)} for kind, own in rows.items()}
    return {"format": FORMAT, "kinds": models}


def _about(rows: Rows) -> dict:
    table = rows.table
    return {
        "simulations": len(table),
        "without_hits": int((~rows.hits).sum()),
        "version": str(table["version"].iloc[0]),
        "processor_s": round(float(table["processor_s"].sum())),
    }
