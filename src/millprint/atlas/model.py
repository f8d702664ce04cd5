"""The atlas as it predicts: for each kind, power laws in the groups, and a Gaussian process for what they leave.

A fitted number y, the logarithm of one of `FITTED` over its scale, is

    y(x) = b_0 + b x + sum_i a_i k(x, x_i),   k(x, x') = s^2 (1 + z + z^2 / 3) exp(-z),   z^2 = 5 sum_j ((x_j - x'_j) / l_j)^2,

with x the inputs of a condition (`inputs_of`), x_i those of the simulations. Its half-width is q exp(c_0 + c x): of the
residuals of simulations that were left out. Everything is in one JSON file, and needs numpy only
(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, Eqs 2.25, 4.17 and 2.41).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from millprint.atlas.groups import Kind
from millprint.atlas.kinds import KINDS
from millprint.config.errors import ConfigError
from millprint.run.files import read_format

FORMAT = "millprint atlas 1"
# What is fitted: power over its scale, ratios of its parts, and weighted energies and the rate of strong hits over theirs.
FITTED = ("power", "normal_ratio", "rolling_ratio", "normal_energy", "tangential_energy", "strong_frequency")
# What is predicted, by the observables' names, and the scale of each (`Kind.scales`).
PREDICTED = {
    "wall_power_W": "power",
    "normal_power_W": "power",
    "tangential_power_W": "power",
    "rolling_power_W": "power",
    "weighted_normal_energy_J": "energy",
    "weighted_normal_frequency_hz": "frequency",
    "weighted_tangential_energy_J": "energy",
    "weighted_tangential_frequency_hz": "frequency",
    "strong_frequency_hz": "frequency",
}
# The probability that balls hit something, under which only the power is told.
HITS = 0.5


def inputs_of(kind: Kind, groups: Mapping[str, Any]) -> np.ndarray:
    """The inputs (m, p) of conditions whose groups (m,) are given by name: shares of the ranges, then what the kind
    derives from them."""
    columns = [group.share(np.asarray(groups[group.name], dtype=float)) for group in kind.groups]
    derived = [np.asarray(of(groups), dtype=float) for of in kind.derived]
    return np.atleast_2d(np.column_stack([*columns, *derived]))


def matern(first: np.ndarray, second: np.ndarray, lengths: np.ndarray) -> np.ndarray:
    """Matern's covariance of smoothness 5/2 between rows (m, p) and (n, p), without its amplitude: (m, n)."""
    squared = (((first[:, None, :] - second[None, :, :]) / lengths) ** 2).sum(axis=2)
    z = np.sqrt(5 * squared)
    return (1 + z + z**2 / 3) * np.exp(-z)


@dataclass(frozen=True)
class Surface:
    """A fitted number over the inputs: b (p + 1,), lengths (p,), a (n,) with s^2 in it, the rows (n,) that it is fitted to,
    the variance (n,) of their noise, and s^2 itself."""

    linear: np.ndarray
    lengths: np.ndarray
    weights: np.ndarray
    rows: np.ndarray
    noise: np.ndarray
    amplitude: float

    def at(self, inputs: np.ndarray, centres: np.ndarray) -> np.ndarray:
        """The values (m,) at inputs (m, p); centres: inputs of all simulations of the kind, `rows` of which are its own."""
        smooth = matern(inputs, centres[self.rows], self.lengths) @ self.weights
        return self.linear[0] + inputs @ self.linear[1:] + smooth

    def slope_error(self, before: np.ndarray, after: np.ndarray, centres: np.ndarray) -> np.ndarray:
        """Standard deviation (m,) of the smooth part's difference between inputs (m, p), by Eq. 2.26 of the source."""
        own = centres[self.rows]
        near = self.amplitude * (matern(after, own, self.lengths) - matern(before, own, self.lengths))
        covariance = self.amplitude * matern(own, own, self.lengths) + np.diag(self.noise)
        apart = np.array(
            [matern(one[None], two[None], self.lengths)[0, 0] for one, two in zip(before, after, strict=True)]
        )
        known = np.einsum("ij,ji->i", near, np.linalg.solve(covariance, near.T))
        return np.sqrt(np.maximum(2 * self.amplitude * (1 - apart) - known, 0.0))

    def plain(self) -> dict:
        """As JSON has it."""
        arrays = {name: _rounded(getattr(self, name)) for name in ("linear", "lengths", "weights", "rows", "noise")}
        return arrays | {"amplitude": float(f"{self.amplitude:.7g}")}


