"""Fit of the jar, whose shape the thesis does not give, to some of the values that it prints.

Which mill the fit is about is said here: the Snakefile asks, and nothing that takes long is imported.
"""

from pathlib import Path

from millprint.config.mill import MillConfig, StadiumGeometry
from millprint.config.workflow import WorkflowConfig

# Jars of a search that are enough to say what the fit leaves open of the shape.
FEWEST_JARS = 24


def numbers_of(path: str, most: int) -> list[int]:
    """The numbers of the jars in a table of `millprint.thesis.fit.open_shape`, from 1 to at most `most`."""
    rows = Path(path).read_text().splitlines()[1:]
    return sorted({number for row in rows if (number := int(row.split("\t")[0])) <= most})


def fitted_mill(config: WorkflowConfig, mills: dict[str, MillConfig]) -> MillConfig | None:
    """The mill of the fit; None in a run of another mill, or if its jar is no longer a stadium."""
    if config.fit is None or config.fit.mill != config.mill:
        return None
    mill = mills[config.mill]
    return mill if isinstance(mill.geometry, StadiumGeometry) else None
