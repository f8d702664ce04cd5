"""The samples behind the intervals of a mill: contact parameters from their distributions, a simulation of each.

An emulator: a Gaussian process that replaces the simulation between the points of a design.

The logarithm y of a quantity is m + g(x) + noise. g is a Matern 5/2 process with a length for each variable; the noise
is the scatter of a simulation with other starting positions. Draws of g show what the design leaves uncertain.

Saltelli's sample (SALib) is evaluated by such draws, so that Sobol indices and intervals include that (Le Gratiet,
Cannamela, Iooss, SIAM/ASA J. Uncertainty Quantif. 2 (2014) 336).
"""

import json
import logging
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from SALib.analyze import sobol as sobol_analysis
from SALib.sample import sobol as sobol_sample
from scipy import stats
from scipy.linalg import cholesky
from scipy.stats import qmc

from millprint.cases.of_mill import fill_ratios_of
from millprint.cases.simulate import simulate_each
from millprint.config.contact_set import NOMINAL_SPEED_M_S, ContactConfig, law_fields
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import (
    PARAMETERS,
    DistributionSection,
    Parameter,
    ParametersSection,
    UncertaintyConfig,
)
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.sweep import Case, DemConfig
from millprint.config.workflow import WorkflowConfig
from millprint.dem.run import simulate
from millprint.estimate.gaussian_process import Conditioned, Covariance, Kernel, Likelihood
from millprint.estimate.quantiles import normal_quantile
from millprint.fingerprint.descriptors import tabulate_descriptors

# Normal distributions are cut off here, so that a design covers only the values that matter.
MOST_DEVIATIONS = 3.0
FILL = "fill_ratio"
# Places may exceed the range by this, due to rounding or a whole number of balls.
NEAR = 0.05


def _cut_normal(mean: float, deviation: float, low: float, high: float) -> Any:
    ends = np.clip((np.array([low, high]) - mean) / deviation, -MOST_DEVIATIONS, MOST_DEVIATIONS)
    if ends[0] >= ends[1]:
        raise ConfigError(f"mean = {mean:g}: no value within {MOST_DEVIATIONS:g} standard deviations is possible")
    return stats.truncnorm(*ends, loc=mean, scale=deviation)


def _measured(section: Any, low: float, high: float) -> Any:
    if section.value is not None:
        return _cut_normal(section.value, section.standard_error, low, high)
    half = normal_quantile(0.5 + 0.5 * section.probability)
    return _cut_normal((section.lower + section.upper) / 2, (section.upper - section.lower) / 2 / half, low, high)


# By kind: a function of the section and the range that returns a frozen distribution of scipy.
FROZEN: dict[str, Callable[[Any, float, float], Any]] = {
    "uniform": lambda section, low, high: stats.uniform(low, high - low),
    "loguniform": lambda section, low, high: stats.loguniform(low, high),
    "triangular": lambda section, low, high: stats.triang((section.mode - low) / (high - low), low, high - low),
    "measured": _measured,
}


@dataclass(frozen=True)
class Variable:
    """One variable: its frozen, bounded distribution of scipy, and whether its range spans a power of ten."""

    name: str
    distribution: Any
    logarithmic: bool

    @property
    def ends(self) -> tuple[float, float]:
        """The smallest and the largest value."""
        low, high = self.distribution.support()
        return float(low), float(high)

    def values(self, shares: np.ndarray) -> np.ndarray:
        """The values below which these shares of the probability lie."""
        return np.clip(self.distribution.ppf(shares), *self.ends)

    def places(self, values: np.ndarray) -> np.ndarray:
        """Values scaled to 0 and 1 at the ends, in logarithms if the variable is logarithmic."""
        low, high = self.ends
        if self.logarithmic:
            return np.log(np.asarray(values, dtype=float) / low) / np.log(high / low)
        return (np.asarray(values, dtype=float) - low) / (high - low)


