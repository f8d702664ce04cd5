"""The section `view`: how the snapshots of a run are shown."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Section


class ViewConfig(Section):
    """Animations from the snapshots of a case."""

    revolutions: Annotated[float, Field(gt=0, le=10_000)] = 5.0
    """revolutions of the mill in an animation [-]"""
    frames_per_revolution: Annotated[int, Field(ge=1, le=10_000)] = 50
    """frames of an animation per revolution, if there are enough snapshots [-]"""
