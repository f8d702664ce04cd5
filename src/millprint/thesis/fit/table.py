"""fit.tsv: the jar, every published value next to ours, and the effect of a step of each parameter."""

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.fit import TrialConfig
from millprint.thesis.fit.jar_search import Trial, neighbours
from millprint.thesis.fit.published_targets import NAMING
from millprint.thesis.fit.shape import JAR_PARAMETERS

FIT_COLUMNS = [
    "record", "parameter", "parameter_value", "step", *NAMING, "role", "counting_rule", "published", "ours",
    "error_percent", "standard_error_percent", "change_percent",
]  # fmt: skip


def parameter_rows(parameters: dict[str, float], end_radius_mm: float, rule: str) -> pd.DataFrame:
    """Records `parameter`: what was fitted; the end radius follows from the volume."""
    jar = {**parameters, "end_radius_mm": end_radius_mm}
    rows = [{"record": "parameter", "parameter": name, "parameter_value": value} for name, value in jar.items()]
    return pd.DataFrame([*rows, {"record": "parameter", "parameter": "counting_rule", "counting_rule": rule}])


def sensitivity_rows(jar: dict[str, float], settings: TrialConfig, trial: Trial) -> pd.DataFrame:
    """Records `sensitivity`: every value that the search simulates, for a step down and up in each parameter.

    change_percent is against the unchanged jar under the same short windows, those of refining; its standard error is
    standard_error_percent. A jar that cannot be built is left out.
    """
    present = tuple(jar[name] for name in JAR_PARAMETERS)
    unchanged = trial(jar, settings.refining)
    tables = []
    for other in neighbours(present, settings.shape):
        index = next(k for k, value in enumerate(other) if value != present[k])
        name = JAR_PARAMETERS[index]
        try:
            changed = trial(dict(zip(JAR_PARAMETERS, other, strict=True)), settings.refining)
        except ConfigError:
            continue
        error = np.hypot(changed["standard_error_percent"], unchanged["standard_error_percent"])
        tables.append(
            changed.assign(
                record="sensitivity",
                parameter=name,
                parameter_value=other[index],
                step=other[index] - present[index],
                change_percent=100.0 * (changed["ours"] / unchanged["ours"] - 1.0),
                standard_error_percent=error,
            )
        )
    return pd.concat(tables).dropna(subset="ours") if tables else pd.DataFrame(columns=FIT_COLUMNS)


def fit_table(parameters: pd.DataFrame, values: pd.DataFrame, sensitivity: pd.DataFrame) -> pd.DataFrame:
    """The three kinds of records one below the other, with FIT_COLUMNS."""
    frames = [parameters, values.assign(record="value"), sensitivity]
    return pd.concat([frame for frame in frames if len(frame)], ignore_index=True).reindex(columns=FIT_COLUMNS)
