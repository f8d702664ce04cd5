"""The averaged Gaussian process: a library of links, scales and sums of kernels, each weighted by its evidence.

A permutation test says whether chance could reach its score.

The response surface that chapter 2 suggests, as a baseline: six parameters on the logit of the yield.

    logit y = b0 + b1 R + b2 m + b3 m^2 + b4 ln t + b5 R m + e,
ball-to-powder ratio R, molar ratio m, time t: what Fig. 2.3 and Fig. 2.4 show, and nothing of the mill. It is fitted by
least squares (Box and Draper, Response Surfaces, Mixtures, and Ridge Analyses, 2nd ed. (2007), ch. 3), so that nothing
is searched and no choice is made from yields.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd
from scipy.special import expit, logit, logsumexp, ndtr

from millprint.config.yields import INPUTS, PRIMARY, AveragingConfig, LibraryTrialConfig
from millprint.estimate.quantiles import student_quantile
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.estimators import Process, fit_process, kernel_of
from millprint.thesis.yields.features import CHEMICAL, Standardisation, describe
from millprint.thesis.yields.regressors import AVERAGED

# Nodes and weights of the Gauss-Hermite quadrature, for means over a normal distribution.
NODES, _weights = np.polynomial.hermite_e.hermegauss(20)
NODE_WEIGHTS = _weights / _weights.sum()
BISECTIONS = 50
# Quantiles are searched between these conversions [-]; with the identity link they can be below 0 or above 1.
LOWEST, HIGHEST = -2.0, 3.0


@dataclass(frozen=True)
class Link:
    """A transformation z = forward(y) of the conversion y [-], with its inverse and log |dz/dy|.

    A process models z. The slope turns its likelihood into that of y, so that links can be compared.
    """

    forward: Callable[[np.ndarray], np.ndarray]
    inverse: Callable[[np.ndarray], np.ndarray]
    log_slope: Callable[[np.ndarray], np.ndarray]


LINKS = {
    "identity": Link(lambda y: np.asarray(y, dtype=float), lambda z: z, np.zeros_like),
    "logit": Link(logit, expit, lambda y: -np.log(y * (1 - y))),
    # Avrami's kinetics y = 1 - exp(-(k t)^n): ln(-ln(1 - y)) = n ln k + n ln t. Effects on the rate constant then add
    # up, and time enters as its logarithm.
    "avrami": Link(
        lambda y: np.log(-np.log1p(-y)),
        lambda z: -np.expm1(-np.exp(np.minimum(z, 30.0))),
        lambda y: -np.log(-(1 - y) * np.log1p(-y)),
    ),
}


def to_conversion(yields_percent: np.ndarray, margin: float) -> np.ndarray:
    """Yields (n,) [%] as conversions (n,) [-] from `margin` to 1 - `margin`: bounded links are infinite at 0 and 1."""
    return np.clip(np.asarray(yields_percent, dtype=float) / 100, margin, 1 - margin)


@dataclass(frozen=True)
class Candidate:
    """A member of the library before it is fitted; `scales` in the order of INPUTS."""

    link: str
    scales: tuple[str, ...]
    structure: str

    @property
    def logarithmic(self) -> np.ndarray:
        """Whether each input enters as its logarithm, (k,)."""
        return np.array([scale == "log" for scale in self.scales])


def library(settings: AveragingConfig) -> list[Candidate]:
    """Every combination of link, scales and structure."""
    scales = list(product(*(settings.scales[name] for name in INPUTS)))
    return [Candidate(*each) for each in product(settings.links, scales, settings.structures)]


@dataclass(frozen=True)
class Member:
    """A fitted member: z = (link(y) - mean) / spread is a Gaussian process of the standardised inputs."""

    candidate: Candidate
    standard: Standardisation
    mean: float
    spread: float
    process: Process
    log_evidence: float

    def latent(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of link(y), (n,) each, for inputs (n, k) that are not standardised."""
        mean, deviation = self.process.predict(self.standard(inputs))
        return self.mean + self.spread * mean, self.spread * deviation

    def expected(self, inputs: np.ndarray) -> np.ndarray:
        """Mean conversion (n,) [-] for inputs (n, k) that are not standardised."""
        return expected_conversion(self.candidate.link, *self.latent(inputs))

    def left_out(self) -> np.ndarray:
        """Mean conversion (n,) [-] of each training row given the others, with the hyper-parameters of all."""
        mean, deviation = self.process.left_out()
        return expected_conversion(self.candidate.link, self.mean + self.spread * mean, self.spread * deviation)


