"""The fit of the atlas: power laws by ridge regression, then a Gaussian process of what they leave, then widths.

Each row has its own noise, known from its turns; what else scatters, such as motions that last in several ways, is one
further variance. Lengths and variances are those of the largest marginal likelihood. Widths come from residuals of rows
that are left out (Rasmussen and Williams 2006, Eqs 5.10 to 5.12), with the lengths kept.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.atlas.atlas_model import (
    FITTED,
    FORMAT,
    PREDICTED,
    KindModel,
    Surface,
    Width,
    combined,
    inputs_of,
)
from millprint.atlas.kind_groups import Kind
from millprint.estimate.gaussian_process import Conditioned, Covariance, Kernel, Likelihood

# Strengths of the ridges of power laws of numbers and of widths, in rows; level of the intervals [-].
RIDGE, SHRINK, LEVEL = 0.3, 10.0, 0.90
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
# Steps of the search for them; more of them change no error.
ITERATIONS = 30
# Rows of these words have no hits, nor those whose E*n is under this share of m (2 pi f A)^2: of 50 planetary mills,
# hardly one lies between e^-5 and e^-7.
NO_HITS, LEAST_ENERGY = ("no impacts", "moves with the wall"), 1 / 400
FAILED = "failed"
# Labels of rows with and without hits, and their noise: the logistic function of 3 is 0.95.
LABEL, LABEL_NOISE = 3.0, 0.5


@dataclass(frozen=True)
class Rows:
    """Rows of the table of the atlas as a fit takes them.

    inputs (n, p); hits (n,): whether balls hit anything; fitted, noise: logarithms of FITTED over their scales, and the
    noise of each (n,), NaN where there is none; table: the rows themselves.
    """

    inputs: np.ndarray
    hits: np.ndarray
    fitted: Mapping[str, np.ndarray]
    noise: Mapping[str, np.ndarray]
    table: pd.DataFrame

    def __len__(self) -> int:
        """The number of rows."""
        return len(self.inputs)

    def some(self, chosen: np.ndarray) -> "Rows":
        """Those rows."""
        fitted, noise = ({name: own[chosen] for name, own in each.items()} for each in (self.fitted, self.noise))
        return Rows(self.inputs[chosen], self.hits[chosen], fitted, noise, self.table.iloc[chosen])


def simulated(table: pd.DataFrame, kind: Kind, part: str) -> pd.DataFrame:
    """The rows of a kind and a part that were simulated to their end."""
    own = table[(table["kind"] == kind.name) & (table["part"] == part)]
    return own[~own["motion"].fillna("").str.startswith(FAILED)].reset_index(drop=True)


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
    )


def fit_surface(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, rows: np.ndarray
) -> tuple[Surface, np.ndarray]:
    """The surface of values (n,) at inputs (n, p) with noise (n,), and its value (n,) at each row without that row.

    rows (n,): their numbers among all simulations of the kind.
    """
    design = np.column_stack([np.ones(len(inputs)), inputs])
    weight = 1 / (noise**2 + 0.05**2)
    penalty = np.diag([0.0, *[RIDGE * weight.mean()] * inputs.shape[1]])
    linear = np.linalg.solve(design.T @ (design * weight[:, None]) + penalty, design.T @ (weight * values))
    left = values - design @ linear
    spread = float(np.std(left)) or 1.0
    width = inputs.shape[1]
    kernel = Kernel(("Matern 5/2",), np.zeros(1, dtype=int), np.arange(1, 1 + width)[None])
    start, *bounds = np.log([VARIANCE, *[LENGTH] * width, NOISE]).T
    known = (noise / spread) ** 2
    likelihood = Likelihood(kernel, inputs, left / spread, known)
    theta, _ = likelihood.maximise([start], np.transpose(bounds), ITERATIONS)
    amplitude, *lengths, further = np.exp(theta)
    own = known + further
    process = Conditioned.fit(Covariance(kernel, theta), inputs, left / spread, own)
    without = values - left + spread * process.left_out(left / spread)[0]
    weights = spread * amplitude * process.weights
    return Surface(linear, np.array(lengths), weights, rows, spread**2 * own, spread**2 * amplitude), without


def fit_width(inputs: np.ndarray, residuals: np.ndarray) -> Width:
    """The width that holds LEVEL of the residuals (n,): a power law of their size, and the quantile short of it.

    The quantile is of residuals over a size that was fitted without their tenth of the rows (split conformal intervals:
    Lei, G'Sell, Rinaldo, Tibshirani, Wasserman, J. Am. Stat. Assoc. 113 (2018) 1094).
    """
    known = np.isfinite(residuals)
    size = np.log(np.abs(residuals[known]) + 1e-3)
    design = np.column_stack([np.ones(known.sum()), inputs[known]])

    def power_law(rows: np.ndarray) -> np.ndarray:
        part = design[rows]
        return np.linalg.solve(part.T @ part + np.diag([0.0, *[SHRINK] * inputs.shape[1]]), part.T @ size[rows])

    tenth = np.arange(len(size)) % 10
    laws = [power_law(tenth != number) for number in range(10)]
    fitted = np.exp([own @ laws[number] for own, number in zip(design, tenth, strict=True)])
    over = np.abs(residuals[known]) / fitted
    place = min(1.0, math.ceil((len(over) + 1) * LEVEL) / len(over))
    return Width(power_law(tenth >= 0), float(np.quantile(over, place)))


def fit_kind(kind: Kind, rows: Rows) -> KindModel:
    """The model of a kind. The power is of all rows, the rest of those in which balls hit something."""
    surfaces, without = {}, {}
    completed = np.column_stack([rows.inputs, rows.hits])
    for name in FITTED:
        of_all = name == "power"
        own = np.flatnonzero(np.isfinite(rows.fitted[name]) & (rows.hits | of_all))
        inputs = completed if of_all else rows.inputs
        surfaces[name], left_out = fit_surface(inputs[own], rows.fitted[name][own], rows.noise[name][own], own)
        without[name] = np.full(len(rows), np.nan)
        without[name][own] = left_out
    residuals = scaled(rows.table, kind) - pd.DataFrame(combined(without), index=rows.table.index)
    widths = {
        name: fit_width(rows.inputs, np.where(rows.hits | (name == "wall_power_W"), residuals[name], np.nan))
        for name in PREDICTED
    }
    return KindModel(kind, completed, surfaces, widths, fit_hits(rows))


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
