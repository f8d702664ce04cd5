"""Mills (config/mills/*.yaml): the geometry of the vessel, its motion, and where the numbers come from."""

from typing import Annotated, Literal

from pydantic import Field

from millprint.config.section import Name, Positive, Section


class StadiumGeometry(Section):
    """Prism over a stadium (two half circles and two straight sides), of flat facets, with a filleted bottom edge."""

    kind: Literal["stadium"]
    end_radius_mm: Positive = Field(description="radius of the two round ends [mm]")
    straight_mm: Positive = Field(description="length of the straight sides [mm]")
    height_mm: Positive = Field(description="inner height [mm]")
    facets_per_half_circle: Annotated[int, Field(ge=3)] = Field(description="flat facets of each round end")
    fillet_radius_mm: Annotated[float, Field(ge=0)] = Field(description="radius of the bottom edge's fillet [mm]")
    fillet_facets: Annotated[int, Field(ge=1)] = Field(default=4, description="flat facets across the fillet")


class CircleMotion(Section):
    """Translation on a horizontal circle without turning (Emax, thesis Sec. 3.2.2)."""

    kind: Literal["circle"]
    amplitude_mm: Positive = Field(description="radius A of the circle [mm]")


class MillConfig(Section):
    """One mill."""

    name: Name = Field(description="name of the mill, equal to the file's name")
    title: str = Field(description="what a person calls it")
    source: str = Field(description="where the numbers come from")
    volume_ml: Positive = Field(description="nominal inner volume, to which fill ratios refer [mL]")
    geometry: StadiumGeometry
    motion: CircleMotion