def variable_of(name: str, section: DistributionSection, parameter: Parameter) -> Variable:
    """The variable of a section of the configuration. Raises ConfigError for a distribution without possible values."""
    low, high = section.given_range
    low, high = parameter.lowest if low is None else low, parameter.highest if high is None else high
    try:
        return Variable(name, FROZEN[section.kind](section, low, high), section.kind == "loguniform")
    except ConfigError as error:
        raise ConfigError(f"uncertainty.parameters.{name}: {error}") from None


@dataclass(frozen=True)
class Space:
    """Independent variables."""

    variables: tuple[Variable, ...]

    @property
    def names(self) -> list[str]:
        """The names of the variables."""
        return [variable.name for variable in self.variables]

    def values(self, shares: np.ndarray) -> pd.DataFrame:
        """Values (n rows, a column a variable) from shares of the probability (n, variables)."""
        columns = zip(self.variables, np.asarray(shares).T, strict=True)
        return pd.DataFrame({variable.name: variable.values(column) for variable, column in columns})

    def places(self, table: pd.DataFrame) -> np.ndarray:
        """Places (n, variables) between 0 and 1 of the values in a table.

        Raises ConfigError for a value outside the range of its variable, where nothing was simulated.
        """
        found = np.column_stack([variable.places(table[variable.name].to_numpy()) for variable in self.variables])
        for variable, column in zip(self.variables, found.T, strict=True):
            outside = (column < -NEAR) | (column > 1 + NEAR) | ~np.isfinite(column)
            if outside.any():
                value, (low, high) = table[variable.name].to_numpy()[outside.argmax()], variable.ends
                raise ConfigError(
                    f"{variable.name} = {value:g}: outside the range {low:g} to {high:g} that is simulated; nothing is "
                    "extrapolated"
                )
        return found

    def design(self, samples: int, seed: int) -> pd.DataFrame:
        """A space-filling design: the first `samples` points of a scrambled Sobol sequence, by their quantiles.

        Owen, J. Complexity 14 (1998) 466. A larger design with the same seed begins with the smaller one.
        """
        sequence = qmc.Sobol(len(self.variables), scramble=True, rng=np.random.default_rng(seed))
        # A power of two keeps the sequence balanced; the excess points are dropped.
        return self.values(sequence.random_base2((samples - 1).bit_length())[:samples])


def contact_space(parameters: ParametersSection) -> Space:
    """The space of the contact parameters. Raises ConfigError as `variable_of`."""
    return Space(tuple(variable_of(name, section, PARAMETERS[name]) for name, section in parameters.items()))


def with_fill(space: Space, fill_ratios: list[float]) -> Space:
    """The space with the fill ratio as one more variable, from the smallest to the largest, uniform in logarithm."""
    fill = Variable(FILL, stats.loguniform(min(fill_ratios), max(fill_ratios)), logarithmic=True)
    return Space((*space.variables, fill))


def with_sweep(mill: dict, sweep: dict | None, derived: str | Path | None) -> MillConfig:
    """A mill from plain values, with its own sweep or the sweep from the file that was derived from it."""
    content = json.loads(Path(derived).read_text()) if derived else sweep
    return MillConfig(**mill).model_copy(update={"sweep": content and MillSweepConfig(**content)})


def contact_values(contact: ContactConfig) -> dict[str, float]:
    """The varied parameters of a contact set, at the nominal speed those that depend on the speed of the hit.

    If the set has no friction at walls, it is that between balls.
    """
    found = {name: getattr(contact.at_speed(NOMINAL_SPEED_M_S), name, None) for name in PARAMETERS}
    friction = contact.value_of("static_friction")
    return {name: friction if value is None else value for name, value in found.items()}


def space_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> Space:
    """Contact parameters and fill ratio. Raises ConfigError for a distribution without possible values."""
    return with_fill(contact_space(uncertainty.parameters), fill_ratios_of(mill, uncertainty))


