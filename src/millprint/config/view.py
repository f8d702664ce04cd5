"""The section `view`: how the snapshots of a run are shown."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Count, Positive, Section


class ViewConfig(Section):
    """Files for ParaView and animations from the snapshots of a case."""

    paraview_every: Count = 1
    """the files for ParaView hold every n-th snapshot [-]"""
    revolutions: Positive = 5.0
    """revolutions of the mill in an animation [-]"""
    frames_per_revolution: Count = 50
    """frames of an animation per revolution, if there are enough snapshots [-]"""
    frames_per_second: Annotated[float, Field(ge=1, le=50)] = 25.0
    """frames shown per second; each is shown for a whole number of 0.01 s [1/s]"""
