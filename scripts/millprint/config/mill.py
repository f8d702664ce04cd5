"""Mills (config/mills/*.yaml): the geometry of the vessel, its motion, and where the numbers come from."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.section import Name, Positive, Section


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


class CircleMotion(Section):
    """Translation on a horizontal circle without turning: x = A cos wt, y = A sin wt (Emax, thesis Sec. 3.2.2)."""

    kind: Literal["circle"]
    amplitude_mm: Positive = Field(description="radius A of the circle [mm]")


class Harmonic(Section):
    """One term of a Lissajous motion: amplitude sin(multiple w t + phase) along one axis."""

    axis: Literal["x", "y", "z"] = Field(description="axis of the term; z points up")
    amplitude_mm: float = Field(description="amplitude of the term [mm]")
    multiple: Annotated[int, Field(ge=1)] = Field(default=1, description="frequency over the mill's frequency [-]")
    phase_deg: float = Field(default=0.0, description="phase of the sine [deg]; 90 makes it a cosine")


class LissajousMotion(Section):
    """Translation without turning, a sum of harmonics of the mill's frequency (thesis Eqs 6.34, 6.35)."""

    kind: Literal["lissajous"]
    terms: list[Harmonic] = Field(min_length=1, description="the harmonics")


class RestMotion(Section):
    """A vessel that stands still."""

    kind: Literal["rest"]


Geometry = StadiumGeometry
Motion = Annotated[CircleMotion | LissajousMotion | RestMotion, Field(discriminator="kind")]


class MillConfig(Section):
    """One mill."""

    name: Name = Field(description="name of the mill, equal to the file's name")
    title: str = Field(description="what a person calls it")
    source: str = Field(description="where the numbers come from")
    volume_ml: Positive = Field(description="nominal inner volume, to which fill ratios refer [mL]")
    geometry: Geometry
    motion: Motion
