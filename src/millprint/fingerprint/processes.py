"""A Gaussian process of the logarithm of a scaled quantity: a curve over fill ratios, or over many conditions.

The covariance K (n, n) of a smooth process is nearly of low rank. A Cholesky factorisation that takes the condition of
largest remaining variance next stops once no condition has more than REMAINDER of the noise's variance left:
    K = V^T V + E, V (m, n), E positive semidefinite with a diagonal d of at most REMAINDER times the noise
(Harbrecht, Peters, Schneider, Applied Numerical Mathematics 62 (2012) 428). The remainder d is added to the noise, so
that intervals hold it (Snelson, Ghahramani, Adv. Neural Inf. Process. Syst. 18 (2006) 1257). Time grows with n m^2, not
with n^3.

If Eqs 3.28 and 3.29 held exactly, a scaled quantity would depend only on the fill ratio. The process takes that as
its mean behaviour and learns from the runs how far speed and ball size, amplitude and density shift it:
    log y = g(fill) + h(fill, speed, ball size) + a(fill, amplitude) + r(fill, density) + noise
each a Matern 5/2 process of logarithms. Far from what was simulated the departures return to zero, that is to the
scaling of the thesis, and the bands widen to the size of the departures elsewhere. Departures of amplitude and density
multiply those of speed and ball size: what a sweep finds at one speed is applied to the others.

There are two bands, from two variances of log y at a condition x. d(x) is the standard deviation of g + h + a + r given
the simulations, n the noise, and s2(x) the variance of one run due to its finite window:
    of the mean of very many simulations    d(x)^2
    of a new simulation, one run            d(x)^2 + n + s2(x)
Both are widened by one factor, the stretch, and Student's t gives their width in deviations.
s2(x) = exp(b0 + b1 ln fill) is fitted to the errors of all runs, because the error of one run, from a few turns, is
hardly known. The model is a generalised linear one with the gamma distribution, which a variance has. For the same
reason, the variance of each simulated value is half its own and half s2, a moderated variance (Smyth, Stat. Appl.
Genet. Mol. Biol. 3 (2004) 3) with equal degrees of freedom; of conditions whose seeds differ, it is its own, and that
of the others is moderated without them.

The curve is for between. At a condition that was simulated with k seeds, the value is the mean y of these simulations,
with the moderated variance e^2 of this mean:
    of the mean of very many simulations    e^2
    of a new simulation                     e^2 + k e^2
One seed cannot show that a motion may last in several ways; so with k = 1 the noise n counts in addition, as noise
between runs, twice for a new simulation, and the stretch widens both.

Where several kinds of balls were simulated, such as balls of one size and a charge of several sizes, each kind has a
separate departure q(fill), independent of the others.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.linalg import cholesky, solve_triangular

from millprint.config.charge import ONE_SIZE
from millprint.estimate.gaussian_process import Conditioned, Covariance, Inverse, Kernel, Likelihood
from millprint.estimate.quantiles import student_quantile
from millprint.fingerprint.descriptors import CHARGE
from millprint.observables.condition import VARIABLES

# Above this number of conditions the process is reduced; the thesis's fingerprints have fewer.
WHOLE_MAX = 500
# The largest part of a condition's variance that may be left out, over the noise variance [-]; and the largest number
# of conditions taken.
REMAINDER, TAKEN_MAX = 1e-5, 2000
TRIANGLES = ("corner", "lower")


@dataclass(frozen=True)
class Reduced:
    """A process of n conditions, reduced to m of them.

    taken: the chosen inputs (m, k); corner (m, m): the lower triangle whose square is their covariance; factor (m, n):
    V; noise (n,): variances with what is left out; lower (m, m): the root of 1 + V noise^-1 V^T; weights (m,).
    """

    kernel: Covariance
    taken: np.ndarray
    corner: np.ndarray
    factor: np.ndarray
    noise: np.ndarray
    lower: np.ndarray
    weights: np.ndarray

    @classmethod
    def fit(cls, kernel: Covariance, inputs: np.ndarray, values: np.ndarray, noise: np.ndarray) -> "Reduced":
        """From inputs (n, k), values about their mean (n,) and the variances of their noise (n,)."""
        factor, order, left = pivoted(kernel, inputs, REMAINDER * float(noise.min()))
        total = noise + left
        scaled = factor / np.sqrt(total)
        lower = cholesky(np.eye(len(order)) + scaled @ scaled.T, lower=True)
        weights = solve_triangular(lower, factor @ (values / total), lower=True)
        return cls(kernel, inputs[order], factor[:, order].T, factor, total, lower, weights)

    def mean(self, inputs: np.ndarray) -> np.ndarray:
        """Values (j,) at inputs (j, k)."""
        return self._told(inputs)[0]

    def with_deviation(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their standard deviations (j,) without noise."""
        mean, known, told = self._told(inputs)
        variance = self.kernel.diag(inputs) - (known**2).sum(axis=0) + (told**2).sum(axis=0)
        return mean, np.sqrt(np.maximum(variance, 0.0))

    def with_covariance(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Values (j,) at inputs (j, k), and their covariance (j, j) without noise."""
        mean, known, told = self._told(inputs)
        return mean, self.kernel(inputs) - known.T @ known + told.T @ told

    def _told(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values (j,), and the covariance with the conditions taken, whitened without noise and with noise (m, j)."""
        known = solve_triangular(self.corner, self.kernel(self.taken, inputs), lower=True)
        told = solve_triangular(self.lower, known, lower=True)
        return self.weights @ told, known, told

    def to_dict(self) -> dict:
        """What predictions need, as plain values; triangles row by row, without what is above the diagonal."""
        rows = {name: [own[: k + 1].tolist() for k, own in enumerate(getattr(self, name))] for name in TRIANGLES}
        return {"taken": self.taken.tolist(), "weights": self.weights.tolist(), **rows}

    def inverse(self) -> "ReducedInverse":
        """The inverse of the covariance of all values, noise included."""
        return ReducedInverse(1 / self.noise, solve_triangular(self.lower, self.factor / self.noise, lower=True))


def pivoted(kernel: Covariance, inputs: np.ndarray, enough: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """V (m, n), the places of the conditions taken (m,), and the variance that each condition has left (n,).

    enough: the largest variance that may be left; with TAKEN_MAX conditions taken, more may be.
    """
    left = kernel.diag(inputs).copy()
    rows = np.empty((min(TAKEN_MAX, len(inputs)), len(inputs)))
    order: list[int] = []
    while len(order) < len(rows) and left.max() > enough:
        place, done = int(left.argmax()), len(order)
        row = kernel(inputs[place : place + 1], inputs)[0] - rows[:done, place] @ rows[:done]
        rows[done] = row / np.sqrt(left[place])
        # Exactly zero for the conditions taken before, so that rounding leaves no trace in the corner.
        rows[done, order] = 0.0
        left = np.maximum(left - rows[done] ** 2, 0.0)
        order.append(place)
        left[order] = 0.0
    return rows[: len(order)].copy(), np.array(order), left


@dataclass(frozen=True)
class ReducedInverse:
    """diag(precision) - W^T W, with precision (n,) and W (m, n)."""

    precision: np.ndarray
    root: np.ndarray

    def times(self, vector: np.ndarray) -> np.ndarray:
        """The inverse times a vector (n,)."""
        return self.precision * vector - self.root.T @ (self.root @ vector)

    def block(self, places: np.ndarray) -> np.ndarray:
        """Its rows and columns at some places (j, j)."""
        own = self.root[:, places]
        return np.diag(self.precision[places]) - own.T @ own


# Component -> its variables in addition to the fill ratio, and the start and bounds of its variance.
COMPONENTS = {
    "fill": ((), 0.1, (0.04, 10.0)),  # curves vary by 20 % or more
    "machine": (("speed_hz", "ball_diameter_m"), 0.02, (1e-4, 0.5)),
    "amplitude": (("amplitude_m",), 0.02, (1e-4, 2.0)),
    "density": (("density_kg_m3",), 1e-3, (1e-5, 0.5)),
    CHARGE: ((CHARGE,), 0.02, (1e-4, 0.5)),
}
# Bounds of lengths, in logarithms: a curve turns within a factor exp(0.3) to exp(3) of fill ratio, a departure within
# a factor 2 to 1000 of a machine's variable.
FILL_LENGTH, MACHINE_LENGTH = (0.3, 3.0), (0.7, 7.0)
# What is supposed of a length before any simulation: its middle, and the deviation of its logarithm. A few conditions
# cannot tell it, and their likelihood is largest for curves that go back to the mean between two of them.
SUPPOSED = {FILL_LENGTH: (1.2, 0.4), MACHINE_LENGTH: (3.0, 0.6)}
NOISE, NOISE_BOUNDS = 1e-3, (1e-5, 0.05)
IDLE = 1e5  # length of a variable that a component does not depend on
# The likelihood of n conditions costs n^3 per trial. Above this number of conditions, a random choice of this number
# gives the parameters; all conditions give the predictions.
LEARNT_FROM = 250
NO_SAMPLING = (-40.0, 0.0)  # b0, b1 of runs that state no error
SCORINGS = 30  # iterations at most in the search for b0 and b1, which needs a few
# Conditions are the same within this difference of logarithms: tables have fewer digits than fingerprints.
SAME = 1e-5
JITTER = 1e-10  # keeps a covariance of almost equal conditions invertible
# What is left out together -> the variables that these conditions share.
LEFT_OUT = {
    "condition": ["fill_ratio", "speed_hz", "ball_diameter_m", "density_kg_m3", "amplitude_m", CHARGE],
    "fill ratio": ["fill_ratio"],
    "setting": ["speed_hz", "ball_diameter_m", "density_kg_m3", "amplitude_m", CHARGE],
}
APART = 0.01  # length scale between kinds of balls, whose places differ by 1: no two are correlated


def kinds_of(charges: Iterable[str]) -> list[str]:
    """The kinds of balls by the names of their charges, if there are several; an empty list if all are of one kind."""
    found = sorted(set(charges))
    return found if len(found) > 1 else []


def logarithms(table: pd.DataFrame, kinds: Sequence[str] = ()) -> np.ndarray:
    """`log_rows` of a table that has VARIABLES and, if there are charges, CHARGE."""
    charges = table[CHARGE] if CHARGE in table else [ONE_SIZE] * len(table)
    return log_rows(table[list(VARIABLES)].to_numpy(dtype=float), charges, kinds)


def log_rows(values: np.ndarray, charges: Iterable[str], kinds: Sequence[str]) -> np.ndarray:
    """Logarithms (n, 5) of VARIABLES; with `kinds`, (n, 6), the last the place of the row's charge among the kinds.

    A charge that is not among them has the place -1, which is uncorrelated with every kind.
    """
    logs = np.log(values)
    if not kinds:
        return logs
    places = [kinds.index(charge) if charge in kinds else -1 for charge in charges]
    return np.column_stack([logs, np.array(places, dtype=float)])


def varied_components(table: pd.DataFrame) -> dict[str, list[str]]:
    """Component -> its variables that vary between the conditions of `table`; a departure needs at least one."""
    varied = [name for name in (*VARIABLES, CHARGE) if name in table and table[name].nunique() > 1]
    found = {name: [v for v in others if v in varied] for name, (others, *_) in COMPONENTS.items()}
    return {name: ["fill_ratio", *others] for name, others in found.items() if others or name == "fill"}


def held(length: float) -> tuple[float, tuple[float, float]]:
    """A length and bounds that hold it there."""
    return length, (length, length * (1 + 1e-9))


# Start and bounds of the length of a variable that a component depends on; others: as a machine's variable.
LENGTHS = {"fill_ratio": (1.0, FILL_LENGTH), CHARGE: held(APART)}


def kernel_of(components: Mapping[str, object], inputs: int) -> Kernel:
    """A Matern 5/2 term for each component; theta: for each, the logarithms of its variance and of its lengths (k,)."""
    first = np.arange(len(components)) * (1 + inputs)
    lengths = first[:, None] + np.arange(1, 1 + inputs)
    return Kernel(("Matern 5/2",) * len(components), first, lengths)


def searched(components: Mapping[str, Sequence[str]], inputs: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts (p,) and bounds (p, 2) of theta with the noise, and the middle and deviation (p, 2) that is supposed.

    The deviation of a variance, and of a length that is held at IDLE or APART, is infinite.
    """
    rows = []
    for name, variables in components.items():
        _, variance, bounds = COMPONENTS[name]
        rows.append((variance, bounds, (1.0, np.inf)))
        for variable in (*VARIABLES, CHARGE)[:inputs]:
            start, own = LENGTHS.get(variable, (2.0, MACHINE_LENGTH)) if variable in variables else held(IDLE)
            rows.append((start, own, SUPPOSED.get(own, (1.0, np.inf))))
    rows.append((NOISE, NOISE_BOUNDS, (1.0, np.inf)))
    starts, ends, supposed = (np.array(column) for column in zip(*rows, strict=True))
    return np.log(starts), np.log(ends), supposed


def grouped(inputs: np.ndarray, shared: list[str]) -> list[np.ndarray]:
    """Indices of the conditions that have equal values of the variables `shared`."""
    known = (*VARIABLES, CHARGE)[: inputs.shape[1]]
    frame = pd.DataFrame(inputs.round(9), columns=known)
    shared = [name for name in shared if name in known]
    return [np.asarray(index) for index in frame.groupby(shared, sort=True).indices.values()]


def band_width(probability: float, conditions: int) -> float:
    """Half the width of a band in deviations: Student's quantile, with the scale from this number of conditions."""
    return float(student_quantile(0.5 + 0.5 * probability, max(1, conditions - 1)))


def fit_sampling(log_fills: np.ndarray, variances: np.ndarray) -> tuple[float, float]:
    """b0 and b1 of the variance of the logarithm of one run, s2 = exp(b0 + b1 ln fill).

    log_fills: ln of fill ratios (n,); variances: of one run at each, from its turns (n,), NaN where not known.
    """
    known = np.isfinite(variances) & (variances > 0)
    if not known.any():
        return NO_SAMPLING
    values = variances[known]
    level, slope = float(np.log(values.mean())), 0.0
    if np.ptp(log_fills[known]) < 1e-9:
        return level, slope
    # Fisher's scoring (McCullagh, Nelder, Generalized Linear Models, 1989), in which all weights are one.
    centre = log_fills[known].mean()
    design = np.column_stack([np.ones(len(values)), log_fills[known] - centre])
    for _ in range(SCORINGS):
        excess = values / np.exp(design @ [level, slope]) - 1
        step = np.clip(np.linalg.lstsq(design, excess, rcond=None)[0], -1, 1)
        level, slope = level + float(step[0]), slope + float(step[1])
    return level - slope * float(centre), slope


def variance_of_run(inputs: np.ndarray, sampling: tuple[float, float]) -> np.ndarray:
    """Variance s2 (m,) of the logarithm of one run due to its window, at inputs (m, 5)."""
    return np.exp(sampling[0] + sampling[1] * inputs[:, 0])


class Told(NamedTuple):
    """Log values (m,), and the standard deviations (m,) of the mean and of a new simulation."""

    logs: np.ndarray
    of_mean: np.ndarray
    of_new: np.ndarray


@dataclass(frozen=True)
class Process:
    """One quantity: inputs (n, 5 or 6) of `logarithms`, logarithms of values (n,), their relative standard errors (n,).

    components and theta (the kernel's logarithmic parameters) describe the kernel; noise is the variance of log
    values between runs that no variable explains; sampling: b0 and b1 of the variance of one run due to its window;
    stretch: factor on every deviation, found by leaving conditions out; seeds: of each condition (n,), 1 if left out;
    apart: what was simulated in conditions that the curve leaves out.
    """

    inputs: np.ndarray
    logs: np.ndarray
    errors: np.ndarray
    components: dict[str, list[str]]
    theta: np.ndarray
    noise: float
    sampling: tuple[float, float] = NO_SAMPLING
    stretch: float = 1.0
    seeds: np.ndarray | None = None
    apart: "Process | None" = None

    @classmethod
    def fit(
        cls,
        inputs: np.ndarray,
        logs: np.ndarray,
        stated: np.ndarray,
        components: dict,
        runs: np.ndarray | int = 1,
        differ: np.ndarray | bool = False,
    ) -> "Process":
        """Parameters of largest marginal likelihood, and the stretch found by leaving conditions out.

        stated: relative standard errors of the values from their windows and seeds (n,), NaN where not known; runs:
        number of seeds in the mean of each value; differ: whether they differ by more than their windows explain.

        stretch = max(1, root mean square of the standardised errors), as in Bachoc, Comput. Stat. Data Anal. 66
        (2013) 55, the largest over the ways of LEFT_OUT: the likelihood gives too small deviations where the model is
        not quite right. Of more than LEARNT_FROM conditions, LEARNT_FROM give the parameters, and all give the stretch.
        """
        sampling = fit_sampling(inputs[:, 0], runs * stated**2)
        # Seeds of several lasting motions say nothing of the windows of other conditions, and their error is their own.
        own = np.isfinite(stated) & differ
        seen = np.where(own, np.nan, runs * stated**2)
        typical = variance_of_run(inputs, fit_sampling(inputs[:, 0], seen))
        if np.isfinite(seen).any():
            typical = np.clip(typical, np.nanmin(seen), np.nanmax(seen))
        typical = typical / runs
        moderated = np.where(np.isfinite(stated), (stated**2 + typical) / 2, typical)
        errors = np.where(own, stated, np.sqrt(moderated))
        known = (inputs, logs, errors)
        if len(logs) > LEARNT_FROM:
            chosen = np.random.default_rng(0).permutation(len(logs))[:LEARNT_FROM]
            known = (inputs[chosen], logs[chosen], errors[chosen])
        kernel = kernel_of(components, inputs.shape[1])
        start, bounds, supposed = searched(components, inputs.shape[1])
        likelihood = Likelihood(
            kernel, known[0], known[1] - known[1].mean(), known[2] ** 2 + JITTER,
            np.log(supposed[:, 0]), supposed[:, 1] ** -2.0,
        )  # fmt: skip
        # A few conditions may be told either as noise or as departures: both are tried.
        quiet = np.append(start[:-1], bounds[-1, 0])
        found, _ = likelihood.maximise([start, quiet], bounds)
        theta, noise = found[:-1], float(np.exp(found[-1]))
        seeds = np.broadcast_to(runs, logs.shape)
        process = cls(inputs, logs, errors, components, theta, noise, sampling, seeds=seeds)
        inverse, apart = process.inverse(), []
        for shared in LEFT_OUT.values():
            groups = grouped(inputs, shared)
            if len(groups) > 1:
                means, deviations = process.leave_out(groups, inverse)
                apart.append((logs[np.concatenate(groups)] - means) / deviations)
        squares = np.concatenate(apart) ** 2 if apart else np.ones(1)
        return replace(process, stretch=max(1.0, float(np.sqrt(squares.mean()))))

    def with_apart(self, inputs: np.ndarray, logs: np.ndarray, stated: np.ndarray, seeds: np.ndarray) -> "Process":
        """The process with conditions (k,) that its curve leaves out; stated: their errors, as of `fit`."""
        errors = np.where(np.isfinite(stated), stated, np.sqrt(variance_of_run(inputs, self.sampling) / seeds))
        return replace(self, apart=replace(self, inputs=inputs, logs=logs, errors=errors, seeds=seeds))

    def _kernel(self) -> Covariance:
        return Covariance(kernel_of(self.components, self.inputs.shape[1]), self.theta)

    def predictor(self) -> "Predictor":
        """A predictor of new conditions."""
        centre = float(self.logs.mean())
        kind = Reduced if len(self.logs) > WHOLE_MAX else Conditioned
        known = kind.fit(self._kernel(), self.inputs, self.logs - centre, self._noise())
        inputs, simulated = self.inputs, self._simulated()
        if self.apart:
            inputs = np.vstack([inputs, self.apart.inputs])
            simulated = Told(*map(np.concatenate, zip(simulated, self.apart._simulated(), strict=True)))
        return Predictor(known, centre, self.noise, self.sampling, self.stretch, inputs, simulated)

    def _simulated(self) -> Told:
        """What is known of the conditions that were simulated."""
        seeds = np.ones_like(self.logs) if self.seeds is None else self.seeds
        alone = seeds == 1
        lasting, factor = np.where(alone, self.noise, 0.0), np.where(alone, self.stretch, 1.0)
        of_mean = self.errors**2 + lasting
        of_new = of_mean + seeds * self.errors**2 + lasting
        return Told(self.logs, factor * np.sqrt(of_mean), factor * np.sqrt(of_new))

    def _noise(self) -> np.ndarray:
        """The variances of the log values as measured (n,)."""
        return self.errors**2 + self.noise + JITTER

    def inverse(self) -> Inverse | ReducedInverse:
        """The inverse of the covariance of the log values, noise included."""
        if len(self.logs) > WHOLE_MAX:
            return Reduced.fit(self._kernel(), self.inputs, self.logs - self.logs.mean(), self._noise()).inverse()
        return Conditioned.fit(self._kernel(), self.inputs, self.logs, self._noise()).inverse()

    def leave_out(
        self, groups: Sequence[np.ndarray], inverse: Inverse | ReducedInverse | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation of the measured log values of each group of indices, predicted without that group.

        The result has the groups one after another. With Q the inverse of the covariance of all log values y, noise
        included, and c the mean of the values that are kept, y_B - mean = Q_BB^-1 [Q (y - c)]_B with the covariance
        Q_BB^-1 (Dubrule, Math. Geol. 15 (1983) 687). One inverse serves all groups.

        inverse: the result of `inverse()`, if it is needed more than once; computed here if left out.
        """
        inverse = inverse or self.inverse()
        weighted, sums = inverse.times(self.logs), inverse.times(np.ones(len(self.logs)))
        means, deviations = [], []
        for left in groups:
            centre = (self.logs.sum() - self.logs[left].sum()) / (len(self.logs) - len(left))
            own = np.linalg.inv(inverse.block(left))
            means.append(self.logs[left] - own @ (weighted[left] - centre * sums[left]))
            # The jitter is not part of the measured values.
            deviations.append(self.stretch * np.sqrt(np.diag(own) - JITTER))
        return np.concatenate(means), np.concatenate(deviations)

    def to_dict(self) -> dict:
        """Parameters and data as plain values."""
        return {
            "components": self.components,
            "log_parameters": self.theta.tolist(),
            "noise_variance": float(self.noise),
            "sampling": list(self.sampling),
            "stretch": float(self.stretch),
            **self._values(),
            **({"apart": self.apart._values()} if self.apart else {}),
        }

    def _values(self) -> dict[str, list[float]]:
        """What was simulated, as plain values."""
        return {
            "values": np.exp(self.logs).tolist(),
            "relative_errors": self.errors.tolist(),
            **({} if self.seeds is None else {"seeds": self.seeds.tolist()}),
        }

    @classmethod
    def from_dict(cls, content: dict, inputs: np.ndarray, apart: np.ndarray) -> "Process":
        """The process that `to_dict` described; apart: inputs of what the curve leaves out."""
        found = cls(
            inputs=inputs,
            **cls._simulated_in(content),
            components=content["components"],
            theta=np.array(content["log_parameters"], dtype=float),
            noise=float(content["noise_variance"]),
            sampling=tuple(content["sampling"]),
            stretch=float(content["stretch"]),
        )
        if "apart" not in content:
            return found
        return replace(found, apart=replace(found, inputs=apart, **cls._simulated_in(content["apart"])))

    @staticmethod
    def _simulated_in(content: dict) -> dict[str, Any]:
        """The fields that `_values` described."""
        return {
            "logs": np.log(np.array(content["values"], dtype=float)),
            "errors": np.array(content["relative_errors"], dtype=float),
            "seeds": np.array(content["seeds"]) if "seeds" in content else None,
        }


@dataclass(frozen=True)
class Predictor:
    """What is known of log values about their mean: of a curve, and of the conditions `inputs` that were simulated."""

    known: Conditioned | Reduced
    centre: float
    noise: float
    sampling: tuple[float, float]
    stretch: float
    inputs: np.ndarray
    simulated: Told

    def mean(self, inputs: np.ndarray) -> np.ndarray:
        """Log values (m,) at inputs (m, 5)."""
        return self.centre + self.known.mean(inputs)

    def curve(self, inputs: np.ndarray) -> Told:
        """Log values (m,) of the curve at inputs (m, 5) with the deviations of both bands."""
        mean, deviation = self.known.with_deviation(inputs)
        one_run = self.noise + variance_of_run(inputs, self.sampling)
        return Told(self.centre + mean, self.stretch * deviation, self.stretch * np.sqrt(deviation**2 + one_run))

    def nearest(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The place (m,) of the nearest condition that was simulated, and whether (m,) it is that of the inputs."""
        apart = np.abs(inputs[:, None] - self.inputs).max(axis=2)
        return apart.argmin(axis=1), apart.min(axis=1) < SAME

    def predict(self, inputs: np.ndarray) -> Told:
        """As `curve`, but at a condition that was simulated what was simulated: the one place that defines both."""
        place, is_known = self.nearest(inputs)
        told = zip(self.simulated, self.curve(inputs), strict=True)
        return Told(*(np.where(is_known, own[place], between) for own, between in told))

    def joint(self, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Log values (m,) and the covariance (m, m) of their mean: the uncertainty of the curve, not of a new run."""
        mean, covariance = self.known.with_covariance(inputs)
        return self.centre + mean, self.stretch**2 * covariance

    def reduced(self) -> dict:
        """What a reduced process needs for predictions, as plain values; raises TypeError for a whole one."""
        if not isinstance(self.known, Reduced):
            raise TypeError("a process of all its conditions has nothing that is reduced")
        return {**self.known.to_dict(), "centre": self.centre}
