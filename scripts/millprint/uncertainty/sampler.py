"""Many short simulations of one case, each with its own contact parameters: rows that are done are kept."""

import hashlib
import json
import logging
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import simulate
from millprint.errors import SimulationError
from millprint.files import whole_file
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.job import progress
from millprint.kernel import kernel_digest
from millprint.sealed import seal, unsealed

Settings = TypeVar("Settings", Case, ContactConfig)

logger = logging.getLogger("millprint")

# Of a sampled case, besides what the samples say: the fill ratio as simulated, with a whole number of balls.
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
    replaces the value that `contact` or `case` has. counting_rule: what counts as one collision, of dem.counting_rules.
    done: a file to which each row is written once it is simulated, and from which a killed call with the same
    arguments continues; it is left there, for the caller to remove once the table is written.

    Returns a row for each sample, in their order: the columns of `samples`, filled_ratio (of a whole number of balls),
    and every column of workflow/descriptors.md (powers in W, specific powers and frequency, standard errors).
    Raises ValueError for an unknown column, and SimulationError, with the sample and its values, for one that fails.
    """
    unknown = [name for name in samples if name not in ContactConfig.model_fields and name not in Case.model_fields]
    if unknown:
        raise ValueError(f"samples: {', '.join(unknown)}: no key of a contact set or of a case")
    parts = [part.model_dump_json() for part in (case, mill, contact, dem)]
    identity = hashlib.sha256(json.dumps([*parts, counting_rule, kernel_digest()]).encode()).hexdigest()
    rows = _rows_done(done, identity, samples)
    with progress(len(samples), title, " simulations") as bar:
        bar.update(len(rows))
        for index, values in zip(samples.index, samples.to_dict("records"), strict=True):
            if str(index) in rows:
                continue
            rows[str(index)] = {**values, **_describe(case, mill, contact, dem, index, values, counting_rule)}
            if done:
                _keep(done, identity, rows)
            bar.update()
    return pd.DataFrame([rows[str(index)] for index in samples.index], index=samples.index)


def _describe(
    case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, index: object, values: dict, rule: str
) -> dict:
    """The descriptors of one sample."""
    balls, own = _with(contact, values), _with(case, values)
    try:
        summary = simulate(own, mill, balls, dem)
        row = tabulate_descriptors([summary], rule).iloc[0].to_dict()
    except SimulationError as error:
        described = ", ".join(f"{key} = {value:g}" for key, value in values.items())
        raise SimulationError(f"sample {index} ({described}): {error}") from None
    logger.info("sample %s: %d balls in %.1f s", index, summary["balls"], summary["wall_clock_s"])
    ball_m3 = np.pi / 6 * summary["ball_diameter_m"] ** 3
    return {**_plain(row), FILLED: summary["balls"] * ball_m3 / summary["nominal_volume_m3"]}


def _with(section: Settings, values: dict) -> Settings:
    """A contact set or a case with those of the values that it has keys for."""
    own = {key: value for key, value in values.items() if key in type(section).model_fields}
    return type(section)(**{**section.model_dump(), **own})


def _plain(row: dict) -> dict:
    """A row with Python's own numbers, as JSON takes them."""
    return {key: value.item() if isinstance(value, np.generic) else value for key, value in row.items()}


def _keep(path: str | Path, identity: str, rows: dict[str, dict]) -> None:
    """Write the rows, with a digest in front."""
    payload = json.dumps({"identity": identity, "rows": rows}).encode()
    with whole_file(path) as partial:
        partial.write_bytes(seal(payload) + payload)


def _rows_done(path: str | Path | None, identity: str, samples: pd.DataFrame) -> dict[str, dict]:
    """The rows that an earlier call wrote for the same samples; none if the file is absent, damaged, or of others."""
    if path is None or not Path(path).is_file():
        return {}
    try:
        content = json.loads(unsealed(path))
    except (OSError, ValueError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, error)
        return {}
    if content["identity"] != identity:
        logger.info("%s belongs to other settings or to another version: starting again", path)
        return {}
    wanted = {str(index): values for index, values in zip(samples.index, samples.to_dict("records"), strict=True)}
    same = {
        index: row
        for index, row in content["rows"].items()
        if index in wanted and all(row[key] == value for key, value in wanted[index].items())
    }
    logger.info("continuing from %s: %d of %d samples are done", path, len(same), len(samples))
    return same
