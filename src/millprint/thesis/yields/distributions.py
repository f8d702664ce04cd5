"""Predictive distributions of yields, and their proper scores: CRPS, logarithmic score and probability integral.

The scores are those of Gneiting and Raftery, J. Am. Stat. Assoc. 102 (2007) 359: a forecaster does best by saying what
he believes. Smaller is better in both.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from millprint.statistics.quantiles import normal_below, normal_density, normal_log_density
from millprint.thesis.yields.averaging import LINKS, Member, to_conversion
from millprint.thesis.yields.features import describe

# CRPS [pp], logarithmic score [-] (of the density in 1/pp), and the probability integral transform [-].
SCORE_COLUMNS = ("crps_pp", "log_score", "pit")
# A yield is read off no better than this [pp]; a model that makes no error at all has no smaller deviation.
SMALLEST_PP = 0.01
# Nodes on each side of the measured yield, for the CRPS of a mixture.
NODES, NODE_WEIGHTS = np.polynomial.legendre.leggauss(96)
# A mixture's distribution function is integrated between these conversions [-] if a member is not bounded.
UNBOUNDED = (-1.0, 2.0)


class Distribution(Protocol):
    """What is predicted for m rows."""

    @property
    def name(self) -> str:
        """What the distribution is made from."""

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """CRPS [pp], logarithmic score [-] and probability integral [-], (m,) each, for measured yields (m,) [%]."""


@dataclass(frozen=True)
class NormalYields:
    """Normal distributions: mean [%] and standard deviation [pp], (m,) each; `name` says what the deviation is from."""

    name: str
    mean: np.ndarray
    deviation: np.ndarray

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As Distribution.scores. CRPS = s (z (2 Phi(z) - 1) + 2 phi(z) - 1 / sqrt(pi)), z = (y - mean) / s."""
        deviation = np.maximum(self.deviation, SMALLEST_PP)
        scaled = (truth - self.mean) / deviation
        below = normal_below(scaled)
        crps = deviation * (scaled * (2 * below - 1) + 2 * normal_density(scaled) - 1 / np.sqrt(np.pi))
        return crps, -normal_log_density(truth, self.mean, deviation), below


@dataclass(frozen=True)
class MixtureYields:
    """A mixture of normal distributions, each behind a link.

    latent: mean and standard deviation of link(y) of each member, (m,) each; weights add up to one; margin: the
    smallest distance of a measured conversion from 0 and 1 [-], where its density is asked for.
    """

    members: list[Member]
    weights: np.ndarray
    latent: list[tuple[np.ndarray, np.ndarray]]
    margin: float

    name = "mixture"

    @classmethod
    def of(cls, members: list[Member], weights: np.ndarray, rows: pd.DataFrame, margin: float) -> "MixtureYields":
        """The mixture that members with these weights predict for rows with the six conditions."""
        inputs = describe(rows).to_numpy()
        return cls(members, weights, [member.latent(inputs) for member in members], margin)

    def below(self, conversion: np.ndarray) -> np.ndarray:
        """Probability (m, q) of at most these conversions (m, q) [-]."""
        total = np.zeros(conversion.shape)
        for member, weight, (mean, deviation) in zip(self.members, self.weights, self.latent, strict=True):
            total += weight * member.share_below(conversion, mean[:, None], deviation[:, None])
        return total

    def scores(self, truth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """As Distribution.scores. CRPS is the integral of (F(x) - 1{x >= y})^2, by Gauss-Legendre on each side of y."""
        conversion = np.asarray(truth, dtype=float) / 100
        bounded = all(member.candidate.link != "identity" for member in self.members)
        low, high = (0.0, 1.0) if bounded else UNBOUNDED
        crps = np.zeros(len(conversion))
        for start, end, beyond in ((low, conversion, 0.0), (conversion, high, 1.0)):
            half = (np.asarray(end) - np.asarray(start)) / 2 * np.ones(len(conversion))
            middle = (np.asarray(end) + np.asarray(start)) / 2
            at = np.reshape(middle, (-1, 1)) + half[:, None] * NODES
            crps += half * ((self.below(at) - beyond) ** 2 @ NODE_WEIGHTS)
        inside, density = to_conversion(truth, self.margin), np.zeros(len(conversion))
        for member, weight, (mean, deviation) in zip(self.members, self.weights, self.latent, strict=True):
            link = LINKS[member.candidate.link]
            slope = np.exp(link.log_slope(inside))
            density += weight * normal_density(link.forward(inside), mean, deviation) * slope
        return 100 * crps, -np.log(density / 100), self.below(conversion[:, None])[:, 0]