def check_contact(space: Space, contact: ContactConfig) -> None:
    """Raise ConfigError, in one line, if the contact set of the predictions is outside the distributions.

    Likewise for one whose law lacks a key that is a variable.
    """
    for name in PARAMETERS:
        if name in law_fields() and not name.startswith("wall_"):
            contact.value_of(name)
    values = contact_values(contact)
    for variable in space.variables:
        low, high = variable.ends
        if variable.name in values and not low <= values[variable.name] <= high:
            raise ConfigError(
                f"uncertainty.parameters.{variable.name}: {low:g} to {high:g} leaves out {values[variable.name]:g} of "
                f"contact set {contact.name}, whose predictions get the intervals; widen the distribution, or set "
                "mills.contact to a set of your own values"
            )


def uncertainty_faults(
    config: WorkflowConfig, mills: dict[str, MillConfig], contacts: dict[str, ContactConfig], source: str
) -> Iterator[str]:
    """A line for each fault, with file, key, value and what to write; none if everything is valid."""
    settings = config.uncertainty
    if not settings.mills:
        return
    if settings.rayleigh_fraction > config.dem.rayleigh_fraction_max:
        yield (
            f"{source}: uncertainty.rayleigh_fraction = {settings.rayleigh_fraction:g}: at most "
            f"{config.dem.rayleigh_fraction_max:g} (dem.rayleigh_fraction_max)"
        )
    for name in settings.mills:
        try:
            check_contact(space_of(mills[name], settings), contacts[config.mills.contact_set])
        except ConfigError as error:
            yield f"{source}: {error}"


def design_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> pd.DataFrame:
    """The samples of a mill: contact parameters, fill ratio, and a seed of the starting positions for each."""
    design = space_of(mill, uncertainty).design(uncertainty.samples, uncertainty.seed)
    return design.assign(seed=range(len(design)))


Settings = TypeVar("Settings", Case, ContactConfig)

logger = logging.getLogger("millprint")

# Added to the columns of the samples: the fill ratio as simulated, with a whole number of balls.
FILLED = "filled_ratio"


def run_samples(
    case: Case,
    mill: MillConfig,
    contact: ContactConfig,
    dem: DemConfig,
    samples: pd.DataFrame,
    counting_rule: str,
    done: str | Path | None = None,
    title: str = "samples",
) -> pd.DataFrame:
    """Simulate a case once for each row of `samples`, in this process, and return the descriptors.

    samples: its index names the samples; each column is a key of a contact set (restitution, static_friction,
    wall_static_friction, rolling_friction, young_modulus_gpa, ...) or of a case (fill_ratio, speed_hz, seed, ...), and
    replaces the value of `contact` or `case`. counting_rule: a name in dem.counting_rules, defines one collision.
    done: a file that collects simulated rows and from which a killed call with the same arguments continues
    (`simulate_each`); the caller removes it once the table is written.

    Returns a row for each sample, in their order: the columns of `samples`, filled_ratio (of a whole number of balls),
    and every column of workflow/descriptors.md (powers in W, specific powers and frequency, standard errors).
    Raises ValueError for an unknown column, and SimulationError, with the sample and its values, if one fails.
    """
    unknown = [name for name in samples if name not in ContactConfig.model_fields and name not in Case.model_fields]
    if unknown:
        raise ValueError(f"samples: {', '.join(unknown)}: no key of a contact set or of a case")
    named = {
        f"sample {index} ({_in_words(values)})": values
        for index, values in zip(samples.index, samples.to_dict("records"), strict=True)
    }
    rows = simulate_each(
        named,
        lambda values: _describe(case, mill, contact, dem, values, counting_rule),
        (case, mill, contact, dem, counting_rule),
        title,
        done,
    )
    return pd.DataFrame([{**named[name], **row} for name, row in rows.items()], index=samples.index)


def _in_words(values: dict) -> str:
    return ", ".join(f"{key} = {value:g}" for key, value in values.items())


