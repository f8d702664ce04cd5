"""Motions of a mill's bodies: the keys of each kind and the registry of their properties.

To add a motion, write its section with its words and its `drive`, and add a record to `MOTIONS`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, Field, model_validator

from millprint.config.section import (
    Place,
    PlaceVector,
    Scale,
    Section,
    Size,
    Vector,
    VesselSize,
    has_direction,
    kind_of,
    project_path,
)

Multiple = Annotated[int, Field(ge=1, le=1000, description="frequency over the mill's frequency [-]")]
Phase = Annotated[float, Field(description="phase of the sine [deg]; 90 makes it a cosine")]
Ratio = Annotated[float, Field(ge=-1000, le=1000)]
Axis = Annotated[Vector, AfterValidator(has_direction)]


# The sum of amplitudes below which nothing moves [m].
LEAST_M = 1e-9
# Advice in the message for a motion that does not move.
STILL = "nothing would move; give the value of the machine, or for a body at rest the motion {kind: rest}"


class Harmonic(Section):
    """One term of a translation: amplitude sin(multiple w t + phase) along one axis."""

    axis: Literal["x", "y", "z"]
    """axis of the term; z points up"""
    amplitude_mm: Place
    """amplitude of the term [mm]"""
    multiple: Multiple = 1
    phase_deg: Phase = 0.0


@dataclass(frozen=True)
class Drive:
    """What a motion does in each turn of the mill; `millprint.mill.motion` makes it a function of time.

    harmonics: of the translation, each a multiple of the mill's frequency and the amplitudes of its cosine (x, y, z)
        and its sine (x, y, z) [m];
    axis, pivot_mm: the axis, of any length, and a point of it [mm]; turns: steady turns about it [-];
    swing: harmonics of the angle, each a multiple and the amplitudes of its cosine and its sine [rad];
    own_turns: turns of the body about its own axis, for a stirrer that is faster than the mill [-];
    table, scale: path of a table of points, in place of all the others, and the factor on its coordinates;
    points: such a table as it is computed, for a motion with a dwell or a stroke: rows of the time in any unit, x, y, z
        [m] and, for a body that turns, the rotation as axis times angle [deg]; the last as the first, a turn later;
    carrier: another drive that carries the whole motion along, such as that of a frame whose axis swings; both come
        back after a turn of the mill.
    """

    harmonics: Sequence[Sequence[float]] = ((1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),)
    axis: Vector = (0.0, 0.0, 1.0)
    pivot_mm: Vector = (0.0, 0.0, 0.0)
    turns: float = 0.0
    swing: Sequence[Sequence[float]] = ()
    own_turns: float = 1.0
    table: str | None = None
    scale: float = 1.0
    points: Sequence[Sequence[float]] = ()
    carrier: "Drive | None" = None

    @property
    def is_curve(self) -> bool:
        """Whether the motion is a curve through points, and not harmonics and turns about one axis."""
        return self.table is not None or bool(self.points) or self.carrier is not None


def _circle(radius_mm: float) -> list[list[float]]:
    radius_m = radius_mm / 1e3
    return [[1, radius_m, 0.0, 0.0, 0.0, radius_m, 0.0]]


def _sum(terms: Sequence[Harmonic]) -> list[list[float]]:
    """The harmonics of a list of terms, one for each multiple."""
    rows: dict[int, list[float]] = {1: [1, *[0.0] * 6]}
    for term in terms:
        column, phase = 1 + "xyz".index(term.axis), math.radians(term.phase_deg)
        harmonic = rows.setdefault(term.multiple, [term.multiple, *[0.0] * 6])
        harmonic[column] += term.amplitude_mm / 1e3 * math.sin(phase)
        harmonic[column + 3] += term.amplitude_mm / 1e3 * math.cos(phase)
    return list(rows.values())


class MotionSection(Section):
    """The keys of a motion, whose `kind` is that of its record in MOTIONS.

    needs: keys of numbers without which nothing would move; at 0 they are refused.
    """

    kind: str
    needs: ClassVar[tuple[str, ...]] = ()

    @property
    def record(self) -> "MotionKind":
        """The record of the kind of motion."""
        return MOTIONS[self.kind]

    @model_validator(mode="before")
    @classmethod
    def _moves(cls, content: Any) -> Any:
        for key in cls.needs:
            if isinstance(content, dict) and type(content.get(key)) in (int, float) and content[key] == 0:
                raise ValueError(f"{key} = 0: {STILL}")
        return content

    def in_words(self) -> str:
        """What a body with this motion does, as the end of a sentence, for a reader who does not know the machine."""
        raise NotImplementedError(f"a motion of kind {self.kind!r} has no words")

    def drive(self) -> Drive:
        """What the motion does in each turn of the mill."""
        raise NotImplementedError(f"a motion of kind {self.kind!r} has no drive")


class CircleMotion(MotionSection):
    """Translation on a horizontal circle without turning: x = A cos wt, y = A sin wt (Emax, thesis Sec. 3.2.2)."""

    kind: Literal["circle"]
    needs = ("amplitude_mm",)
    amplitude_mm: Size
    """radius A of the circle [mm]"""

    def in_words(self) -> str:
        """What a body does."""
        return f"moves on a horizontal circle of {self.amplitude_mm:g} mm radius without turning"

    def drive(self) -> Drive:
        """x = A cos wt, y = A sin wt."""
        return Drive(_circle(self.amplitude_mm))


class LissajousMotion(MotionSection):
    """Translation without turning, a sum of harmonics of the mill's frequency (thesis Eqs 6.34, 6.35)."""

    kind: Literal["lissajous"]
    terms: list[Harmonic] = Field(min_length=1)
    """the harmonics"""

    @model_validator(mode="after")
    def _terms_move(self) -> "LissajousMotion":
        if not any(abs(value) > LEAST_M for row in _sum(self.terms) for value in row[1:]):
            raise ValueError(f"terms: the amplitudes add up to 0: {STILL}")
        return self

    def in_words(self) -> str:
        """What a body does."""
        return "is shaken along a sum of harmonic motions without turning"

    def drive(self) -> Drive:
        """The sum of the terms."""
        return Drive(_sum(self.terms))


