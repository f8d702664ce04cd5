"""Cylinders, spheres and tori found again in a mesh, of which a program for drawing had made facets.

Such programs put the corners of the triangles on the surface itself, to the digits of the file. So a surface is taken
for a cylinder where the vertices of at least three neighbouring facets lie on one; what lies on none stays as it is
drawn, and so do cones. A file whose flat facets are meant says `faceted: true`.
"""

from collections.abc import Callable, Iterable

import numpy as np

from millprint.mill.curved_surfaces import Curve
from millprint.mill.vessel import ON_CURVE, Vessel

# Facets that turn by more against each other are not taken for a round wall [rad]: a prism of 18 sides is one.
LARGEST_TURN = 0.36
SMALLEST_TURN = 1e-5
# A first guess is from two facets, whose noise it magnifies; what is found is fitted and checked again.
LOOSE = 30.0
# Four points may lie on one circle by chance of symmetry; this number of steps around or across does not.
FEWEST_STEPS = 5
# What angles of half and whole turns may be off [rad].
ROUNDING = 1e-4
# A piece must cover its part of the surface by this share, so that its borders are those of `Curve`.
COVERED = 0.985


class _Mesh:
    """The facets of a vessel, their vertices and neighbours across shallow edges, and which are taken."""

    def __init__(self, vessel: Vessel) -> None:
        self.normals = np.array([facet.normal for facet in vessel.facets])
        self.points = [np.concatenate(facet.loops) for facet in vessel.facets]
        self.areas = np.array([facet.area for facet in vessel.facets])
        self.tolerance = ON_CURVE * vessel.size
        self.taken = np.zeros(len(vessel.facets), dtype=bool)
        self.neighbours: list[list[int]] = [[] for _ in vessel.facets]
        shallow = [edge for edge in vessel.edges if abs(edge.turn) < LARGEST_TURN]
        for edge in shallow:
            first, second = edge.facets
            self.neighbours[first].append(second)
            self.neighbours[second].append(first)
        # To begin with, those that turn; long ones first: those of a mantle, before those across a rounded end.
        bent = [edge for edge in shallow if abs(edge.turn) > SMALLEST_TURN]
        bent.sort(key=lambda edge: -np.linalg.norm(edge.end - edge.start))
        self.seams = [edge.facets for edge in bent]

    def all_points(self, facets: Iterable[int]) -> np.ndarray:
        """The vertices (n, 3) of some facets."""
        return np.concatenate([self.points[facet] for facet in facets])

    def grown(self, seed: Iterable[int], holds: Callable[[int], bool]) -> list[int]:
        """Free facets that are connected with a seed by shallow edges and of which something holds."""
        found, front = set(seed), list(seed)
        while front:
            for facet in self.neighbours[front.pop()]:
                if facet not in found and not self.taken[facet] and holds(facet):
                    found.add(facet)
                    front.append(facet)
        return sorted(found)


