"""The atlas as it predicts: for each kind, power laws in the groups, and a Gaussian process for what they leave.

A fitted number y, the logarithm of one of `FITTED` over its scale, is

    y(x) = b_0 + b x + sum_i a_i k(x, x_i),  k(x, x') = s^2 (1 + z + z^2 / 3) exp(-z),  z^2 = 5 |(x - x') / l|^2,

with x the inputs of a condition (`inputs_of`), x_i those of the simulations. Its half-width is q exp(c_0 + c x): of the
residuals of simulations that were left out. Everything is in one JSON file, and needs numpy only
(Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, Eqs 2.25, 4.17 and 2.41).
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from millprint.atlas.kind_groups import Kind
from millprint.atlas.kinds import KINDS
from millprint.config.errors import ConfigError
from millprint.estimate.quantiles import normal_quantile
from millprint.run.files import read_format

FORMAT = "millprint atlas 3"
# What is fitted: power, weighted energies and rates over their scales, and rolling over tangential power.
FITTED = (
    "power", "normal_energy", "normal_frequency", "tangential_energy", "tangential_frequency", "rolling_ratio",
    "strong_frequency",
)  # fmt: skip
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
# Marks of median errors [-]: where more is to be expected, the atlas asks for a simulation.
MARKS = {
    "wall_power_W": 0.05,
    "weighted_normal_energy_J": 0.10,
    "weighted_normal_frequency_hz": 0.10,
    "weighted_tangential_energy_J": 0.15,
    "weighted_tangential_frequency_hz": 0.15,
}
# Level of the intervals, and the normal quantile at their ends [-].
LEVEL = 0.90
NORMAL = float(normal_quantile(0.5 + LEVEL / 2))
# Variances of a slope over the range of a group and of the constant, of a logarithm, before anything is simulated.
SLOPES, CONSTANT = 1.0, 10.0
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
    one, other = first / lengths, second / lengths
    # In place: there are millions of pairs, and new arrays take longer than the numbers.
    z = one @ (-2 * other.T)
    z += (one**2).sum(axis=1)[:, None]
    z += (other**2).sum(axis=1)
    z = np.sqrt(np.maximum(z, 0.0, out=z), out=z)
    z *= -math.sqrt(5)
    found = z / 3
    found -= 1
    found *= z
    found += 1
    found *= np.exp(z, out=z)
    return found


def logistic(value: np.ndarray) -> np.ndarray:
    """1 / (1 + exp(-x))."""
    return 1 / (1 + np.exp(-value))


@dataclass(frozen=True)
class Surface:
    """A fitted number over the inputs.

    linear: b (p + 1,); lengths (p,); weights: a (n,) with s^2 in it; rows (n,) that it is fitted to, and the variance
    (n,) of their noise; amplitude: s^2; factor: by which the 90 % interval of the process has to grow to hold nine of
    ten rows that it was not told, 1 or more.
    """

    linear: np.ndarray
    lengths: np.ndarray
    weights: np.ndarray
    rows: np.ndarray
    noise: np.ndarray
    amplitude: float
    factor: float = 1.0

    def _own(self, inputs: np.ndarray) -> np.ndarray:
        """Those of the inputs (m, p or more) that the surface depends on, the first p."""
        return inputs[:, : len(self.lengths)]

    def at(self, inputs: np.ndarray, centres: np.ndarray) -> np.ndarray:
        """The values (m,) at inputs (m, p or more); centres: of all simulations of the kind."""
        own = self._own(inputs)
        smooth = matern(own, self._own(centres[self.rows]), self.lengths) @ self.weights
        return self.linear[0] + own @ self.linear[1:] + smooth

    def slope_error(self, before: np.ndarray, after: np.ndarray, centres: np.ndarray) -> np.ndarray:
        """Standard deviation (m,) of the difference between inputs (m, p), by Eq. 2.26 of the source, times the factor.

        The slopes b count as normal numbers of variance SLOPES.
        """
        from scipy.linalg import cho_factor, cho_solve  # takes long to import, and only slopes need it

        before, after, own = self._own(before), self._own(after), self._own(centres[self.rows])
        moved = after - before
        near = self.amplitude * (matern(after, own, self.lengths) - matern(before, own, self.lengths))
        near += SLOPES * moved @ own.T
        covariance = self.amplitude * matern(own, own, self.lengths) + np.diag(self.noise)
        # The constant b_0 is not known either.
        covariance += SLOPES * (own @ own.T) + CONSTANT
        apart = np.array(
            [matern(one[None], two[None], self.lengths)[0, 0] for one, two in zip(before, after, strict=True)]
        )
        known = np.vecdot(near, cho_solve(cho_factor(covariance, lower=True, overwrite_a=True), near.T).T)
        before_known = 2 * self.amplitude * (1 - apart) + SLOPES * (moved**2).sum(axis=1)
        return self.factor * np.sqrt(np.maximum(before_known - known, 0.0))

    def plain(self) -> dict:
        """As JSON has it."""
        arrays = {name: _rounded(getattr(self, name)) for name in ("linear", "lengths", "weights", "rows", "noise")}
        return arrays | {name: float(f"{getattr(self, name):.7g}") for name in ("amplitude", "factor")}


def _rounded(values: np.ndarray) -> list:
    return [int(value) if float(value).is_integer() else float(f"{value:.7g}") for value in values]


@dataclass(frozen=True)
class Width:
    """Half of the 90 % interval of a number's logarithm: q exp(c_0 + c x), c (p + 1,); median: in place of the factor q
    for the median error."""

    linear: np.ndarray
    factor: float
    median: float

    def at(self, inputs: np.ndarray) -> np.ndarray:
        """The half-widths (m,) at inputs (m, p)."""
        return self.factor * np.exp(self.linear[0] + inputs @ self.linear[1:])

    def typical(self, inputs: np.ndarray) -> np.ndarray:
        """The median errors (m,) to be expected at inputs (m, p)."""
        return self.median / self.factor * self.at(inputs)


def combined(fitted: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The logarithms of PREDICTED over their scales, from those of FITTED.

    Parts of the power add up to it: they are as n E*_n f*_n to n E*_t f*_t, and rolling to the latter.
    """
    products = {name: fitted[f"{name}_energy"] + fitted[f"{name}_frequency"] for name in ("normal", "tangential")}
    products["rolling"] = products["tangential"] + fitted["rolling_ratio"]
    whole = np.log(np.sum([np.exp(part) for part in products.values()], axis=0))
    return {
        "wall_power_W": fitted["power"],
        **{f"{name}_power_W": fitted["power"] + part - whole for name, part in products.items()},
        **{f"weighted_{name}_energy_J": fitted[f"{name}_energy"] for name in ("normal", "tangential")},
        **{f"weighted_{name}_frequency_hz": fitted[f"{name}_frequency"] for name in ("normal", "tangential")},
        "strong_frequency_hz": fitted["strong_frequency"],
    }