def share_below(link: str, conversion: np.ndarray, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Probability of a measured conversion of at most `conversion` [-]; mean, deviation: of link(y), same shape."""
    if link != "identity":
        inside = np.clip(conversion, 1e-12, 1 - 1e-12)
        below = ndtr((LINKS[link].forward(inside) - mean) / deviation)
        return np.where(conversion <= 0, 0.0, np.where(conversion >= 1, 1.0, below))
    return ndtr((conversion - mean) / deviation)


def expected_conversion(link: str, mean: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Mean conversion (n,) [-] for normal values of link(y) with these means and standard deviations, (n,) each."""
    return LINKS[link].inverse(mean[:, None] + deviation[:, None] * NODES) @ NODE_WEIGHTS


def fit_described(candidate: Candidate, raw: np.ndarray, yields: np.ndarray, settings: AveragingConfig) -> Member:
    """Fit one member on inputs (n, k), as described, and yields (n,) [%]; its evidence is that of the yields.

    Raises KeyError for an unknown link or structure.
    """
    conversion, link = to_conversion(yields, settings.margin), LINKS[candidate.link]
    smallest = np.array([settings.smallest_spread.get(name, 0.0) for name in INPUTS])
    standard = Standardisation.of(raw, candidate.logarithmic, smallest)
    latent = link.forward(conversion)
    mean, spread = float(latent.mean()), float(latent.std()) or 1.0
    process, evidence = fit_process(
        standard(raw), (latent - mean) / spread, kernel_of(candidate.structure), settings.priors
    )
    jacobian = float(link.log_slope(conversion).sum()) - len(latent) * np.log(spread)
    return Member(candidate, standard, mean, spread, process, evidence + jacobian)


def evidence_weights(log_evidences: np.ndarray, smallest: float) -> np.ndarray:
    """Posterior probabilities (m,) [-] of models of equal prior probability; those below `smallest` are set to zero."""
    weights = np.exp(log_evidences - logsumexp(log_evidences))
    kept = np.where(weights >= min(smallest, weights.max()), weights, 0.0)
    return kept / kept.sum()


@dataclass(frozen=True)
class AveragedModel:
    """A mixture of members with weights that add up to one."""

    members: list[Member]
    weights: np.ndarray

    name = AVERAGED
    strategy = PRIMARY
    distribution = "mixture"

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Mean yields (n,) [%] for rows with the six conditions."""
        inputs = describe(rows).to_numpy()
        shares = [weight * member.expected(inputs) for member, weight in zip(self.members, self.weights, strict=True)]
        return 100 * np.sum(shares, axis=0)

    def deviation(self, rows: pd.DataFrame) -> np.ndarray:
        """NaN (n,): the spread of a mixture is given by its quantiles, not by a standard deviation."""
        return np.full(len(rows), np.nan)

    def quantiles(self, rows: pd.DataFrame, levels: np.ndarray) -> np.ndarray:
        """Quantiles (n, levels) [%] of a measurement, within 0 and 100, by bisection of the mixture's distribution."""
        inputs = describe(rows).to_numpy()
        latent = [member.latent(inputs) for member in self.members]
        target = np.broadcast_to(np.asarray(levels, dtype=float), (len(rows), len(levels)))
        low, high = np.full(target.shape, LOWEST), np.full(target.shape, HIGHEST)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            below = np.zeros(target.shape)
            for member, weight, (mean, deviation) in zip(self.members, self.weights, latent, strict=True):
                below += weight * share_below(member.candidate.link, middle, mean[:, None], deviation[:, None])
            low, high = np.where(below < target, middle, low), np.where(below < target, high, middle)
        return 100 * np.clip((low + high) / 2, 0, 1)

    def intervals(self, rows: pd.DataFrame, levels: Sequence[float]) -> np.ndarray:
        """Ends (n, levels, 2) [%] of the central predictive intervals."""
        ends = [((1 - level) / 2, (1 + level) / 2) for level in levels]
        return self.quantiles(rows, np.ravel(ends)).reshape(len(rows), len(levels), 2)


def fit_library(rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> list[Member]:
    """Every member of the library, fitted on rows with the six conditions and yields (n,) [%], and nothing else."""
    raw = describe(rows).to_numpy()
    return [fit_described(candidate, raw, yields, settings) for candidate in library(settings)]


def average(members: list[Member], settings: AveragingConfig) -> AveragedModel:
    """The members weighted by their evidence."""
    weights = evidence_weights(np.array([member.log_evidence for member in members]), settings.smallest_weight)
    kept = np.flatnonzero(weights)
    return AveragedModel([members[index] for index in kept], weights[kept])


def fit_averaged(rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> AveragedModel:
    """The averaged process of rows with the six conditions and their yields (n,) [%], and of nothing else."""
    return average(fit_library(rows, yields, settings), settings)


def closed_form_r2(rows: pd.DataFrame, yields: np.ndarray, settings: AveragingConfig) -> float:
    """R2 of the average by leave-one-out in closed form; hyper-parameters and weights are those of all rows.

    Not an honest score, since every run has helped to set hyper-parameters and weights, but a fair statistic for a
    permutation test: each shuffle goes through the same. yields: (n,) [%].
    """
    model = average(fit_library(rows, yields, settings), settings)
    predicted = 100 * model.weights @ np.stack([member.left_out() for member in model.members])
    return float(1 - np.sum((yields - predicted) ** 2) / np.sum((yields - yields.mean()) ** 2))


def permute(
    rows: pd.DataFrame, settings: AveragingConfig, trial: LibraryTrialConfig, tick: Callable[[], None] = lambda: None
) -> pd.DataFrame:
    """closed_form_r2 of the measured yields and of shuffles of them: columns permutation (0: measured), r2.

    Shuffling keeps the yields and the conditions and takes away every relation between them.
    """
    yields, generator = rows[YIELD].to_numpy(float), np.random.default_rng(trial.seed)
    shuffles = [yields, *(generator.permutation(yields) for _ in range(trial.permutations))]
    found = []
    for shuffled in shuffles:
        found.append(closed_form_r2(rows, shuffled, settings))
        tick()
    return pd.DataFrame({"permutation": range(len(found)), "r2": found})


def permutation_p(table: pd.DataFrame) -> pd.DataFrame:
    """One row: measure, measured, permutations, median, highest, p.

    p = (1 + shuffles at least as good) / (1 + shuffles).

    Phipson and Smyth, Stat. Appl. Genet. Mol. Biol. 9 (2010) 39: the measured order is one of the possible ones, so p
    is never 0.
    """
    measured = float(table.loc[table["permutation"] == 0, "r2"].iloc[0])
    shuffled = table.loc[table["permutation"] > 0, "r2"].to_numpy()
    found = {
        "measure": "R2 by leave-one-out in closed form",
        "measured": measured,
        "permutations": len(shuffled),
        "median": float(np.median(shuffled)),
        "highest": float(shuffled.max()),
        "p": float((1 + (shuffled >= measured).sum()) / (1 + len(shuffled))),
    }
    return pd.DataFrame([found])


LINK = "logit"


def design(rows: pd.DataFrame) -> np.ndarray:
    """The terms of the surface (n, 6) for rows with bpr, molar_ratio [-] and time_h [h]."""
    ratio, molar, time = (rows[name].to_numpy(float) for name in CHEMICAL)
    return np.column_stack([np.ones(len(rows)), ratio, molar, molar**2, np.log(time), ratio * molar])


@dataclass(frozen=True)
class ResponseSurface:
    """A fitted surface: coefficients (6,), (X'X)^-1 (6, 6), residual standard deviation, and degrees of freedom."""

    coefficients: np.ndarray
    inverse: np.ndarray
    residual: float
    freedom: int

    def latent(self, rows: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation of the logit of a new measurement, (n,) each: s^2 (1 + x' (X'X)^-1 x)."""
        terms = design(rows)
        spread = np.sqrt(1 + np.einsum("ij,jk,ik->i", terms, self.inverse, terms))
        return terms @ self.coefficients, self.residual * spread

    def predict(self, rows: pd.DataFrame) -> np.ndarray:
        """Mean yields (n,) [%], as of the averaged process: over the distribution of the logit."""
        return 100 * expected_conversion(LINK, *self.latent(rows))

    def intervals(self, rows: pd.DataFrame, levels: list[float]) -> np.ndarray:
        """Ends (n, levels, 2) [%] of the prediction intervals by Student's t."""
        mean, deviation = self.latent(rows)
        half = student_quantile(0.5 + np.asarray(levels) / 2, self.freedom) * deviation[:, None]
        return 100 * LINKS[LINK].inverse(np.stack([mean[:, None] - half, mean[:, None] + half], axis=2))


def fit_surface(rows: pd.DataFrame, yields: np.ndarray, margin: float) -> ResponseSurface:
    """The surface of rows with the conditions and yields (n,) [%], n > 6; margin: as of `to_conversion`."""
    terms, target = design(rows), LINKS[LINK].forward(to_conversion(yields, margin))
    coefficients = np.linalg.lstsq(terms, target, rcond=None)[0]
    freedom, errors = len(target) - terms.shape[1], target - terms @ coefficients
    return ResponseSurface(
        coefficients, np.linalg.pinv(terms.T @ terms), float(np.sqrt(errors @ errors / freedom)), freedom
    )
