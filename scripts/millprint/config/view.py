"""The section `view`: how a run's snapshots are shown."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Count, Positive, Section


class ViewConfig(Section):
    """Files for ParaView and animations, made of a case's snapshots."""

    paraview_every: Count = Field(default=1, description="one snapshot in so many goes into the files for ParaView [-]")
    revolutions: Positive = Field(default=5.0, description="revolutions of the mill that an animation shows [-]")
    frames_per_revolution: Count = Field(
        default=50, description="frames of an animation in each revolution, if there are snapshots enough [-]"
    )
    frames_per_second: Annotated[float, Field(ge=1, le=50)] = Field(
        default=25.0, description="frames that an animation shows in a second; delays are whole hundredths [1/s]"
    )