def _rounded(values: np.ndarray) -> list:
    return [int(value) if float(value).is_integer() else float(f"{value:.7g}") for value in values]


@dataclass(frozen=True)
class Width:
    """Half of the 90 % interval of a number's logarithm: q exp(c_0 + c x), c (p + 1,)."""

    linear: np.ndarray
    factor: float

    def at(self, inputs: np.ndarray) -> np.ndarray:
        """The half-widths (m,) at inputs (m, p)."""
        return self.factor * np.exp(self.linear[0] + inputs @ self.linear[1:])


def combined(fitted: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The logarithms of PREDICTED over their scales, from those of FITTED.

    Parts of the power are shares that add up to 1, and a rate is f* = P / (n E*).
    """
    normal, rolling = np.exp(fitted["normal_ratio"]), np.exp(fitted["rolling_ratio"])
    whole = np.log(1 + normal + rolling)
    power = fitted["power"]
    parts = {"normal": power + fitted["normal_ratio"] - whole, "tangential": power - whole}
    return {
        "wall_power_W": power,
        **{f"{name}_power_W": part for name, part in parts.items()},
        "rolling_power_W": power + fitted["rolling_ratio"] - whole,
        **{f"weighted_{name}_energy_J": fitted[f"{name}_energy"] for name in parts},
        **{f"weighted_{name}_frequency_hz": part - fitted[f"{name}_energy"] for name, part in parts.items()},
        "strong_frequency_hz": fitted["strong_frequency"],
    }


@dataclass(frozen=True)
class KindModel:
    """The model of one kind: centres (n, p), a surface for each of FITTED, a width for each of PREDICTED.

    hits: the surface of a number whose logistic function is the probability that balls hit something; about: what it
    was made from.
    """

    kind: Kind
    centres: np.ndarray
    surfaces: Mapping[str, Surface]
    widths: Mapping[str, Width]
    hits: Surface
    about: Mapping[str, Any] = field(default_factory=dict)

    def fitted(self, inputs: np.ndarray) -> dict[str, np.ndarray]:
        """The values of every surface at inputs (m, p)."""
        return {name: surface.at(inputs, self.centres) for name, surface in self.surfaces.items()}

    def logarithms(self, inputs: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Value and half-width of the logarithm of each of PREDICTED over its scale, at inputs (m, p)."""
        found = combined(self.fitted(inputs))
        return {name: (found[name], self.widths[name].at(inputs)) for name in PREDICTED}

    def probability(self, inputs: np.ndarray) -> np.ndarray:
        """The probability (m,) that balls hit something."""
        return 1 / (1 + np.exp(-self.hits.at(inputs, self.centres)))

    def plain(self) -> dict:
        """As JSON has it."""
        return {
            "centres": [_rounded(row) for row in self.centres],
            "surfaces": {name: surface.plain() for name, surface in self.surfaces.items()},
            "widths": {
                name: {"linear": _rounded(own.linear), "factor": own.factor} for name, own in self.widths.items()
            },
            "hits": self.hits.plain(),
        }


def _surface(content: dict, width: int, simulations: int) -> Surface:
    rows = np.array(content["rows"], dtype=int)
    linear, lengths, weights, noise = (
        np.array(content[name], dtype=float) for name in ("linear", "lengths", "weights", "noise")
    )
    surface = Surface(linear, lengths, weights, rows, noise, float(content["amplitude"]))
    fits = len(surface.linear) == width + 1 and len(surface.lengths) == width
    if not fits or len(surface.weights) != len(surface.rows) or surface.rows.max(initial=0) >= simulations:
        raise ValueError("a surface does not fit the inputs")
    return surface


def read_model(path: str | Path) -> dict[str, KindModel]:
    """The models of a file of the atlas by kind. Raises ConfigError, in one line, for another or a damaged file."""
    content = read_format(path, [FORMAT], "an atlas")
    try:
        found = {}
        for name, own in content["kinds"].items():
            kind, centres = KINDS[name], np.array(own["centres"], dtype=float)
            width = len(kind.groups) + len(kind.derived)
            surfaces = {each: _surface(own["surfaces"][each], width, len(centres)) for each in FITTED}
            widths = {
                each: Width(np.array(own["widths"][each]["linear"], dtype=float), float(own["widths"][each]["factor"]))
                for each in PREDICTED
            }
            found[name] = KindModel(
                kind, centres, surfaces, widths, _surface(own["hits"], width, len(centres)), own["about"]
            )
        return found
    except (KeyError, TypeError, ValueError) as error:
        raise ConfigError(f"{path}: not a whole atlas: {type(error).__name__} {error}") from None