class FigureOfEightMotion(MotionSection):
    """Translation along a figure of eight in a plane, A sin wt along it, B sin 2 wt across it: a SPEX-like shaker."""

    kind: Literal["figure_of_eight"]
    needs = ("along_mm", "across_mm")
    along_mm: Size
    """amplitude A along the figure [mm]"""
    across_mm: Size
    """amplitude B across the figure [mm]"""
    plane: Literal["xy", "xz", "yx", "yz", "zx", "zy"] = "xz"
    """the axes along and across the figure; z points up"""

    def in_words(self) -> str:
        """What a body does."""
        return f"is shaken on a figure of eight, {2 * self.along_mm:g} mm long and {2 * self.across_mm:g} mm wide"

    def drive(self) -> Drive:
        """The Lissajous figure 1 : 2 of its two harmonics."""
        along = Harmonic(axis=self.plane[0], amplitude_mm=self.along_mm)
        across = Harmonic(axis=self.plane[1], amplitude_mm=self.across_mm, multiple=2)
        return Drive(_sum([along, across]))


class RotationMotion(MotionSection):
    """Turning about a fixed axis: a tumbling drum, the shaft of an attritor."""

    kind: Literal["rotation"]
    needs = ("ratio",)
    axis: Axis
    """direction of the axis; it turns counter-clockwise about it"""
    pivot_mm: PlaceVector = (0.0, 0.0, 0.0)
    """a point of the axis [mm]"""
    ratio: Ratio = 1.0
    """turns for each turn of the mill's stated speed, not 0 [-]; < 0 turns back"""

    def in_words(self) -> str:
        """What a body does."""
        return f"turns about a fixed axis{'' if abs(self.ratio) == 1 else f', {self.ratio:g} times a turn'}"

    def drive(self) -> Drive:
        """Steady turning about the axis."""
        return Drive(axis=self.axis, pivot_mm=self.pivot_mm, turns=self.ratio, own_turns=abs(self.ratio))


class PlanetaryMotion(MotionSection):
    """A jar on a sun wheel about the vertical z; the mill's stated speed is the sun wheel's, counter-clockwise.

    The ratio is the jar's speed about its own axis, measured from the turning sun wheel, over the sun wheel's speed:
    what makers print as 1 : -2 is ratio -2. Relative to the laboratory the jar turns at (1 + ratio) w, and at -1 it
    does not turn at all. It is the ratio whose critical value is sqrt(R / l) - 1 for balls at a distance l from the
    jar's axis (Mio, Kano, Saito, Mater. Sci. Eng. A 332, 2002, 75). At 0 the jar would be fixed to the sun wheel: a
    centrifuge, not a planetary mill. Its motion is a rotation about the wheel's axis.
    """

    kind: Literal["planetary"]
    needs = ("sun_radius_mm",)
    sun_radius_mm: VesselSize
    """distance of the jar's axis from the sun wheel's axis [mm]"""
    ratio: Ratio
    """jar's speed relative to the sun wheel over the wheel's speed, not 0 [-]; < 0 is counter"""

    @model_validator(mode="after")
    def _spins(self) -> "PlanetaryMotion":
        if self.ratio == 0:
            raise ValueError(
                "ratio = 0: the jar would be fixed to the sun wheel without a spin of its own, as in a centrifuge; "
                "give the jar's speed over the wheel's, such as -2, or for a centrifuge the motion {kind: rotation, "
                f"axis: [0, 0, 1], pivot_mm: [-{self.sun_radius_mm:g}, 0, 0]}}"
            )
        return self

    def in_words(self) -> str:
        """What a body does."""
        return (
            f"is carried round by a sun wheel, its axis {self.sun_radius_mm:g} mm from the wheel's, and turns about "
            f"this axis at {self.ratio:g} times the wheel's speed, relative to the wheel"
        )

    def drive(self) -> Drive:
        """The circle of the jar's axis; the jar turns 1 + ratio times, since the sun wheel carries it round once."""
        return Drive(_circle(self.sun_radius_mm), turns=1 + self.ratio, own_turns=abs(self.ratio))