def _describe(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, values: dict, rule: str) -> dict:
    """The descriptors of one sample."""
    balls, own = _with(contact, values), _with(case, values)
    summary = simulate(own, mill, balls, dem)
    row = tabulate_descriptors([summary], rule).iloc[0].to_dict()
    logger.info("%d balls in %.1f s", summary["balls"], summary["wall_clock_s"])
    ball_m3 = np.pi / 6 * summary["ball_diameter_m"] ** 3
    return {**_plain(row), FILLED: summary["balls"] * ball_m3 / summary["nominal_volume_m3"]}


def _with(section: Settings, values: dict) -> Settings:
    """A contact set or a case with the values that it has keys for; a table over speed has them at the nominal one."""
    own = {key: value for key, value in values.items() if key in type(section).model_fields}
    if isinstance(section, ContactConfig):
        own = section.rescaled(own)
    return type(section)(**{**section.model_dump(), **own})


def _plain(row: dict) -> dict:
    """A row with Python numbers, as JSON needs them."""
    return {key: value.item() if isinstance(value, np.generic) else value for key, value in row.items()}


# Bounds of lengths in places between 0 and 1, and of variances of the logarithm over the variance of the design.
LENGTHS, VARIANCES, LEAST_NOISE, MOST_NOISE = (0.1, 30.0), (1e-2, 1e2), 1e-6, 1.0
# Number of starts of the search for the parameters with the largest likelihood.
RESTARTS = 2
JITTER = 1e-8


