"""Mills (config/mills/*.yaml): shapes of vessels and of bodies inside them, motion, and source of the data."""

import math
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.motion_kinds import Motion
from millprint.config.section import (
    Name,
    NamedSection,
    NonNegative,
    Place,
    PlaceVector,
    Scale,
    Section,
    Size,
    VesselSize,
    first_repeated,
    project_path,
)

Facets = Annotated[int, Field(ge=3, le=720)]
HalfFacets = Annotated[int, Field(ge=3, le=360)]
FilletFacets = Annotated[int, Field(ge=1, le=180)]


class GeometrySection(Section):
    """The keys of a shape, whose `kind` is the name of its record in `millprint.mill.shapes`."""

    kind: str
    faceted: bool = False
    """the flat facets are the wall itself, and not only a drawing of round walls"""
    # The key of the number of flat facets around the body; None for a shape that is not round, or from a file.
    facets_key: ClassVar[str | None] = None

    def origin(self) -> tuple[str, str]:
        """Where the shape comes from, and what to correct where its volume is wrong, for a refusal."""
        return f"the {self.kind} of geometry", "its sizes"

    @property
    def smooth_axis(self) -> str | None:
        """The axis of a drum whose ends have no friction; None for every other shape."""
        return None


class DrumGeometry(GeometrySection):
    """What all round vessels share."""

    axis: Literal["x", "y", "z"] = "z"
    """direction of the axis; z points up"""
    smooth_ends: bool = False
    """flat ends without friction, for a slice of a longer drum"""
    radius_mm: VesselSize
    """radius [mm]"""

    @property
    def smooth_axis(self) -> str | None:
        """The axis of a drum whose ends have no friction; None for one with rough ends."""
        return self.axis if self.smooth_ends else None


class PostGeometry(Section):
    """An upright cylinder through the whole height of the vessel, at its centre."""

    radius_mm: Size
    """radius of the post [mm]"""
    facets: Facets = 24
    """facets around the post, as it is drawn [-]"""


class StadiumGeometry(GeometrySection):
    """Prism over a stadium (two half circles and two straight sides), with a filleted bottom edge."""

    kind: Literal["stadium"]
    facets_key = "facets_per_half_circle"
    end_radius_mm: VesselSize
    """radius of the two round ends [mm]"""
    straight_mm: Size
    """length of the straight sides [mm]"""
    height_mm: VesselSize
    """inner height [mm]"""
    facets_per_half_circle: HalfFacets
    """facets of each round end, as it is drawn [-]"""
    facet_unevenness: Annotated[float, Field(ge=0, le=0.95)] = 0.0
    """u: facets of a round end are alternately 1 + u and 1 - u times as wide as the mean [-]"""
    fillet_radius_mm: NonNegative
    """radius of the bottom edge's fillet [mm]"""
    fillet_facets: FilletFacets = 5
    """facets across the fillet, as it is drawn [-]"""
    post: PostGeometry | None = None
    """a central post; none if left out"""

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


class CylinderGeometry(DrumGeometry):
    """A cylinder, upright or lying; a fillet as large as the radius makes an end a half sphere."""

    kind: Literal["cylinder"]
    facets_key = "facets"
    height_mm: VesselSize
    """inner length from end to end, rounded ends included [mm]"""
    facets: Facets = 48
    """facets around, as it is drawn [-]"""
    fillet_radius_mm: NonNegative = 0.0
    """radius of the ends' fillets [mm]; 0 for none"""
    fillet_facets: FilletFacets = 5
    """facets across a fillet, as it is drawn [-]"""
    fillet_ends: Literal["bottom", "both", "none"] = "bottom"
    """ends with a fillet; bottom is the end towards the axis's negative side"""
    centre_mm: PlaceVector | None = None
    """middle of the cylinder [mm]; left out, an upright one stands on z = 0 and a lying one is centred"""

    @model_validator(mode="after")
    def _sizes_fit(self) -> "CylinderGeometry":
        ends = {"none": 0, "bottom": 1, "both": 2}[self.fillet_ends]
        bound = min(self.radius_mm, self.height_mm / ends) if ends else 0.0
        # Sizes are typed as decimal numbers, so the bound allows for rounding.
        if self.fillet_radius_mm > bound * (1 + 1e-9) or (ends == 1 and self.fillet_radius_mm >= self.height_mm):
            raise ValueError(
                f"fillet_radius_mm = {self.fillet_radius_mm:g}: with fillet_ends = {self.fillet_ends} at most "
                f"{bound:g} mm, the radius and the share of the height that each end has"
            )
        if self.smooth_ends and self.fillet_ends != "none" and self.fillet_radius_mm > 0:
            raise ValueError("smooth_ends = true: an end without friction is flat; fillet_ends must be none")
        return self