@dataclass(frozen=True)
class KindModel:
    """The model of one kind: a surface for each of FITTED, a width for each of PREDICTED.

    centres: inputs (n, p + 1) of its simulations, the last one 1 where balls hit something and 0 where not, which only
    the power depends on; hits: the surface of a number whose logistic function is the probability that they do; about:
    what it was made from.
    """

    kind: Kind
    centres: np.ndarray
    surfaces: Mapping[str, Surface]
    widths: Mapping[str, Width]
    hits: Surface
    about: Mapping[str, Any] = field(default_factory=dict)

    def completed(self, inputs: np.ndarray) -> np.ndarray:
        """Inputs (m, p) with whether balls are likely to hit something (m, p + 1)."""
        return np.column_stack([inputs, self.probability(inputs) > HITS])

    def fitted(self, inputs: np.ndarray) -> dict[str, np.ndarray]:
        """The values of every surface at inputs (m, p)."""
        completed = self.completed(inputs)
        return {name: surface.at(completed, self.centres) for name, surface in self.surfaces.items()}

    def logarithms(self, inputs: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
        """Value and half-width of the logarithm of each of PREDICTED over its scale, at inputs (m, p)."""
        found = combined(self.fitted(inputs))
        return {name: (found[name], self.widths[name].at(inputs)) for name in PREDICTED}

    def probability(self, inputs: np.ndarray) -> np.ndarray:
        """The probability (m,) that balls hit something."""
        return logistic(self.hits.at(inputs, self.centres))

    def plain(self) -> dict:
        """As JSON has it."""
        return {
            "centres": [_rounded(row) for row in self.centres],
            "surfaces": {name: surface.plain() for name, surface in self.surfaces.items()},
            "widths": {
                name: {"linear": _rounded(own.linear), "factor": own.factor, "median": own.median}
                for name, own in self.widths.items()
            },
            "hits": self.hits.plain(),
        }


def _surface(content: dict, widest: int, simulations: int) -> Surface:
    rows = np.array(content["rows"], dtype=int)
    linear, lengths, weights, noise = (
        np.array(content[name], dtype=float) for name in ("linear", "lengths", "weights", "noise")
    )
    surface = Surface(linear, lengths, weights, rows, noise, float(content["amplitude"]), float(content["factor"]))
    fits = len(surface.linear) == len(surface.lengths) + 1 and len(surface.lengths) in (widest - 1, widest)
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
            width = len(kind.groups) + len(kind.derived) + 1
            surfaces = {each: _surface(own["surfaces"][each], width, len(centres)) for each in FITTED}
            widths = {
                each: Width(np.array(law["linear"], dtype=float), float(law["factor"]), float(law["median"]))
                for each, law in ((each, own["widths"][each]) for each in PREDICTED)
            }
            found[name] = KindModel(
                kind, centres, surfaces, widths, _surface(own["hits"], width, len(centres)), own["about"]
            )
        return found
    except (KeyError, TypeError, ValueError) as error:
        raise ConfigError(f"{path}: not a whole atlas: {type(error).__name__} {error}") from None
