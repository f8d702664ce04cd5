"""The section `view`: how the snapshots of a run are shown."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Count, Positive, Section


class ViewConfig(Section):
    """Files for ParaView and animations from the snapshots of a case."""

    paraview_every: Count = Field(default=1, description="the files for ParaView hold every n-th snapshot [-]")
    revolutions: Positive = Field(default=5.0, description="revolutions of the mill in an animation [-]")
    frames_per_revolution: Count = Field(
        default=50, description="frames of an animation per revolution, if there are enough snapshots [-]"
    )
    frames_per_second: Annotated[float, Field(ge=1, le=50)] = Field(
        default=25.0, description="frames shown per second; each is shown for a whole number of 0.01 s [1/s]"
    )
