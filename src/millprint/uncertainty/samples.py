"""The samples behind the intervals of a mill: contact parameters from their distributions, a simulation of each."""

import json
import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd
from scipy import stats
from scipy.stats import qmc

from millprint.cases.of_mill import fill_ratios_of
from millprint.cases.simulate import simulate_each
from millprint.config.contact_laws import law_fields
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.over_speed import NOMINAL_SPEED_M_S
from millprint.config.sweep import Case, DemConfig
from millprint.config.uncertainty import (
    PARAMETERS,
    DistributionSection,
    Parameter,
    ParametersSection,
    UncertaintyConfig,
)
from millprint.config.workflow import WorkflowConfig
from millprint.dem.run import simulate
from millprint.estimate.quantiles import normal_quantile
from millprint.fingerprint.descriptors import tabulate_descriptors

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