class LiftersSection(Section):
    """Bars along the shell of a drum, spread evenly; a trapezoid in section, or a rectangle."""

    number: Annotated[int, Field(ge=1, le=120)]
    """number of lifters [-]"""
    height_mm: Size
    """height above the shell, at the middle of a lifter [mm]"""
    width_mm: Size
    """width at the foot [mm]"""
    face_angle_deg: Annotated[float, Field(ge=20, le=90)] = 90.0
    """angle between the two faces and the shell [deg]; 90 for a square or rectangle, less for a trapezoid"""


class LifterDrumGeometry(DrumGeometry):
    """A lying or upright drum with lifters on its shell."""

    kind: Literal["lifter_drum"]
    facets_key = "facets"
    radius_mm: VesselSize
    """inner radius of the shell [mm]"""
    length_mm: VesselSize
    """inner length from end to end [mm]"""
    axis: Literal["x", "y", "z"] = "y"
    """direction of the drum's axis; z points up"""
    facets: Facets = 72
    """facets of a whole shell, as it is drawn [-]"""
    lifters: LiftersSection

    @property
    def foot_angle(self) -> float:
        """Half the angle that the foot of a lifter takes of the shell [rad]."""
        return math.asin(self.lifters.width_mm / 2 / self.radius_mm)

    @property
    def top_half_width_mm(self) -> float:
        """Half the width of a lifter at its top [mm]."""
        # The foot's corners are on the shell; the height counts from the shell at the lifter's middle.
        rise = self.lifters.height_mm - self.radius_mm * (1 - math.cos(self.foot_angle))
        return self.lifters.width_mm / 2 - rise / math.tan(math.radians(self.lifters.face_angle_deg))

    @model_validator(mode="after")
    def _lifters_fit(self) -> "LifterDrumGeometry":
        lifters = self.lifters
        if lifters.height_mm >= 0.9 * self.radius_mm:
            raise ValueError(
                f"lifters.height_mm = {lifters.height_mm:g}: leaves no room for a ball; must be under nine tenths of "
                f"the radius, {0.9 * self.radius_mm:g} mm"
            )
        # A hundredth of each gap is left, so that the shell between two lifters has a size.
        widest = 2 * self.radius_mm * math.sin(min(0.99 * math.pi / lifters.number, math.pi / 2))
        if lifters.width_mm >= widest:
            raise ValueError(
                f"lifters.width_mm = {lifters.width_mm:g}: {lifters.number} lifters of that width overlap; must be "
                f"under {widest:.4g} mm"
            )
        if lifters.height_mm <= self.radius_mm * (1 - math.cos(self.foot_angle)):
            raise ValueError(
                f"lifters.height_mm = {lifters.height_mm:g}: a lifter of this width is all below the shell; must be "
                f"over {self.radius_mm * (1 - math.cos(self.foot_angle)):.3g} mm"
            )
        if self.top_half_width_mm <= 0:
            raise ValueError(
                f"lifters.face_angle_deg = {lifters.face_angle_deg:g}: the faces meet below the top; make them "
                "steeper, or the lifter wider or lower"
            )
        if math.atan2(self.top_half_width_mm, self.radius_mm - lifters.height_mm) >= math.pi / lifters.number:
            raise ValueError(
                f"lifters.number = {lifters.number}: the tops of {lifters.number} lifters overlap; take fewer, or "
                "lower or narrower ones"
            )
        return self


