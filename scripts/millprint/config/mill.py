"""Mills (config/mills/*.yaml): the geometry of the vessel, its motion, and where the numbers come from."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.motion import CircleMotion, Motion
from millprint.config.section import Name, Positive, Section

__all__ = ["CircleMotion", "MillConfig", "PostGeometry", "StadiumGeometry"]


class PostGeometry(Section):
    """An upright cylinder of flat facets through the whole height of the vessel, at its centre."""

    radius_mm: Positive = Field(description="radius of the post [mm]")
    facets: Annotated[int, Field(ge=3)] = Field(default=24, description="flat facets around the post [-]")


class StadiumGeometry(Section):
    """Prism over a stadium (two half circles and two straight sides), of flat facets, with a filleted bottom edge."""

    kind: Literal["stadium"]
    end_radius_mm: Positive = Field(description="radius of the two round ends [mm]")
    straight_mm: Positive = Field(description="length of the straight sides [mm]")
    height_mm: Positive = Field(description="inner height [mm]")
    facets_per_half_circle: Annotated[int, Field(ge=3)] = Field(description="flat facets of each round end [-]")
    fillet_radius_mm: Annotated[float, Field(ge=0)] = Field(description="radius of the bottom edge's fillet [mm]")
    fillet_facets: Annotated[int, Field(ge=1)] = Field(default=5, description="flat facets across the fillet [-]")
    post: PostGeometry | None = Field(default=None, description="a central post; none if left out")

    @model_validator(mode="after")
    def _sizes_fit(self) -> "StadiumGeometry":
        bound = min(self.end_radius_mm, self.height_mm)
        if self.fillet_radius_mm >= bound:
            raise ValueError(
                f"fillet_radius_mm = {self.fillet_radius_mm:g}: must be smaller than the end radius and the height, "
                f"{bound:g} mm"
            )
        if self.post and self.post.radius_mm >= self.end_radius_mm - self.fillet_radius_mm:
            raise ValueError(
                f"post.radius_mm = {self.post.radius_mm:g}: must be smaller than the flat floor's half width, "
                f"{self.end_radius_mm - self.fillet_radius_mm:g} mm"
            )
        return self


Geometry = StadiumGeometry


class MillConfig(Section):
    """One mill."""

    name: Name = Field(description="name of the mill, equal to the file's name")
    title: str = Field(description="what a person calls it")
    source: str = Field(description="where the numbers come from")
    volume_ml: Positive = Field(description="nominal inner volume, to which fill ratios refer [mL]")
    geometry: Geometry
    motion: Motion
