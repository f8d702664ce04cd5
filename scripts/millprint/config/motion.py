"""Motions of a mill's bodies, as laws with a few parameters; `millprint.mill.motion` reduces each to one form."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from millprint.config.section import Positive, Section

Vector = tuple[float, float, float]


def _has_length(vector: Vector) -> Vector:
    if not any(vector):
        raise ValueError("axis = [0, 0, 0]: an axis needs a direction")
    return vector


Axis = Annotated[Vector, AfterValidator(_has_length)]


class CircleMotion(Section):
    """Translation on a horizontal circle without turning: x = A cos wt, y = A sin wt (Emax, thesis Sec. 3.2.2)."""

    kind: Literal["circle"]
    amplitude_mm: Positive = Field(description="radius A of the circle [mm]")


class Harmonic(Section):
    """One term of a translation: amplitude sin(multiple w t + phase) along one axis."""

    axis: Literal["x", "y", "z"] = Field(description="axis of the term; z points up")
    amplitude_mm: float = Field(description="amplitude of the term [mm]")
    multiple: Annotated[int, Field(ge=1)] = Field(default=1, description="frequency over the mill's frequency [-]")
    phase_deg: float = Field(default=0.0, description="phase of the sine [deg]; 90 makes it a cosine")


class LissajousMotion(Section):
    """Translation without turning, a sum of harmonics of the mill's frequency (thesis Eqs 6.34, 6.35)."""

    kind: Literal["lissajous"]
    terms: list[Harmonic] = Field(min_length=1, description="the harmonics")


class RotationMotion(Section):
    """Turning about a fixed axis: a tumbling drum, the shaft of an attritor."""

    kind: Literal["rotation"]
    axis: Axis = Field(description="direction of the axis; it turns counter-clockwise about it")
    pivot_mm: Vector = Field(default=(0.0, 0.0, 0.0), description="a point of the axis [mm]")
    ratio: float = Field(default=1.0, description="turns for each turn of the mill's stated speed [-]; < 0 turns back")


class PlanetaryMotion(Section):
    """A jar on a sun wheel about the vertical z; the mill's stated speed is the sun wheel's, counter-clockwise.

    The ratio is the jar's speed about its own axis, measured from the turning sun wheel, over the sun wheel's speed:
    what makers print as 1 : -2 is ratio -2. Seen from the laboratory the jar spins at (1 + ratio) w, and at -1 it
    does not spin at all. It is the ratio whose critical value is sqrt(R / l) - 1 for balls at a distance l from the
    jar's axis (Mio, Kano, Saito, Mater. Sci. Eng. A 332, 2002, 75).
    """

    kind: Literal["planetary"]
    sun_radius_mm: Positive = Field(description="distance of the jar's axis from the sun wheel's axis [mm]")
    ratio: float = Field(description="jar's speed relative to the sun wheel over the wheel's speed [-]; < 0 is counter")


class SwingMotion(Section):
    """Oscillation about an axis through a pivot, angle = amplitude sin(multiple w t + phase), and a translation."""

    kind: Literal["swing"]
    axis: Axis = Field(description="direction of the axis; a positive angle is counter-clockwise about it")
    pivot_mm: Vector = Field(description="a point of the axis [mm]")
    amplitude_deg: Annotated[float, Field(gt=0, le=180)] = Field(description="largest angle from the middle [deg]")
    multiple: Annotated[int, Field(ge=1)] = Field(default=1, description="frequency over the mill's frequency [-]")
    phase_deg: float = Field(default=0.0, description="phase of the sine [deg]; 90 makes it a cosine")
    terms: list[Harmonic] = Field(default=[], description="harmonics of a translation on top")


class RestMotion(Section):
    """A body that stands still."""

    kind: Literal["rest"]


Motion = Annotated[
    CircleMotion | LissajousMotion | RotationMotion | PlanetaryMotion | SwingMotion | RestMotion,
    Field(discriminator="kind"),
]
