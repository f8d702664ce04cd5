"""The space of uncertain variables: their distributions, a space-filling design, and places between 0 and 1."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats
from scipy.stats import qmc

from millprint.config.errors import ConfigError
from millprint.config.uncertainty import PARAMETERS, DistributionSection, Parameter, ParametersSection
from millprint.statistics.quantiles import normal_quantile

# Normal distributions are cut off here, so that a design covers only the values that matter.
MOST_DEVIATIONS = 3.0
FILL = "fill_ratio"
# Places may exceed the range by this, due to rounding or a whole number of balls.
NEAR = 0.05


def _uniform(section: Any, low: float, high: float) -> Any:
    return stats.uniform(low, high - low)


def _loguniform(section: Any, low: float, high: float) -> Any:
    return stats.loguniform(low, high)


def _triangular(section: Any, low: float, high: float) -> Any:
    return stats.triang((section.mode - low) / (high - low), low, high - low)


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
    "uniform": _uniform,
    "loguniform": _loguniform,
    "triangular": _triangular,
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
