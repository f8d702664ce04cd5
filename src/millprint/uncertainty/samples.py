"""The samples behind the intervals of a mill: drawn contact parameters, one short simulation of each."""

import json
import logging
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.sweep import Case, DemConfig
from millprint.config.uncertainty import PARAMETERS, UncertaintyConfig
from millprint.dem.run import simulate
from millprint.dem.short_runs import simulate_each
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.uncertainty.space import Space, contact_space, with_fill
from millprint.uncertainty.varied import fill_ratios_of


def with_sweep(mill: dict, sweep: dict | None, derived: str | Path | None) -> MillConfig:
    """A mill from plain values, with its own sweep or the sweep from the file that was derived from it."""
    content = json.loads(Path(derived).read_text()) if derived else sweep
    return MillConfig(**mill).model_copy(update={"sweep": content and MillSweepConfig(**content)})


def contact_values(contact: ContactConfig) -> dict[str, float]:
    """The varied parameters of a contact set; if the set has no friction at walls, it is that between balls."""
    found = {name: getattr(contact, name, None) for name in PARAMETERS}
    return {name: contact.static_friction if value is None else value for name, value in found.items()}


def space_of(mill: MillConfig, uncertainty: UncertaintyConfig) -> Space:
    """Contact parameters and fill ratio. Raises ConfigError for a distribution without possible values."""
    return with_fill(contact_space(uncertainty.parameters), fill_ratios_of(mill, uncertainty))


def check_contact(space: Space, contact: ContactConfig) -> None:
    """Raise ConfigError, in one line, if the contact set of the predictions is outside the distributions.

    Likewise for one whose law has no Young's modulus, which is a variable.
    """
    contact.of_law("young_modulus_gpa")
    values = contact_values(contact)
    for variable in space.variables:
        low, high = variable.ends
        if variable.name in values and not low <= values[variable.name] <= high:
            raise ConfigError(
                f"uncertainty.parameters.{variable.name}: {low:g} to {high:g} leaves out {values[variable.name]:g} of "
                f"contact set {contact.name}, whose predictions get the intervals; widen the distribution, or set "
                "mills.contact to a set of your own values"
            )


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
    wall_static_friction, rolling_friction, young_modulus_gpa, ...) or of a case (fill_ratio, speed_rpm, seed, ...), and
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
    """A contact set or a case with the values that it has keys for."""
    own = {key: value for key, value in values.items() if key in type(section).model_fields}
    return type(section)(**{**section.model_dump(), **own})


def _plain(row: dict) -> dict:
    """A row with Python numbers, as JSON needs them."""
    return {key: value.item() if isinstance(value, np.generic) else value for key, value in row.items()}
