"""Checks of the section `fit` before a job starts."""

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig
from millprint.thesis.curves.published import read_published
from millprint.thesis.fit import fitted_mill
from millprint.thesis.fit.published_targets import published_values, with_roles


def fit_faults(config: WorkflowConfig, mills: dict[str, MillConfig], source: str) -> list[str]:
    """A line for each fault, with file, key, value and what would be right; none if nothing is fitted."""
    fit, data, faults = config.fit, config.data, []
    if fit is None or data is None or fitted_mill(config, mills) is None:
        return []
    if fit.contact not in config.contacts:
        faults.append(f"{source}: fit.contact = {fit.contact}: must be one of contacts ({', '.join(config.contacts)})")
    free = [rule.name for rule in config.dem.counting_rules if not rule.has_threshold]
    for name in fit.counting_rules:
        if name not in free:
            faults.append(
                f"{source}: fit.counting_rules = {name}: must be a rule of dem.counting_rules without a threshold "
                f"({', '.join(free)})"
            )
    try:
        with_roles(published_values(read_published(data.published, data.claims), fit.contact), fit.fitted)
    except ConfigError as error:
        faults.append(f"{source}: {error}")
    return faults
