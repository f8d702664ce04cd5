"""Mills (config/mills/*.yaml): geometry, motion, bodies inside the vessel, and where the numbers come from."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.geometry import PostGeometry, SolidGeometry, StadiumGeometry, StlGeometry, VesselGeometry
from millprint.config.motion import CircleMotion, Motion
from millprint.config.section import Name, Section

__all__ = ["CircleMotion", "InsertConfig", "MillConfig", "PostGeometry", "StadiumGeometry"]


class InsertConfig(Section):
    """A solid body inside the vessel: an impeller, a rod, a baffle. It must not meet the walls at any time."""

    name: Name = Field(description="name of the insert")
    geometry: SolidGeometry
    motion: Motion | None = Field(
        default=None, description="its own motion in the laboratory frame; left out, it moves with the vessel"
    )


class MillConfig(Section):
    """One mill."""

    name: Name = Field(description="name of the mill, equal to the file's name")
    title: str = Field(description="what a person calls it")
    source: str = Field(description="where the numbers come from")
    volume_ml: Annotated[float, Field(ge=0.01, le=1e7)] = Field(
        description="nominal inner volume, to which fill ratios refer [mL]"
    )
    geometry: VesselGeometry
    motion: Motion
    inserts: list[InsertConfig] = Field(default=[], description="solid bodies inside the vessel; none if left out")

    @model_validator(mode="after")
    def _names_differ(self) -> "MillConfig":
        names = ["vessel", *(insert.name for insert in self.inserts)]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"inserts: name = {name!r}: names must differ from each other and from 'vessel'")
        return self

    @property
    def mesh_files(self) -> list[str]:
        """Files of triangles that the mill is made from, as paths from the project's root."""
        shapes = [self.geometry, *(insert.geometry for insert in self.inserts)]
        return [shape.path for shape in shapes if isinstance(shape, StlGeometry)]