class BoxGeometry(GeometrySection):
    """A box with its sides along the axes."""

    kind: Literal["box"]
    x_mm: VesselSize
    """inner size along x [mm]"""
    y_mm: VesselSize
    """inner size along y [mm]"""
    z_mm: VesselSize
    """inner size along z [mm]"""
    centre_mm: PlaceVector | None = None
    """middle of the box [mm]; left out, it stands on z = 0 about the z axis"""


class PaddlesGeometry(GeometrySection):
    """An upright stirrer: flat upright blades around a hub on the z axis, one outline through the whole height."""

    kind: Literal["paddles"]
    hub_radius_mm: Size
    """radius of the hub [mm]"""
    hub_facets: HalfFacets = 24
    """facets of a whole hub, as it is drawn [-]"""
    blades: Annotated[int, Field(ge=1, le=64)]
    """number of blades [-]"""
    blade_length_mm: Size
    """how far a blade stands out of the hub [mm]"""
    blade_thickness_mm: Size
    """thickness of a blade [mm]"""
    height_mm: Size
    """height of hub and blades [mm]"""
    bottom_mm: Place
    """z of the lower side [mm]"""

    @model_validator(mode="after")
    def _blades_fit(self) -> "PaddlesGeometry":
        # A hundredth of the hub is left between blades, so that its facets there have a size.
        widest = 1.98 * self.hub_radius_mm * (math.sin(math.pi / self.blades) if self.blades > 1 else 1.0)
        if self.blade_thickness_mm >= widest:
            raise ValueError(
                f"blade_thickness_mm = {self.blade_thickness_mm:g}: {self.blades} blades on this hub must be thinner "
                f"than {widest:.4g} mm"
            )
        return self


# The units of files of triangles.
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "inch": 0.0254}


class StlGeometry(GeometrySection):
    """A closed surface of triangles from a file, its normals pointing out of the body that it encloses.

    For a vessel that body is the hollow that the balls fill, so that the normals point into the wall; for an insert
    it is the insert. The file's coordinates are those of the body frame: z points up, the motion's axes refer to it.
    """

    kind: Literal["stl"]
    path: Annotated[str, project_path(".stl", ".ply", ".obj")]
    """the file, from the project's root: .stl, or .ply or .obj with more digits"""
    unit: Literal["mm", "cm", "m", "inch"]
    """unit of the file's coordinates"""
    scale: Scale = 1.0
    """factor on the file's coordinates, to make a mill of another size [-]"""

    @property
    def metres(self) -> float:
        """A coordinate of 1 of the file [m]."""
        return METRES[self.unit] * self.scale

    def origin(self) -> tuple[str, str]:
        """The file and its unit."""
        return f"{self.path} in {self.unit}", "geometry.unit"

    def unit_of_volume(self, share: float) -> str | None:
        """The unit in which the volume would be `share` of what it is, sizes within one per cent, or None."""
        sizes = {unit: metres / METRES[self.unit] for unit, metres in METRES.items()}
        return next((unit for unit, size in sizes.items() if math.isclose(size**3, share, rel_tol=0.03)), None)


VesselGeometry = Annotated[
    StadiumGeometry | CylinderGeometry | LifterDrumGeometry | BoxGeometry | StlGeometry, Field(discriminator="kind")
]
SolidGeometry = Annotated[CylinderGeometry | BoxGeometry | PaddlesGeometry | StlGeometry, Field(discriminator="kind")]


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
        if twice := first_repeated(names):
            raise ValueError(f"inserts: name = {twice!r}: names must differ from each other and from 'vessel'")
        return self

    @property
    def source_files(self) -> list[str]:
        """Files of triangles and of points that the mill is made from, as paths from the project's root."""
        shapes = [self.geometry, *(insert.geometry for insert in self.inserts)]
        motions = [self.motion, *(insert.motion for insert in self.inserts)]
        paths = (getattr(part, "path", None) for part in [*shapes, *motions])
        return [path for path in paths if path is not None]