class SwingMotion(MotionSection):
    """Oscillation about an axis through a pivot, angle = amplitude sin(multiple w t + phase), and a translation."""

    kind: Literal["swing"]
    needs = ("amplitude_deg",)
    axis: Axis
    """direction of the axis; a positive angle is counter-clockwise about it"""
    pivot_mm: PlaceVector
    """a point of the axis [mm]"""
    amplitude_deg: Annotated[float, Field(gt=0, le=180)]
    """largest angle from the middle [deg]"""
    multiple: Multiple = 1
    phase_deg: Phase = 0.0
    terms: list[Harmonic] = []
    """harmonics of a translation on top"""

    def in_words(self) -> str:
        """What a body does."""
        further = " with a further motion on top" if self.terms else ""
        return f"swings to and fro by {self.amplitude_deg:g} degrees to each side{further}"

    def drive(self) -> Drive:
        """One harmonic of the angle, and the sum of the terms."""
        amplitude, phase = math.radians(self.amplitude_deg), math.radians(self.phase_deg)
        swing = [[self.multiple, amplitude * math.sin(phase), amplitude * math.cos(phase)]]
        return Drive(_sum(self.terms), self.axis, self.pivot_mm, swing=swing)


class PointsMotion(MotionSection):
    """A measured or designed motion: a table over one turn of the mill, joined by a smooth periodic curve.

    The table (TSV) has the columns time_s, x_m, y_m, z_m, the place of the body frame's origin, and if the body turns
    rotation_x_deg, rotation_y_deg, rotation_z_deg: its rotation as axis times angle, relative to the laboratory. Its
    last row repeats the first, a turn later. The table is one turn of the mill, whatever time it took: at n rpm it is
    run through in 60/n s. In between the curve is a periodic cubic spline (of quaternions for the rotation).
    """

    kind: Literal["points"]
    path: Annotated[str, project_path(".tsv")]
    """the table, from the project's root: .tsv"""
    scale: Scale = 1.0
    """factor on the coordinates of the table [-]"""

    def in_words(self) -> str:
        """What a body does."""
        return "follows a curve that is given as a table of points"

    def drive(self) -> Drive:
        """The table."""
        return Drive(table=self.path, scale=self.scale)


class RestMotion(MotionSection):
    """A body at rest."""

    kind: Literal["rest"]

    def in_words(self) -> str:
        """What a body does."""
        return "stands still"

    def drive(self) -> Drive:
        """Nothing."""
        return Drive()


class Agitation(Enum):
    """How a moving wall agitates the balls; it decides which speeds suit a mill, and which are beyond any machine."""

    SHAKEN = "shaken"  # by its acceleration
    TUMBLED = "tumbled"  # by gravity, in a drum
    STIRRED = "stirred"  # by the speed of a stirrer's tip
    STILL = "still"


@dataclass(frozen=True)
class MotionKind:
    """A kind of motion: its keys with their drive, and how it agitates as the motion of a vessel or of an insert.

    amplitude_key: the key that `amplitudes_mm` of a sweep replaces; none for a motion without one amplitude.
    """

    section: type[MotionSection]
    vessel: Agitation = Agitation.SHAKEN
    insert: Agitation = Agitation.SHAKEN
    amplitude_key: str | None = None

    @property
    def moves(self) -> bool:
        """Whether a body with this motion ever moves."""
        return self.vessel is not Agitation.STILL


MOTIONS = {
    kind_of(record.section): record
    for record in (
        MotionKind(CircleMotion, amplitude_key="amplitude_mm"),
        MotionKind(LissajousMotion),
        MotionKind(FigureOfEightMotion),
        MotionKind(RotationMotion, vessel=Agitation.TUMBLED, insert=Agitation.STIRRED),
        MotionKind(PlanetaryMotion, amplitude_key="sun_radius_mm"),
        MotionKind(SwingMotion),
        MotionKind(PointsMotion),
        MotionKind(RestMotion, vessel=Agitation.STILL, insert=Agitation.STILL),
    )
}


if TYPE_CHECKING:
    Motion = MotionSection
else:
    Motion = Annotated[reduce(or_, (record.section for record in MOTIONS.values())), Field(discriminator="kind")]
