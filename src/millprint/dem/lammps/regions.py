"""The walls of a mill as regions of LAMMPS, and their motion as variables."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from millprint.config.geometry import BoxGeometry, CylinderGeometry, DrumGeometry, LifterDrumGeometry
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import Drive
from millprint.mill.motion import Motion

AXES = "xyz"
# Half the size of a block that is endless across two of its axes [m].
ENDLESS = 100.0


@dataclass(frozen=True)
class Region:
    """A vessel as a region of LAMMPS; of a round one, the number of its axis and its ends along it [m]."""

    words: str
    along: int = 0
    low: float = 0.0
    high: float = 0.0


@dataclass(frozen=True)
class Form:
    """A kind of shape that LAMMPS has.

    region(shape): its vessel; lacks(shape, drive): the key that LAMMPS cannot express, and why; parts(shape): walls
    besides the vessel, each of which turns about the axis on its own, and part(shape): the first of them.
    """

    region: Callable[[Any], Region]
    lacks: Callable[[Any, Drive], str | None] = lambda shape, drive: None
    parts: Callable[[Any], int] = lambda shape: 0
    part: Callable[[Any], str] = lambda shape: ""


def unsupported(mill: MillConfig) -> str | None:
    """The key of a mill that LAMMPS cannot express, and why; None for one that it can."""
    shape, motion, drive = mill.geometry, mill.motion, mill.motion.drive()
    if shape.kind not in FORMS:
        return f"geometry.kind = {shape.kind}: LAMMPS gets {', '.join(FORMS)}"
    if shape.faceted:
        return "geometry.faceted = true: LAMMPS has smooth walls"
    if drive.is_curve:
        return f"motion.kind = {motion.kind}: LAMMPS gets motions of harmonics and rotations"
    if reason := FORMS[shape.kind].lacks(shape, drive):
        return reason
    return "inserts: LAMMPS gets the vessel only" if mill.inserts else None


def _waves(rows: np.ndarray, cosine: int, sine: int) -> str:
    """The formula of a sum of waves: angular frequency [rad/s] and the amplitudes in two columns."""
    terms = []
    for row in rows.tolist():
        if row[cosine]:
            terms.append(f"{row[cosine]!r}*cos({row[0]!r}*v_t)")
        if row[sine]:
            terms.append(f"{row[sine]!r}*sin({row[0]!r}*v_t)")
    return "+".join(terms)


def motion_lines(motion: Motion, start: int) -> tuple[list[str], str]:
    """Variables of a motion from step `start` on, and the words that give it to a region in the body frame.

    LAMMPS turns a region by v_angle about a point and moves it then, as `mill.motion` does.
    """
    lines, words = [f"variable t equal dt*(step-{start})*(step>{start})"], ""
    moved = [_waves(motion.harmonics, 1 + axis, 4 + axis) for axis in range(3)]
    if any(moved):
        lines += [f"variable d{name} equal {text}" for name, text in zip(AXES, moved, strict=True) if text]
        words += f" move {' '.join(f'v_d{name}' if text else 'NULL' for name, text in zip(AXES, moved, strict=True))}"
    if motion.turns:
        turned = [f"{motion.rate!r}*v_t" if motion.rate else "", _waves(motion.swing, 1, 2)]
        lines.append(f"variable angle equal {'+'.join(filter(None, turned))}")
        words += f" rotate v_angle {' '.join(map(repr, [*motion.pivot.tolist(), *motion.axis.tolist()]))}"
    return lines, words


def _block(low: np.ndarray, high: np.ndarray) -> str:
    return "block " + " ".join(f"{a!r} {b!r}" for a, b in zip(low.tolist(), high.tolist(), strict=True))


def _box(shape: BoxGeometry) -> Region:
    half = np.array([shape.x_mm, shape.y_mm, shape.z_mm]) / 2e3
    centre = np.array([0, 0, half[2]]) if shape.centre_mm is None else np.array(shape.centre_mm) / 1e3
    return Region(_block(centre - half, centre + half))


def _round(shape: DrumGeometry, length: float, centre: np.ndarray) -> Region:
    """A cylinder of a length [m] about its centre (3,) [m]."""
    along, radius = AXES.index(shape.axis), shape.radius_mm / 1e3
    low, high = float(centre[along] - length / 2), float(centre[along] + length / 2)
    first, second = np.delete(centre, along).tolist()
    return Region(f"cylinder {shape.axis} {first!r} {second!r} {radius!r} {low!r} {high!r}", along, low, high)


def _cylinder(shape: CylinderGeometry) -> Region:
    length, centre = shape.height_mm / 1e3, np.zeros(3)
    if shape.centre_mm is not None:
        centre = np.array(shape.centre_mm) / 1e3
    elif shape.axis == "z":
        centre[2] = length / 2
    return _round(shape, length, centre)


def _fillets(shape: CylinderGeometry, _drive: Drive) -> str | None:
    if shape.fillet_radius_mm and shape.fillet_ends != "none":
        return f"geometry.fillet_radius_mm = {shape.fillet_radius_mm:g}: LAMMPS's cylinder has flat ends"
    return None


def _drum(shape: LifterDrumGeometry) -> Region:
    return _round(shape, shape.length_mm / 1e3, np.zeros(3))


def _slanted(shape: LifterDrumGeometry, drive: Drive) -> str | None:
    if shape.lifters.face_angle_deg != 90:
        return f"geometry.lifters.face_angle_deg = {shape.lifters.face_angle_deg:g}: LAMMPS gets lifters of 90 degrees"
    along = AXES.index(shape.axis)
    off_axis = (value for vector in (drive.axis, drive.pivot_mm) for axis, value in enumerate(vector) if axis != along)
    if (drive.turns or drive.swing) and any(off_axis):
        return "motion.axis: LAMMPS turns a drum with lifters about its own axis only"
    return None


def _lifter(shape: LifterDrumGeometry) -> str:
    """The first lifter: a block that reaches through the shell and the ends, where no ball is."""
    along = AXES.index(shape.axis)
    radial, across = (along + 1) % 3, (along + 2) % 3
    inner, height, low, high = shape.radius_mm / 1e3, shape.lifters.height_mm / 1e3, np.zeros(3), np.zeros(3)
    low[[along, radial, across]] = -shape.length_mm / 1e3, inner - height, -shape.lifters.width_mm / 2e3
    high[[along, radial, across]] = shape.length_mm / 1e3, inner + height, shape.lifters.width_mm / 2e3
    return _block(low, high)


# By the kind of a geometry.
FORMS = {
    "cylinder": Form(_cylinder, _fillets),
    "lifter_drum": Form(_drum, _slanted, lambda shape: shape.lifters.number, _lifter),
    "box": Form(_box),
}


def wall_lines(mill: MillConfig, motion: Motion, start: int, law: str, smooth_law: str) -> list[str]:
    """Regions and walls of a mill that starts at a step; law: of the walls; smooth_law: of ends without friction."""
    shape = mill.geometry
    lines, words = motion_lines(motion, start)

    def wall(name: str, region: str, side: str, own: str, at: str = "", ends: str = "") -> list[str]:
        return [
            f"region {name} {region} side {side}{at or words} units box{ends}",
            f"fix {name} all wall/gran/region granular {own} region {name}",
        ]

    form = FORMS[shape.kind]
    region, parts, has_ends = form.region(shape), form.parts(shape), shape.smooth_axis is not None
    lines += wall("vessel", region.words, "in", law, ends=" open 1 open 2" if has_ends else "")
    end = np.eye(3)[region.along]
    if has_ends:
        corner = np.full(3, ENDLESS)
        corner[region.along] = 0
        lines += wall("ends", _block(region.low * end - corner, region.high * end + corner), "in", smooth_law)
    axis, sense = " ".join(map(repr, end.tolist())), float(motion.axis[region.along])
    for number in range(parts):
        place = 2 * np.pi * number / parts
        turned = f"+{sense!r}*v_angle" if motion.turns else ""
        lines.append(f"variable angle{number} equal {float(place)!r}{turned}")
        moved = words.split(" rotate")[0]
        at = f"{moved} rotate v_angle{number} 0.0 0.0 0.0 {axis}"
        lines += wall(f"lifter{number}", form.part(shape), "out", law, at)
    return lines
