"""The averaged Gaussian process: every link, scale and structure of a library, weighted by its evidence."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy.special import logsumexp, ndtr

from millprint.config.averaging import INPUTS, AveragingConfig
from millprint.predict.catalogue import AVERAGED
from millprint.predict.inputs import InputScaling, describe, smallest_spreads
from millprint.predict.links import LINKS, to_conversion
from millprint.predict.structured import Process, fit_process, terms_of

# Nodes and weights of a normal distribution's mean (Gauss and Hermite).
NODES, NODE_WEIGHTS = np.polynomial.hermite_e.hermegauss(20)
NODE_WEIGHTS = NODE_WEIGHTS / NODE_WEIGHTS.sum()
BISECTIONS = 50
# Where quantiles are looked for [-]; the identity link knows no bounds.
LOWEST, HIGHEST = -2.0, 3.0


@dataclass(frozen=True)
class Candidate:
    """What a member of the library is before it is fitted; `scales` in the order of INPUTS."""

    link: str
    scales: tuple[str, ...]
    structure: str


def library(settings: AveragingConfig) -> list[Candidate]:
    """Every combination of link, scales and structure."""
    scales = list(product(*(getattr(settings.scales, name) for name in INPUTS)))
    return [Candidate(*each) for each in product(settings.links, scales, settings.structures)]


@dataclass(frozen=True)
class Member:
    """A fitted member: z = (link(y) - mean) / spread is a Gaussian process of the scaled inputs."""

    candidate: Candidate
    scaling: InputScaling
    mean: float
    spread: float
    process: Process
    log_evidence: float

    def latent(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation of link(y) for raw inputs (n, k)."""
        mean, deviation = self.process.predict(self.scaling(inputs))
        return self.mean + self.spread * mean, self.spread * deviation

    def expected(self, inputs: np.ndarray) -> np.ndarray:
        """Mean conversion (n,) [-]."""
        return expected_conversion(self.candidate.link, *self.latent(inputs))

    def left_out(self) -> np.ndarray:
        """Mean conversion (n,) of each training row given the others, at the hyper-parameters of all of them."""
        mean, deviation = self.process.left_out()
        return expected_conversion(self.candidate.link, self.mean + self.spread * mean, self.spread * deviation)

    def share_below(self, conversion: np.ndarray, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
        """P(y <= conversion) for latent means and deviations of the same shape."""
        if self.candidate.link != "identity":
            inside = np.clip(conversion, 1e-12, 1 - 1e-12)
            below = ndtr((LINKS[self.candidate.link].forward(inside) - mean) / deviation)
            return np.where(conversion <= 0, 0.0, np.where(conversion >= 1, 1.0, below))
        return ndtr((conversion - mean) / deviation)


def expected_conversion(link: str, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Mean of the inverse link of a normal variable, for arrays (n,)."""
    return LINKS[link].inverse(mean[:, None] + deviation[:, None] * NODES) @ NODE_WEIGHTS


def fit_member(candidate: Candidate, rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> Member:
    """Fit one member on rows with the six conditions and yields (n,) [%]; its evidence is that of the yields."""
    conversion, link = to_conversion(yields, settings.margin), LINKS[candidate.link]
    raw = describe(rows).to_numpy()
    logarithmic = np.array([scale == "log" for scale in candidate.scales])
    scaling = InputScaling.of(raw, logarithmic, smallest_spreads(settings))
    seen = link.forward(conversion)
    mean, spread = float(seen.mean()), float(seen.std()) or 1.0
    process, evidence = fit_process(
        scaling(raw), (seen - mean) / spread, terms_of(candidate.structure), settings.priors
    )
    jacobian = float(link.log_slope(conversion).sum()) - len(seen) * np.log(spread)
    return Member(candidate, scaling, mean, spread, process, evidence + jacobian)


def evidence_weights(log_evidences: np.ndarray, smallest: float) -> np.ndarray:
    """Posterior probabilities of models of equal prior probability; those below `smallest` are set to zero."""
    weights = np.exp(log_evidences - logsumexp(log_evidences))
    kept = np.where(weights >= min(smallest, weights.max()), weights, 0.0)
    return kept / kept.sum()


@dataclass(frozen=True)
class AveragedModel:
    """A mixture of members with weights that add up to one."""

    members: list[Member]
    weights: np.ndarray

    algorithm = AVERAGED
    strategy = "primary"

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Mean yields (n,) [%] for rows with the six conditions."""
        inputs = describe(rows).to_numpy()
        shares = [weight * member.expected(inputs) for member, weight in zip(self.members, self.weights, strict=True)]
        return 100 * np.sum(shares, axis=0)

    def quantiles(self, rows: pd.DataFrame, levels: np.ndarray) -> np.ndarray:
        """Quantiles (n, levels) [%] of a measurement, within 0 and 100, by bisection of the mixture's distribution."""
        inputs = describe(rows).to_numpy()
        latent = [member.latent(inputs) for member in self.members]
        wanted = np.broadcast_to(np.asarray(levels, dtype=float), (len(rows), len(levels)))
        low, high = np.full(wanted.shape, LOWEST), np.full(wanted.shape, HIGHEST)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            below = np.zeros(wanted.shape)
            for member, weight, (mean, deviation) in zip(self.members, self.weights, latent, strict=True):
                below += weight * member.share_below(middle, mean[:, None], deviation[:, None])
            low, high = np.where(below < wanted, middle, low), np.where(below < wanted, high, middle)
        return 100 * np.clip((low + high) / 2, 0, 1)

    def interval(self, rows: pd.DataFrame, level: float) -> tuple[np.ndarray, np.ndarray]:
        """Ends (n,), (n,) [%] of the central predictive interval of a level."""
        ends = self.quantiles(rows, np.array([(1 - level) / 2, (1 + level) / 2]))
        return ends[:, 0], ends[:, 1]


def fit_library(rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> list[Member]:
    """Every member of the library, fitted on the given rows and nothing else."""
    return [fit_member(candidate, rows, yields, settings) for candidate in library(settings)]


def average(members: list[Member], settings: AveragingConfig) -> AveragedModel:
    """The members weighted by their evidence."""
    weights = evidence_weights(np.array([member.log_evidence for member in members]), settings.smallest_weight)
    kept = [index for index, weight in enumerate(weights) if weight > 0]
    return AveragedModel([members[index] for index in kept], weights[kept])
