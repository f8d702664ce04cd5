"""What the thesis leaves open of its jar, fitted to some of the values that it prints.

Which mill the fit is about is said here: the Snakefile asks, and nothing that takes long is imported.
"""

from millprint.config.geometry import StadiumGeometry
from millprint.config.mill import MillConfig
from millprint.config.workflow import WorkflowConfig


def fitted_mill(config: WorkflowConfig, mills: dict[str, MillConfig]) -> MillConfig | None:
    """The mill that the fit is about; None in a run of another mill, or where its jar is no stadium any more."""
    if config.fit is None or config.fit.mill != config.mill:
        return None
    mill = mills[config.mill]
    return mill if isinstance(mill.geometry, StadiumGeometry) else None
