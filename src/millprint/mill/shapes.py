"""Every shape of a vessel or an insert as flat facets, and the registry of the kinds of shape.

To add a shape, write its keys in `config.mill`, a function here that gives its facets, one that gives the cylinders
and tori of which these are pieces, and a record in `SHAPES`. Parameters give the walls of a hollow, seen from inside.
"""

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from millprint.config.mill import (
    BoxGeometry,
    CylinderGeometry,
    LifterDrumGeometry,
    PaddlesGeometry,
    StadiumGeometry,
    StlGeometry,
)
from millprint.mill.curved_surfaces import Curve

# Which ends of a profile have a fillet: the top, the bottom.
_ROUNDED = {"none": (False, False), "bottom": (False, True), "both": (True, True)}

# The outlines (k, 3) of one facet [m]: the outer one first, then holes.
Loops = list[np.ndarray]

# The arcs of a fillet that joins a mantle with a lid above or a floor below it, as (out, up) where it begins and ends.
_UPPER_ARC, _LOWER_ARC = ((1.0, 0.0), (0.0, 1.0)), ((0.0, -1.0), (1.0, 0.0))
_X, _Y, _Z = np.eye(3)

# Columns that turn a shape built along z into one along another axis: cyclic, so that no shape is mirrored.
_ALONG = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}


def _level(outline: np.ndarray, z: float) -> np.ndarray:
    return np.column_stack([outline, np.full(len(outline), z)])


def _circle(radius: float, facets: int) -> np.ndarray:
    angle = 2 * np.pi * np.arange(facets) / facets
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def fillet_profile(height: float, fillet: float, facets: int, ends: str) -> list[tuple[float, float]]:
    """Insets from the side and levels of the rings, from the top at `height` down to 0, all in one unit.

    ends: "none", "bottom" or "both", the ends whose edge is rounded with the radius `fillet` in `facets` steps. The
    rings lie on the smooth fillet. Raises KeyError for other ends.
    """
    angle = np.linspace(0, np.pi / 2, facets + 1)
    rounded = [(fillet * (1 - np.cos(a)), fillet * (1 - np.sin(a))) for a in angle]
    top, bottom = _ROUNDED[ends]
    upper = [(inset, height - level) for inset, level in rounded[::-1]] if fillet and top else [(0.0, height)]
    levels = [*upper, *(rounded if fillet and bottom else [(0.0, 0.0)])]
    # A sphere, or a cup as deep as its fillet, has no straight part between the rounded ones.
    return [levels[0], *(low for high, low in itertools.pairwise(levels) if high[1] - low[1] > 1e-12 * height)]


def loft(rings: list[np.ndarray]) -> list[list[np.ndarray]]:
    """Facets between rings (k, 3), from the top down, each counter-clockwise seen from above; then floor and lid.

    A facet is a list of loops, counter-clockwise seen from inside. A ring of a single point closes an end with
    triangles, and that end has no cap.
    """
    facets = []
    for upper, lower in itertools.pairwise(rings):
        for k in range(max(len(upper), len(lower))):
            # A ring of a single point is its own next point.
            following = [ring[(k + 1) % len(ring)] for ring in (upper, lower)]
            corners = [upper[k % len(upper)], following[0], following[1], lower[k % len(lower)]]
            if len(upper) == 1:
                del corners[1]
            if len(lower) == 1:
                del corners[-1]
            facets.append([np.array(corners)])
    if len(rings[-1]) > 1:
        facets.append([rings[-1]])
    if len(rings[0]) > 1:
        facets.append([rings[0][::-1]])
    return facets


def stadium_outline(end_radius: float, straight: float, facets: int, unevenness: float = 0.0) -> np.ndarray:
    """Vertices (2 facets + 2, 2) of a stadium, counter-clockwise; the long side runs along x, all in one unit.

    Facets of a round end are alternately 1 + unevenness and 1 - unevenness times as wide as the mean. Each end begins
    with a wide one, so that half a turn brings the outline onto itself.
    """
    widths = 1.0 + unevenness * (-1.0) ** np.arange(facets)
    angle = np.pi * (np.concatenate([[0.0], np.cumsum(widths)]) / widths.sum() - 0.5)
    end = end_radius * np.column_stack([np.cos(angle), np.sin(angle)])
    shift = np.array([straight / 2, 0.0])
    return np.concatenate([end + shift, -end - shift])


