"""What must hold of the section `fit` before a job starts."""

from millprint.config.geometry import StadiumGeometry
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig
from millprint.errors import ConfigError
from millprint.fingerprint.published import read_published
from millprint.fit.published import published_values, with_roles


def fitted_mill(config: WorkflowConfig, mills: dict[str, MillConfig]) -> MillConfig | None:
    """The mill that the fit is about; None in a run of another mill, or where its jar is no stadium any more."""
    if config.fit is None or config.fit.mill != config.mill:
        return None
    mill = mills[config.mill]
    return mill if isinstance(mill.geometry, StadiumGeometry) else None


def fit_faults(config: WorkflowConfig, mills: dict[str, MillConfig], source: str) -> list[str]:
    """A line for each fault, naming file, key, value and what would be right; none where nothing is fitted."""
    fit, faults = config.fit, []
    if fit is None or fitted_mill(config, mills) is None:
        return []
    if fit.contact not in config.contacts:
        faults.append(f"{source}: fit.contact = {fit.contact}: must be one of contacts ({', '.join(config.contacts)})")
    free = [rule.name for rule in config.dem.counting_rules if not rule.peak_force_min_N + rule.duration_min_s]
    for name in fit.counting_rules:
        if name not in free:
            faults.append(
                f"{source}: fit.counting_rules = {name}: must be a rule of dem.counting_rules without a threshold "
                f"({', '.join(free)})"
            )
    try:
        with_roles(published_values(read_published(config.data.published), fit.contact), fit.fitted)
    except ConfigError as error:
        faults.append(f"{source}: {error}")
    return faults