@dataclass(frozen=True)
class Emulator:
    """A fitted emulator: places (n, k), logarithms (n,), their mean and spread.

    known: the process of the logarithms without mean and spread; theta: its parameters, the noise last.
    """

    places: np.ndarray
    logs: np.ndarray
    centre: float
    scale: float
    known: Conditioned
    theta: np.ndarray

    @classmethod
    def fit(cls, places: np.ndarray, logs: np.ndarray, run_error: float = 0.0, seed: int = 0) -> "Emulator":
        """The emulator of largest marginal likelihood.

        places: (n, k) between 0 and 1; logs: (n,) logarithms; run_error: standard error of a logarithm according to the
        runs, a lower bound for the noise [-].
        """
        centre, scale = float(logs.mean()), float(logs.std()) or 1.0
        count, scaled = places.shape[1], (logs - centre) / scale
        kernel = Kernel(("Matern 5/2",), np.array([0]), 1 + np.arange(count)[None])
        least = float(np.clip((run_error / scale) ** 2, LEAST_NOISE, 0.5 * MOST_NOISE))
        bounds = np.log([VARIANCES, *[LENGTHS] * count, (least, MOST_NOISE)])
        first = np.log([1.0, *np.ones(count), max(0.01, least)])
        generator = np.random.RandomState(seed)
        starts = np.array([first, *(generator.uniform(*bounds.T) for _ in range(RESTARTS))])
        theta, _ = Likelihood(kernel, places, scaled, JITTER).maximise(starts, bounds)
        known = Conditioned.fit(Covariance(kernel, theta), places, scaled, np.exp(theta[-1]) + JITTER)
        return cls(places, logs, centre, scale, known, theta)

    @property
    def noise(self) -> float:
        """Standard deviation of the noise of a logarithm: the scatter of one simulation."""
        return self.scale * math.exp(0.5 * self.theta[-1])

    def predict(self, places: np.ndarray) -> np.ndarray:
        """Logarithms (m,) at places (m, k), without noise."""
        return self.centre + self.scale * self.known.mean(places)

    def draws(self, places: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
        """Functions (count, m) that agree with the design, at places (m, k), without noise."""
        mean, covariance = self.known.with_covariance(places)
        covariance[np.diag_indices_from(covariance)] += JITTER
        # Rounding may make a covariance of some thousand places indefinite.
        spread = JITTER
        while True:
            try:
                root = cholesky(covariance, lower=True)
                break
            except np.linalg.LinAlgError:
                spread *= 10
                covariance[np.diag_indices_from(covariance)] += spread
        return self.centre + self.scale * (mean + rng.standard_normal((count, len(mean))) @ root.T)

    @cached_property
    def left_out(self) -> np.ndarray:
        """Logarithms (n,) of the design, each predicted without it, by the parameters of the whole design."""
        scaled = (self.logs - self.centre) / self.scale
        return self.centre + self.scale * self.known.left_out(scaled)[0]


def quality(logs: np.ndarray, left_out: np.ndarray) -> dict[str, float]:
    """Q2 = 1 - sum (y - y_left_out)^2 / sum (y - mean)^2 [-], and the root mean square of y - y_left_out [-]."""
    residual = logs - left_out
    return {
        "q2": float(1.0 - (residual**2).sum() / ((logs - logs.mean()) ** 2).sum()),
        "leave_one_out_error": float(np.sqrt((residual**2).mean())),
    }


# Bootstrap resamples of the sums in an index.
RESAMPLES = 50
ORDERS = {"first": "S1", "total": "ST"}


@dataclass(frozen=True)
class Draws:
    """Values of an emulator over the distributions.

    logs: (draws, rows) over Saltelli's sample of the contact parameters.
    """

    names: list[str]
    logs: np.ndarray

    @property
    def independent(self) -> np.ndarray:
        """The rows (draws, m) that are independent draws from the distributions: the first and last of each block."""
        block = len(self.names) + 2
        return self.logs.reshape(len(self.logs), -1, block)[:, :, [0, -1]].reshape(len(self.logs), -1)

    def ends(self, probability: float) -> tuple[float, float]:
        """Lower and upper quantile of the logarithm over distributions and draws."""
        low, high = np.quantile(self.independent, [(1 - probability) / 2, (1 + probability) / 2])
        return float(low), float(high)


def saltelli_shares(names: list[str], base_samples: int, seed: int) -> np.ndarray:
    """Saltelli's sample of independent variables uniform between 0 and 1: (base_samples (k + 2), k)."""
    return sobol_sample.sample(problem_of(names), base_samples, calc_second_order=False, seed=seed)


def problem_of(names: list[str]) -> dict:
    """The problem, as SALib takes it."""
    return {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}


def draw(emulator: Emulator, names: list[str], places: np.ndarray, count: int, seed: int) -> Draws:
    """Functions drawn from an emulator over Saltelli's sample of the variables `names`.

    places: (rows, k) of the emulator for each row of the sample.
    """
    return Draws(names, emulator.draws(places, count, np.random.default_rng(seed)))


def sobol_indices(draws: Draws, probability: float, seed: int) -> pd.DataFrame:
    """First-order and total indices of each variable: parameter, first, first_lower, first_upper, total, ...

    S_i = V(E(y | x_i)) / V(y), S_Ti = 1 - V(E(y | all but x_i)) / V(y). The interval includes the spread between draws
    of the emulator and, by bootstrap, the error of the sums.
    """
    width = normal_quantile(0.5 + 0.5 * probability)
    # SALib treats a seed of 0 as no seed.
    found = [
        sobol_analysis.analyze(
            problem_of(draws.names), logs, calc_second_order=False, num_resamples=RESAMPLES, conf_level=probability,
            seed=seed + 1,
        )
        for logs in draws.logs
    ]  # fmt: skip
    table = pd.DataFrame({"parameter": draws.names})
    for order, key in ORDERS.items():
        values = np.array([each[key] for each in found])
        sums = np.array([each[f"{key}_conf"] for each in found]) / width
        half = width * np.sqrt(values.var(axis=0) + (sums**2).mean(axis=0))
        table[order] = values.mean(axis=0)
        table[f"{order}_lower"], table[f"{order}_upper"] = table[order] - half, table[order] + half
    return table