def stadium_facets(geometry: StadiumGeometry) -> list[Loops]:
    """Outlines [m] of every facet, a list of loops each, counter-clockwise seen from inside the jar.

    The round ends and the fillet have their vertices on the smooth surface. Floor at z = 0, centred on the origin.
    """
    radius, straight, height = geometry.end_radius_mm / 1e3, geometry.straight_mm / 1e3, geometry.height_mm / 1e3
    rings = []
    for inset, z in fillet_profile(height, geometry.fillet_radius_mm / 1e3, geometry.fillet_facets, "bottom"):
        outline = stadium_outline(radius - inset, straight, geometry.facets_per_half_circle, geometry.facet_unevenness)
        rings.append(_level(outline, z))
    *facets, floor, lid = loft(rings)
    if geometry.post:
        ring = _level(_circle(geometry.post.radius_mm / 1e3, geometry.post.facets), 0.0)
        top = ring + np.array([0.0, 0.0, height])
        floor.append(ring[::-1])
        lid.append(top)
        following = np.roll(np.stack([ring, top]), -1, axis=1)
        facets += [[facet] for facet in np.stack([ring, following[0], following[1], top], axis=1)]
    return [*facets, floor, lid]


def stadium_curves(geometry: StadiumGeometry) -> list[Curve]:
    """The round ends, the fillets of ends and sides, and the post."""
    radius, fillet = geometry.end_radius_mm / 1e3, geometry.fillet_radius_mm / 1e3
    half, height = geometry.straight_mm / 2e3, geometry.height_mm / 1e3
    curves = []
    for out in (1.0, -1.0):
        middle, part = out * half * _X, (-out * _Y, out * _Y)
        curves.append(Curve(middle, _Z, radius, part=part, ends=(fillet, height)))
        if fillet:
            curves.append(Curve(middle + fillet * _Z, _Z, radius - fillet, fillet, part=part, arc=_LOWER_ARC))
            lying = (-_Z, _Y) if out > 0 else (-_Y, -_Z)
            side = np.array([0.0, out * (radius - fillet), fillet])
            curves.append(Curve(side, _X, fillet, part=lying, ends=(-half, half)))
    if geometry.post:
        curves.append(Curve(np.zeros(3), _Z, geometry.post.radius_mm / 1e3, hollow=False, ends=(0.0, height)))
    return curves


def _centre_of(geometry: CylinderGeometry) -> np.ndarray:
    """The middle of a cylinder [m]."""
    if geometry.centre_mm is not None:
        return np.array(geometry.centre_mm) / 1e3
    return np.array([0.0, 0.0, geometry.height_mm / 2e3 if geometry.axis == "z" else 0.0])


def cylinder_facets(geometry: CylinderGeometry) -> list[Loops]:
    """Outlines [m] of every facet, a list of loops each, counter-clockwise seen from inside."""
    radius, height, fillet = geometry.radius_mm / 1e3, geometry.height_mm / 1e3, geometry.fillet_radius_mm / 1e3
    rings = []
    for inset, z in fillet_profile(height, fillet, geometry.fillet_facets, geometry.fillet_ends):
        # The last ring of a half sphere is its pole.
        is_pole = radius - inset < 1e-9 * radius
        rings.append(np.array([[0.0, 0.0, z]]) if is_pole else _level(_circle(radius - inset, geometry.facets), z))
    centre = _centre_of(geometry)
    order, half = _ALONG[geometry.axis], np.array([0.0, 0.0, height / 2])
    return [[(loop - half)[:, order] + centre for loop in facet] for facet in loft(rings)]


def cylinder_curves(geometry: CylinderGeometry) -> list[Curve]:
    """The mantle and its fillets."""
    radius, half = geometry.radius_mm / 1e3, geometry.height_mm / 2e3
    fillet, centre = geometry.fillet_radius_mm / 1e3, _centre_of(geometry)
    axis = np.eye(3)["xyz".index(geometry.axis)]
    top, bottom = (half - fillet * is_rounded for is_rounded in _ROUNDED[geometry.fillet_ends])
    curves = [Curve(centre, axis, radius, ends=(-bottom, top))]
    for is_rounded, up, arc in zip(_ROUNDED[geometry.fillet_ends], (1, -1), (_UPPER_ARC, _LOWER_ARC), strict=True):
        if fillet and is_rounded:
            curves.append(Curve(centre + up * (half - fillet) * axis, axis, max(radius - fillet, 0.0), fillet, arc=arc))
    return curves


def lifter_drum_outline(geometry: LifterDrumGeometry) -> np.ndarray:
    """Vertices (k, 2) [m] of the shell and its lifters, counter-clockwise; the first lifter is on the x axis."""
    radius = geometry.radius_mm / 1e3
    top, half = radius - geometry.lifters.height_mm / 1e3, geometry.top_half_width_mm / 1e3
    return _toothed(radius, (top, half), geometry.foot_angle, geometry.lifters.number, geometry.facets)


