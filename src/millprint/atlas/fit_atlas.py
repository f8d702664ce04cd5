"""The fit of the atlas: power laws by ridge regression, then a Gaussian process of what they leave, then widths.

Each row has its own noise, known from its turns; what else scatters, such as motions that last in several ways, is one
further variance. Lengths and variances are those of the largest marginal likelihood (scikit-learn). Widths come from
residuals of rows that are left out (Rasmussen and Williams 2006, Eqs 5.10 to 5.12), with the lengths kept.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.linalg import cho_factor, cho_solve
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern, WhiteKernel

from millprint.atlas.groups import Kind
from millprint.atlas.model import FITTED, FORMAT, PREDICTED, KindModel, Surface, Width, combined, inputs_of, matern

# Strength of the ridge, in rows; level of the intervals [-]; least and largest noise of a row of a logarithm [-].
RIDGE, LEVEL, NOISE = 0.3, 0.90, (0.003, 1.0)
# Of the observable's relative standard errors, those of the rows of each of FITTED.
NOISE_OF = {
    "power": "wall_power_relative_se",
    "normal_energy": "weighted_normal_energy_relative_se",
    "tangential_energy": "weighted_tangential_energy_relative_se",
}
# Further starts of the search for lengths, in the fit that ships.
RESTARTS = 1
# Rows of these words have no hits, nor those whose E*n is under this share of m (2 pi f A)^2: of 50 planetary mills,
# hardly one lies between e^-5 and e^-7.
NO_HITS, LEAST_ENERGY = ("no impacts", "moves with the wall"), 1 / 400
FAILED = "failed"


@dataclass(frozen=True)
class Rows:
    """Rows of the table of the atlas as a fit takes them: inputs (n, p), whether balls hit anything (n,), logarithms of
    FITTED over their scales and the noise of each (n,); NaN where there is none."""

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
    fitted = {
        "power": logs["wall_power_W"],
        "normal_ratio": logs["normal_power_W"] - logs["tangential_power_W"],
        "rolling_ratio": logs["rolling_power_W"] - logs["tangential_power_W"],
        "normal_energy": logs["weighted_normal_energy_J"],
        "tangential_energy": logs["weighted_tangential_energy_J"],
        "strong_frequency": logs["strong_frequency_hz"],
    }
    noise = {
        name: own[NOISE_OF[name]].fillna(NOISE[1]).clip(*NOISE).to_numpy()
        if name in NOISE_OF
        else np.full(len(own), 0.02)
        for name in FITTED
    }
    return Rows(inputs_of(kind, own), hits, {name: value.to_numpy() for name, value in fitted.items()}, noise, own)


def fit_surface(
    inputs: np.ndarray, values: np.ndarray, noise: np.ndarray, rows: np.ndarray, restarts: int = 0
) -> tuple[Surface, np.ndarray]:
    """The surface of values (n,) at inputs (n, p) with noise (n,), and its value (n,) at each row without that row."""
    design = np.column_stack([np.ones(len(inputs)), inputs])
    weight = 1 / (noise**2 + 0.05**2)
    penalty = np.diag([0.0, *[RIDGE * weight.mean()] * inputs.shape[1]])
    linear = np.linalg.solve(design.T @ (design * weight[:, None]) + penalty, design.T @ (weight * values))
    left = values - design @ linear
    spread = float(np.std(left)) or 1.0
    kernel = ConstantKernel(1.0, (1e-3, 1e2)) * Matern(np.full(inputs.shape[1], 1.5), (0.15, 40.0), nu=2.5)
    kernel += WhiteKernel(0.1, (1e-5, 2.0))
    process = GaussianProcessRegressor(
        kernel, alpha=(noise / spread) ** 2, n_restarts_optimizer=restarts, random_state=0
    )
    process.fit(inputs, left / spread)
    found = process.kernel_
    lengths = np.atleast_1d(found.k1.k2.length_scale)
    amplitude, further = found.k1.k1.constant_value, found.k2.noise_level
    covariance = amplitude * matern(inputs, inputs, lengths) + np.diag((noise / spread) ** 2 + further)
    factor = cho_factor(covariance, lower=True)
    solved = cho_solve(factor, left / spread)
    inverse = np.diag(cho_solve(factor, np.eye(len(inputs))))
    without = values - spread * solved / inverse
    own = spread**2 * ((noise / spread) ** 2 + further)
    return Surface(linear, lengths, spread * amplitude * solved, rows, own, spread**2 * amplitude), without


def fit_width(inputs: np.ndarray, residuals: np.ndarray) -> Width:
    """The width that holds LEVEL of the residuals (n,): a power law of their size, then the quantile that is short."""
    known = np.isfinite(residuals)
    size = np.log(np.abs(residuals[known]) + 1e-3)
    design = np.column_stack([np.ones(known.sum()), inputs[known]])
    linear = np.linalg.solve(design.T @ design + np.diag([0.0, *[10.0] * inputs.shape[1]]), design.T @ size)
    over = np.abs(residuals[known]) / np.exp(design @ linear)
    place = min(1.0, math.ceil((len(over) + 1) * LEVEL) / len(over))
    return Width(linear, float(np.quantile(over, place)))


def fit_kind(kind: Kind, rows: Rows, restarts: int = 0) -> tuple[KindModel, dict[str, np.ndarray]]:
    """The model of a kind, and the logarithms of PREDICTED (n,) at each row without that row."""
    surfaces, without = {}, {}
    for name in FITTED:
        chosen = rows.hits & np.isfinite(rows.fitted[name])
        if name == "power":
            chosen = np.isfinite(rows.fitted[name])
        own = np.flatnonzero(chosen)
        surface, left_out = fit_surface(rows.inputs[own], rows.fitted[name][own], rows.noise[name][own], own, restarts)
        surfaces[name] = surface
        without[name] = np.full(len(rows), np.nan)
        without[name][own] = left_out
    predicted = combined(without)
    actual = scaled(rows.table, kind)
    widths = {
        name: fit_width(
            rows.inputs, np.where(rows.hits | (name == "wall_power_W"), actual[name] - predicted[name], np.nan)
        )
        for name in PREDICTED
    }
    return KindModel(kind, rows.inputs, surfaces, widths, fit_hits(rows)), predicted


def fit_hits(rows: Rows) -> Surface:
    """The surface whose logistic function is the probability that balls hit something: of the labels +-3, smoothed."""
    labels = np.where(rows.hits, 3.0, -3.0)
    everything = np.arange(len(rows))
    if rows.hits.all() or not rows.hits.any():
        zero = np.zeros(rows.inputs.shape[1])
        return Surface(np.array([labels[0], *zero]), zero + 1.0, np.zeros(1), everything[:1], np.ones(1), 0.0)
    return fit_surface(rows.inputs, labels, np.full(len(rows), 0.5), everything)[0]


def fit_atlas(rows: Mapping[Kind, Rows]) -> dict:
    """The content of the file of the atlas: its models of some kinds, and what they were made from."""
    models = {kind.name: fit_kind(kind, own, RESTARTS)[0].plain() | _about(own) for kind, own in rows.items()}
    return {"format": FORMAT, "kinds": models}


def _about(rows: Rows) -> dict:
    table = rows.table
    return {
        "about": {
            "simulations": len(table),
            "without_hits": int((~rows.hits).sum()),
            "version": str(table["version"].iloc[0]),
            "processor_s": round(float(table["processor_s"].sum())),
        }
    }
