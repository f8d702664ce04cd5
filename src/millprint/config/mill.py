"""Mills (config/mills/*.yaml): geometry, motion, bodies inside the vessel, and source of the numbers."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from millprint.config.geometry import PostGeometry, SolidGeometry, StadiumGeometry, VesselGeometry
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.motion_kinds import CircleMotion, Motion
from millprint.config.section import Name, NamedSection, Section

__all__ = ["CircleMotion", "InsertConfig", "MillConfig", "PostGeometry", "StadiumGeometry"]


class InsertConfig(Section):
    """A solid body inside the vessel: an impeller, a rod, a baffle. It must not meet the walls at any time."""

    name: Name
    """name of the insert"""
    geometry: SolidGeometry
    motion: Motion | None = None
    """its own motion in the laboratory frame; left out, it moves with the vessel"""


class MillConfig(NamedSection):
    """One mill."""

    name: Name
    """name of the mill, equal to the file's name"""
    title: str
    """the mill's name in figures and tables"""
    source: str
    """where the numbers come from"""
    volume_ml: Annotated[float, Field(ge=0.01, le=1e7)]
    """nominal inner volume, to which fill ratios refer [mL]"""
    # Decides only what is accepted, so it is left out of what a simulation gets and records.
    volume_tolerance: Annotated[float, Field(gt=0, le=1)] = Field(default=0.02, exclude=True)
    """how far volume_ml may be from the volume of the geometry without inserts, as a fraction of it [-]"""
    geometry: VesselGeometry
    motion: Motion
    inserts: list[InsertConfig] = []
    """solid bodies inside the vessel; none if left out"""
    speed_unit: Literal["rpm", "hz"] = "rpm"
    """unit of the mill's speed in its figures: revolutions per minute, or cycles per second"""
    sweep: MillSweepConfig | None = None
    """conditions that make its fingerprint; derived from the mill if left out"""

    @model_validator(mode="after")
    def _names_differ(self) -> "MillConfig":
        names = ["vessel", *(insert.name for insert in self.inserts)]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"inserts: name = {twice!r}: names must differ from each other and from 'vessel'")
        return self

    @property
    def source_files(self) -> list[str]:
        """Files of triangles and of points that the mill is made from, as paths from the project's root."""
        shapes = [self.geometry, *(insert.geometry for insert in self.inserts)]
        motions = [self.motion, *(insert.motion for insert in self.inserts)]
        paths = (getattr(part, "path", None) for part in [*shapes, *motions])
        return [path for path in paths if path is not None]