def _toothed(radius: float, end: tuple[float, float], foot: float, number: int, facets: int) -> np.ndarray:
    """Vertices (k, 2) [m] of a round outline with bars, inwards or outwards, counter-clockwise; the first is along x.

    end: distance of a bar's flat end from the axis, and half its width [m]; foot: angle from the middle of a bar to
    where it meets the round [rad]; facets: of a whole turn.
    """
    pitch, (reach, half) = 2 * np.pi / number, end
    arc = np.linspace(foot, pitch - foot, max(1, round(facets * (pitch - 2 * foot) / (2 * np.pi))) + 1)
    piece = np.concatenate([[[reach, -half], [reach, half]], radius * np.column_stack([np.cos(arc), np.sin(arc)])])
    turned = []
    for bar in range(number):
        cosine, sine = np.cos(bar * pitch), np.sin(bar * pitch)
        turned.append(piece @ np.array([[cosine, sine], [-sine, cosine]]))
    return np.concatenate(turned)


def lifter_drum_facets(geometry: LifterDrumGeometry) -> list[Loops]:
    """Outlines [m] of every facet, counter-clockwise seen from inside; centred on the origin."""
    outline, half = lifter_drum_outline(geometry), geometry.length_mm / 2e3
    order = _ALONG[geometry.axis]
    return [[loop[:, order] for loop in facet] for facet in loft([_level(outline, half), _level(outline, -half)])]


def lifter_drum_curves(geometry: LifterDrumGeometry) -> list[Curve]:
    """The shell."""
    half = geometry.length_mm / 2e3
    return [Curve(np.zeros(3), np.eye(3)["xyz".index(geometry.axis)], geometry.radius_mm / 1e3, ends=(-half, half))]


def box_facets(geometry: BoxGeometry) -> list[Loops]:
    """Outlines [m] of the six facets, counter-clockwise seen from inside."""
    half = np.array([geometry.x_mm, geometry.y_mm, geometry.z_mm]) / 2e3
    centre = np.array([0.0, 0.0, half[2]]) if geometry.centre_mm is None else np.array(geometry.centre_mm) / 1e3
    outline = half[:2] * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return [[loop + centre for loop in facet] for facet in loft([_level(outline, half[2]), _level(outline, -half[2])])]


def paddles_outline(geometry: PaddlesGeometry) -> np.ndarray:
    """Vertices (k, 2) [m] of hub and blades, counter-clockwise; the first blade points along x."""
    hub, half = geometry.hub_radius_mm / 1e3, geometry.blade_thickness_mm / 2e3
    tip = hub + geometry.blade_length_mm / 1e3
    return _toothed(hub, (tip, half), np.arcsin(half / hub), geometry.blades, geometry.hub_facets)


def paddles_facets(geometry: PaddlesGeometry) -> list[Loops]:
    """Outlines [m] of every facet, counter-clockwise seen from inside the solid."""
    outline, bottom = paddles_outline(geometry), geometry.bottom_mm / 1e3
    return loft([_level(outline, bottom + geometry.height_mm / 1e3), _level(outline, bottom)])


def paddles_curves(geometry: PaddlesGeometry) -> list[Curve]:
    """The hub, from inside as its facets are given."""
    bottom, height = geometry.bottom_mm / 1e3, geometry.height_mm / 1e3
    return [Curve(np.zeros(3), _Z, geometry.hub_radius_mm / 1e3, ends=(bottom, bottom + height))]


def _no_curves(_geometry: Any) -> list[Curve]:
    return []


def _file_surface(geometry: StlGeometry) -> tuple[list[Loops], float]:
    # Takes long to import, and few mills need it.
    from millprint.mill.mesh import read_surface

    return read_surface(geometry)


@dataclass(frozen=True)
class Shape:
    """A kind of shape: its facets and curves from its keys, and whether these are given as seen from inside."""

    facets: Callable[[Any], Any]
    curves: Callable[[Any], list[Curve]] = _no_curves
    from_inside: bool = True
    # From a file, whose curves are found again (mill.recognition): with its facets comes what they are rounded by.
    is_mesh: bool = False


SHAPES = {
    "stadium": Shape(stadium_facets, stadium_curves),
    "cylinder": Shape(cylinder_facets, cylinder_curves),
    "lifter_drum": Shape(lifter_drum_facets, lifter_drum_curves),
    "box": Shape(box_facets),
    "paddles": Shape(paddles_facets, paddles_curves),
    "stl": Shape(_file_surface, from_inside=False, is_mesh=True),
}
