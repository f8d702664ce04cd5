"""Motions of a mill's bodies, as laws with a few parameters; `millprint.mill.motion` reduces each to one form."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from millprint.config.section import Place, PlaceVector, Section, Size, Vector, inside_the_project


def _has_length(vector: Vector) -> Vector:
    if not any(vector):
        raise ValueError("axis = [0, 0, 0]: an axis needs a direction")
    return vector


Multiple = Annotated[int, Field(ge=1, le=1000)]
Ratio = Annotated[float, Field(ge=-1000, le=1000)]
Axis = Annotated[Vector, AfterValidator(_has_length)]


class CircleMotion(Section):
    """Translation on a horizontal circle without turning: x = A cos wt, y = A sin wt (Emax, thesis Sec. 3.2.2)."""

    kind: Literal["circle"]
    amplitude_mm: Size = Field(description="radius A of the circle [mm]")


class Harmonic(Section):
    """One term of a translation: amplitude sin(multiple w t + phase) along one axis."""

    axis: Literal["x", "y", "z"] = Field(description="axis of the term; z points up")
    amplitude_mm: Place = Field(description="amplitude of the term [mm]")
    multiple: Multiple = Field(default=1, description="frequency over the mill's frequency [-]")
    phase_deg: float = Field(default=0.0, description="phase of the sine [deg]; 90 makes it a cosine")


class LissajousMotion(Section):
    """Translation without turning, a sum of harmonics of the mill's frequency (thesis Eqs 6.34, 6.35)."""

    kind: Literal["lissajous"]
    terms: list[Harmonic] = Field(min_length=1, description="the harmonics")


class RotationMotion(Section):
    """Turning about a fixed axis: a tumbling drum, the shaft of an attritor."""

    kind: Literal["rotation"]
    axis: Axis = Field(description="direction of the axis; it turns counter-clockwise about it")
    pivot_mm: PlaceVector = Field(default=(0.0, 0.0, 0.0), description="a point of the axis [mm]")
    ratio: Ratio = Field(default=1.0, description="turns for each turn of the mill's stated speed [-]; < 0 turns back")


class PlanetaryMotion(Section):
    """A jar on a sun wheel about the vertical z; the mill's stated speed is the sun wheel's, counter-clockwise.

    The ratio is the jar's speed about its own axis, measured from the turning sun wheel, over the sun wheel's speed:
    what makers print as 1 : -2 is ratio -2. Seen from the laboratory the jar spins at (1 + ratio) w, and at -1 it
    does not spin at all. It is the ratio whose critical value is sqrt(R / l) - 1 for balls at a distance l from the
    jar's axis (Mio, Kano, Saito, Mater. Sci. Eng. A 332, 2002, 75). At 0 the jar would be fixed to the sun wheel, a
    centrifuge and no planetary mill: that is a rotation about the wheel's axis.
    """

    kind: Literal["planetary"]
    sun_radius_mm: Size = Field(description="distance of the jar's axis from the sun wheel's axis [mm]")
    ratio: Ratio = Field(
        description="jar's speed relative to the sun wheel over the wheel's speed, not 0 [-]; < 0 is counter"
    )

    @model_validator(mode="after")
    def _spins(self) -> "PlanetaryMotion":
        if self.ratio == 0:
            raise ValueError(
                "ratio = 0: the jar would be fixed to the sun wheel without a spin of its own, as in a centrifuge; "
                "give the jar's speed over the wheel's, such as -2, or for a centrifuge the motion {kind: rotation, "
                f"axis: [0, 0, 1], pivot_mm: [-{self.sun_radius_mm:g}, 0, 0]}}"
            )
        return self


class SwingMotion(Section):
    """Oscillation about an axis through a pivot, angle = amplitude sin(multiple w t + phase), and a translation."""

    kind: Literal["swing"]
    axis: Axis = Field(description="direction of the axis; a positive angle is counter-clockwise about it")
    pivot_mm: PlaceVector = Field(description="a point of the axis [mm]")
    amplitude_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="largest angle from the middle [deg]")
    multiple: Multiple = Field(default=1, description="frequency over the mill's frequency [-]")
    phase_deg: float = Field(default=0.0, description="phase of the sine [deg]; 90 makes it a cosine")
    terms: list[Harmonic] = Field(default=[], description="harmonics of a translation on top")


class PointsMotion(Section):
    """A measured or designed motion: a table over one turn of the mill, joined by a smooth periodic curve.

    The table (TSV) has the columns time_s, x_m, y_m, z_m, the place of the body frame's origin, and if the body turns
    rotation_x_deg, rotation_y_deg, rotation_z_deg: its rotation as axis times angle, seen from the laboratory. Its last
    row is the first one again, a turn later. The table is one turn of the mill, whatever time it took: at n rpm it is
    run through in 60/n s. In between the curve is a periodic cubic spline (of quaternions for the rotation).
    """

    kind: Literal["points"]
    path: str = Field(description="the table, from the project's root: .tsv")
    scale: Annotated[float, Field(ge=1e-3, le=1e3)] = Field(
        default=1.0, description="factor on the table's places, to make a mill of another size [-]"
    )

    @field_validator("path")
    @classmethod
    def _is_a_table_in_the_project(cls, value: str) -> str:
        return inside_the_project(value, (".tsv",))


class RestMotion(Section):
    """A body that stands still."""

    kind: Literal["rest"]


Motion = Annotated[
    CircleMotion | LissajousMotion | RotationMotion | PlanetaryMotion | SwingMotion | PointsMotion | RestMotion,
    Field(discriminator="kind"),
]