def _circle(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Middle (2,) and radius of the circle nearest to points (n, 2), by linear least squares (Kasa 1976)."""
    shift = points.mean(axis=0)
    local = points - shift
    solution, *_ = np.linalg.lstsq(
        np.column_stack([2 * local, np.ones(len(local))]), (local**2).sum(axis=1), rcond=None
    )
    return solution[:2] + shift, float(np.sqrt(max(solution[2] + solution[:2] @ solution[:2], 0.0)))


def _across(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors across an axis that make a right-handed triad with it."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(helper, axis)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def _span(angles: list[np.ndarray]) -> tuple[float, float]:
    """Where the parts of a turn that some facets cover begin and end [rad]; a whole turn if no gap is left.

    angles: of the vertices of each facet.
    """
    pieces = []
    for of_facet in angles:
        around = (of_facet - of_facet[0] + np.pi) % (2 * np.pi) - np.pi + of_facet[0]
        pieces.append((around.min() % (2 * np.pi), np.ptp(around)))
    pieces.sort()
    begin, end = pieces[0][0], pieces[0][0] + pieces[0][1]
    gap_at, widest = None, 1e-6
    for start, width in [*pieces[1:], (pieces[0][0] + 2 * np.pi, 0.0)]:
        if start - end > widest:
            gap_at, widest = (end, start), start - end
        end = max(end, start + width)
    return (begin, begin + 2 * np.pi) if gap_at is None else (gap_at[1] - 2 * np.pi, gap_at[0])


def _parts(begin: float, end: float) -> list[tuple[float, float] | None]:
    """A part of a turn in pieces of up to half a turn; None for a whole turn."""
    if end - begin > 2 * np.pi - ROUNDING:
        return [None]
    count = int(np.ceil((end - begin - ROUNDING) / np.pi))
    cuts = begin + np.arange(count + 1) * min((end - begin) / count, np.pi)
    return list(zip(cuts[:-1].tolist(), cuts[1:].tolist(), strict=True))


def _turned(parts: list[tuple[float, float] | None], u: np.ndarray, v: np.ndarray) -> list[tuple | None]:
    """Parts of a turn as pairs of unit vectors."""
    return [part and tuple(np.cos(angle) * u + np.sin(angle) * v for angle in part) for part in parts]


def _cylinder(mesh: _Mesh, facets: list[int]) -> tuple[np.ndarray, np.ndarray, float]:
    """Axis (3,), a point on it (3,) and radius of the cylinder nearest to some facets."""
    normals = mesh.normals[facets]
    axis = np.linalg.eigh(normals.T @ (mesh.areas[facets][:, None] * normals))[1][:, 0]
    u, v = _across(axis)
    points = mesh.all_points(facets)
    middle, radius = _circle(points @ np.array([u, v]).T)
    return axis, middle[0] * u + middle[1] * v, radius


def _on_cylinder(
    mesh: _Mesh, axis: np.ndarray, origin: np.ndarray, radius: float, slack: float
) -> Callable[[int], bool]:
    def holds(facet: int) -> bool:
        away = mesh.points[facet] - origin
        out = np.linalg.norm(away - np.outer(away @ axis, axis), axis=1)
        return bool(np.abs(out - radius).max() <= slack * mesh.tolerance and abs(mesh.normals[facet] @ axis) < 1e-3)

    return holds


def _is_hollow(mesh: _Mesh, facets: list[int], outwards: np.ndarray) -> bool:
    """Whether the balls are on the inner side of a surface; outwards (f, 3): away from its middle at each facet."""
    return bool((mesh.normals[facets] * outwards).sum(axis=1).mean() < 0)


def find_cylinders(mesh: _Mesh) -> list[Curve]:
    """The cylinders of a mesh; their facets are marked as taken."""
    curves = []
    for first, second in mesh.seams:
        if mesh.taken[[first, second]].any():
            continue
        pair = sorted((first, second))
        fitted = _cylinder(mesh, pair)
        if not all(map(_on_cylinder(mesh, *fitted, LOOSE), pair)):
            continue
        facets = mesh.grown(pair, _on_cylinder(mesh, *fitted, LOOSE))
        axis, origin, radius = fitted = _cylinder(mesh, facets)
        if len(facets) < FEWEST_STEPS or not all(map(_on_cylinder(mesh, *fitted, 1.0), facets)):
            continue
        u, v = _across(axis)
        along = mesh.all_points(facets) @ axis
        angles = [np.arctan2((mesh.points[f] - origin) @ v, (mesh.points[f] - origin) @ u) for f in facets]
        begin, end = _span(angles)
        widths = [np.ptp((of - of[0] + np.pi) % (2 * np.pi)) for of in angles]
        # The area of the facets, each stretched from its chord to its arc.
        stretch = [width / (2 * np.sin(width / 2)) if width > 1e-9 else 1.0 for width in widths]
        covered = (mesh.areas[facets] * stretch).sum() / ((end - begin) * radius * np.ptp(along))
        if covered < COVERED:
            continue
        middles = np.array([mesh.points[facet].mean(axis=0) for facet in facets]) - origin
        hollow = _is_hollow(mesh, facets, middles - np.outer(middles @ axis, axis))
        ends = float(along.min()), float(along.max())
        parts = _turned(_parts(begin, end), u, v)
        curves += [Curve(origin, axis, radius, hollow=hollow, part=part, ends=ends) for part in parts]
        mesh.taken[facets] = True
    return curves


def _rings(flat: list[np.ndarray], facets: Iterable[int], tolerance: float) -> np.ndarray:
    """The different points (n, 2) of some facets' vertices in the plane through the axis."""
    points = np.concatenate([flat[facet] for facet in facets])
    return np.unique(np.round(points / (4 * LOOSE * tolerance)), axis=0)


def find_tori(mesh: _Mesh, axis: np.ndarray, origin: np.ndarray) -> list[Curve]:
    """The tori, and spheres, about an axis through a point; their facets are marked as taken."""
    u, v = _across(axis)

    def meridian(points: np.ndarray) -> np.ndarray:
        """(Distance from the axis, height) of points."""
        away = points - origin
        return np.column_stack([np.hypot(away @ u, away @ v), away @ axis])

    flat = [meridian(points) for points in mesh.points]
    curves = []
    for first, second in mesh.seams:
        if mesh.taken[[first, second]].any():
            continue
        pair = sorted((first, second))
        middle, minor = _circle(np.concatenate([flat[facet] for facet in pair]))

        def on_tube(facet: int, slack: float, middle: np.ndarray = middle, minor: float = minor) -> bool:
            off = np.linalg.norm(flat[facet] - middle, axis=1) - minor
            # A floor ends where a fillet begins, on one ring of it.
            across = np.ptp(flat[facet], axis=0).max() > LOOSE * mesh.tolerance
            return bool(across and np.abs(off).max() <= slack * mesh.tolerance)

        # Two facets of one step around are on a line of this plane, through which there is no circle.
        if len(_rings(flat, pair, mesh.tolerance)) < 3 or not all(on_tube(facet, LOOSE) for facet in pair):
            continue
        facets = mesh.grown(pair, lambda facet: on_tube(facet, LOOSE))
        middle, minor = _circle(np.concatenate([flat[facet] for facet in facets]))
        steps = len(_rings(flat, facets, mesh.tolerance)) - 1
        if steps < FEWEST_STEPS or not all(on_tube(facet, 1.0, middle, minor) for facet in facets):
            continue
        if middle[0] < mesh.tolerance * LOOSE:
            middle[0] = 0.0
        low, high = _span([np.arctan2(*(flat[facet] - middle).T[::-1]) for facet in facets])
        if high - low > np.pi + 1e-6:
            continue
        angles = []
        for facet in facets:
            points = mesh.points[facet] - origin
            off_axis = flat[facet][:, 0] > LOOSE * mesh.tolerance
            angles.append(np.arctan2(points[off_axis] @ v, points[off_axis] @ u))
        begin, end = _span(angles)
        # Area of a torus's part: turn times the integral of the distance from the axis over the arc (Pappus).
        whole = (end - begin) * minor * (middle[0] * (high - low) + minor * (np.sin(high) - np.sin(low)))
        if mesh.areas[facets].sum() < COVERED * whole * (1 - LARGEST_TURN**2 / 6):
            continue
        middles = np.array([flat[facet].mean(axis=0) - middle for facet in facets])
        out = np.array([mesh.points[facet].mean(axis=0) - origin for facet in facets])
        out -= np.outer(out @ axis, axis)
        out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), mesh.tolerance)
        hollow = _is_hollow(mesh, facets, middles[:, :1] * out + middles[:, 1:] * axis)
        arc = ((np.cos(low), np.sin(low)), (np.cos(high), np.sin(high)))
        centre = origin + middle[1] * axis
        for part in _turned(_parts(begin, end), u, v):
            curves.append(Curve(centre, axis, float(middle[0]), float(minor), hollow, part, arc))
        mesh.taken[facets] = True
    return curves


def find_curves(vessel: Vessel) -> list[Curve]:
    """The cylinders of a vessel of flat facets, and the tori and spheres about their axes."""
    mesh = _Mesh(vessel)
    curves = find_cylinders(mesh)
    axes: list[tuple[np.ndarray, np.ndarray]] = []
    for curve in curves:
        known = any(
            np.linalg.norm(np.cross(axis, curve.axis)) < 1e-4
            and np.linalg.norm(np.cross(curve.origin - origin, axis)) < LOOSE * mesh.tolerance
            for axis, origin in axes
        )
        if not known:
            axes.append((curve.axis, curve.origin))
    for axis, origin in axes:
        curves += find_tori(mesh, axis, origin)
    return curves
