"""Many short simulations of one case, with different contact parameters."""

import logging
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.dem.short_runs import simulate_each
from millprint.fingerprint.descriptors import tabulate_descriptors

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
