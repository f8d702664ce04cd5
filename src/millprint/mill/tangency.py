"""Makes recognised surfaces tangent to each other where they are so within the rounding of their file.

A ball that rolls from a floor over a fillet to a mantle must find no step there. In the half plane about an axis all
three are lines and arcs; so are the planes and cylinders of a prism in the plane across it. Lines and arcs that nearly
touch are moved together by the least change of their sizes (Newton's method for c(x) = 0 with steps of least length,
x - J^T (J J^T)^-1 c), and stay as they were where that would move a surface off its vertices.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from millprint.mill.turned_shapes import LOOSE, Axis, Circle, Drawing, Line, Swept

# Newton's steps; each squares the error.
STEPS = 8
# Of more gaps than this, more than one is given up at a time.
FEW = 8


@dataclass
class _Group:
    """Lines and arcs of one plane; free: which of their numbers may change."""

    shapes: list[Line | Circle] = field(default_factory=list)
    free: list[tuple[str, ...]] = field(default_factory=list)
    points: list[np.ndarray] = field(default_factory=list)

    def add(self, shape: Line | Circle, free: tuple[str, ...], points: np.ndarray) -> int:
        """Take a shape and the points (n, 2) that it has to stay near; returns its number."""
        self.shapes.append(shape)
        self.free.append(free)
        self.points.append(points)
        return len(self.shapes) - 1

    def off(self, own: list[int]) -> np.ndarray:
        """How far some shapes are from their points at most [m]."""
        return np.array([np.abs(self.shapes[k].off(self.points[k])).max() for k in own])


class _Gap(NamedTuple):
    """How far two shapes are from being tangent: their numbers, and the distance [m] as they are now."""

    between: tuple[int, int]
    width: Callable[[], float]


def _width(first: Line | Circle, second: Line | Circle) -> Callable[[], float] | None:
    """How far a line and an arc, or two arcs, are from being tangent [m]; None for two lines."""
    if isinstance(first, Line) and isinstance(second, Line):
        return None
    if isinstance(first, Circle) and isinstance(second, Circle):
        apart = math.hypot(first.r - second.r, first.z - second.z)
        outside = abs(apart - first.radius - second.radius) < abs(apart - abs(first.radius - second.radius))
        sign = 1.0 if outside else -1.0
        larger, smaller = (first, second) if first.radius >= second.radius else (second, first)
        return lambda: math.hypot(first.r - second.r, first.z - second.z) - (larger.radius + sign * smaller.radius)
    line, circle = (first, second) if isinstance(first, Line) else (second, first)
    assert isinstance(line, Line) and isinstance(circle, Circle)
    side = math.copysign(1.0, float(line.off(np.array([[circle.r, circle.z]]))[0]))
    return lambda: side * float(line.off(np.array([[circle.r, circle.z]]))[0]) - circle.radius


def _close(group: _Group, gaps: list[_Gap], snap: float) -> set[tuple[int, str]]:
    """Let as many gaps as possible vanish; returns the numbers (shape, name) that were changed."""
    count, pairs = len(group.shapes), np.array([gap.between for gap in gaps], dtype=np.int64).reshape(-1, 2)
    _, part = connected_components(coo_array((np.ones(len(pairs)), pairs.T), (count, count)), directed=False)
    changed: set[tuple[int, str]] = set()
    for each in np.unique(part[pairs]).tolist():
        changed |= _close_part(
            group, np.flatnonzero(part == each).tolist(), [g for g in gaps if part[g.between[0]] == each], snap
        )
    return changed


def _close_part(group: _Group, own: list[int], gaps: list[_Gap], snap: float) -> set[tuple[int, str]]:
    """`_close` of shapes that hang together by gaps."""
    numbers = [(k, name) for k in own for name in group.free[k]]
    size = max(float(np.abs(points).max()) for points in group.points)
    scale = np.array([1.0 if name == "angle" else size for _, name in numbers])
    begin = np.array([getattr(group.shapes[k], name) for k, name in numbers]) / scale
    allowed = np.maximum(snap, 2 * group.off(own))
    gaps = sorted(gaps, key=lambda gap: abs(gap.width()))

    def put(number: int, value: float) -> None:
        k, name = numbers[number]
        setattr(group.shapes[k], name, float(value * scale[number]))

    def widths(values: np.ndarray) -> np.ndarray:
        for number, value in enumerate(values):
            put(number, value)
        return np.array([gap.width() for gap in gaps]) / size

    def slopes(values: np.ndarray) -> np.ndarray:
        """The changes (gaps, numbers) of the widths, each by the numbers of its own two shapes."""
        found, step = np.zeros((len(gaps), len(numbers))), 1e-6
        for number, (k, _) in enumerate(numbers):
            rows = [row for row, gap in enumerate(gaps) if k in gap.between]
            for sense in (1.0, -1.0):
                put(number, values[number] + sense * step)
                found[rows, number] += sense * np.array([gaps[row].width() for row in rows])
            put(number, values[number])
        return found / (2 * step * size)

    while gaps and numbers:
        values = begin
        for _ in range(STEPS):
            now = widths(values)
            values = values - np.linalg.pinv(slopes(values), rcond=1e-9) @ now
        left = np.abs(widths(values)).max()
        if left < 1e-13 and (group.off(own) <= allowed).all():
            return {(id(group.shapes[k]), name) for k, name in numbers}
        widths(begin)
        # The largest, and several of very many.
        gaps = gaps[: len(gaps) - max(1, len(gaps) // FEW)]
    return set()


def _touching(drawing: Drawing, of_facet: np.ndarray) -> set[tuple[int, int]]:
    """Pairs of numbers of shapes (f,; -1 for none) that meet in an edge."""
    pairs = of_facet[drawing.vessel.edge_arrays.facets]
    pairs = np.sort(pairs[(pairs >= 0).all(axis=1) & (pairs[:, 0] != pairs[:, 1])], axis=1)
    return set(map(tuple, pairs.tolist()))


def _across(drawing: Drawing, surfaces: list[Swept], planes: dict[int, np.ndarray]) -> set[int]:
    """Make the cylinders along one direction and the flat walls along it tangent; returns the cylinders that moved."""
    cylinders = [each for each in surfaces if isinstance(each.shape, Line) and each.shape.angle == 0.0]
    moved: set[int] = set()
    while cylinders:
        along = cylinders[0].axis.along
        own = [each for each in cylinders if np.linalg.norm(np.cross(each.axis.along, along)) < 1e-9]
        cylinders = [each for each in cylinders if each not in own]
        frame = Axis(np.zeros(3), along)
        sides = np.array([frame.u, frame.v])
        group, of_facet = _Group(), np.full(len(drawing.normals), -1)
        for each in own:
            middle = sides @ each.axis.origin
            circle = Circle(float(middle[0]), float(middle[1]), each.shape.offset)  # type: ignore[union-attr]
            number = group.add(circle, ("r", "z", "radius"), drawing.points(each.facets) @ sides.T)
            of_facet[each.facets] = number
        beside = np.flatnonzero(of_facet >= 0)
        walls = _flat_beside(drawing, beside, partial(_is_across, along))
        for facet in walls:
            points = drawing.points([facet]) @ sides.T
            plane = planes.get(facet)
            normal = drawing.normals[facet] if plane is None else plane[:3]
            flat = sides @ normal
            offset = float((points @ flat).mean()) / float(np.linalg.norm(flat))
            line = Line(math.atan2(flat[1], flat[0]), offset)
            of_facet[facet] = group.add(line, ("angle", "offset") if plane is None else (), points)
        changed = _close_touching(drawing, group, of_facet)
        for number, each in enumerate(own):
            found = group.shapes[number]
            if (id(found), "radius") in changed:
                assert isinstance(found, Circle) and isinstance(each.shape, Line)
                height = float(each.axis.origin @ along)
                each.axis.origin = found.r * frame.u + found.z * frame.v + height * along
                each.shape.offset = found.radius
                moved.add(id(each))
        for facet in walls:
            line = group.shapes[of_facet[facet]]
            if (id(line), "offset") in changed:
                assert isinstance(line, Line)
                normal = math.cos(line.angle) * frame.u + math.sin(line.angle) * frame.v
                planes[facet] = np.array([*normal, line.offset])
    return moved


def _is_across(along: np.ndarray, normal: np.ndarray) -> bool:
    return bool(abs(normal @ along) < 1e-3)


def _flat_beside(drawing: Drawing, facets: np.ndarray, holds: Callable[[np.ndarray], bool]) -> list[int]:
    """The flat facets next to some facets whose normals hold."""
    is_inside = np.zeros(len(drawing.taken), dtype=bool)
    is_inside[facets] = True
    others = drawing.across(is_inside)
    return [other for other in others[~drawing.taken[others]].tolist() if holds(drawing.normals[other])]


def _close_touching(drawing: Drawing, group: _Group, of_facet: np.ndarray) -> set[tuple[int, str]]:
    gaps = []
    for pair in sorted(_touching(drawing, of_facet)):
        width = _width(*(group.shapes[k] for k in pair))
        if width is not None and abs(width()) < LOOSE * drawing.tolerance:
            gaps.append(_Gap(pair, width))
    return _close(group, gaps, drawing.snap)


def _about_axis(drawing: Drawing, own: list[Swept], planes: dict[int, np.ndarray], fixed: set[int]) -> None:
    """Make the surfaces about one axis, and the flat walls across it, tangent."""
    axis = own[0].axis
    group, of_facet = _Group(), np.full(len(drawing.normals), -1)
    for each in own:
        free: tuple[str, ...]
        if isinstance(each.shape, Line):
            free = () if id(each) in fixed else ("offset",) if each.shape.angle == 0.0 else ("angle", "offset")
        else:
            free = ("z", "radius") if each.shape.r == 0.0 else ("r", "z", "radius")
        of_facet[each.facets] = group.add(each.shape, free, axis.meridian(drawing.points(each.facets)))
    walls = _flat_beside(
        drawing, np.flatnonzero(of_facet >= 0), lambda normal: bool(np.linalg.norm(np.cross(normal, axis.along)) < 1e-3)
    )
    for facet in walls:
        points = axis.meridian(drawing.points([facet]))
        line = Line(math.pi / 2, float(points[:, 1].mean()))
        of_facet[facet] = group.add(line, () if facet in planes else ("offset",), points)
    changed = _close_touching(drawing, group, of_facet)
    for facet in walls:
        line = group.shapes[of_facet[facet]]
        if (id(line), "offset") in changed:
            assert isinstance(line, Line)
            normal = axis.along * np.sign(drawing.normals[facet] @ axis.along)
            planes[facet] = np.array([*normal, float(normal @ (axis.origin + line.offset * axis.along))])


def make_tangent(drawing: Drawing, surfaces: list[Swept]) -> dict[int, np.ndarray]:
    """Change surfaces in place; returns the planes (normal, offset) [m] of the flat facets that were changed too."""
    planes: dict[int, np.ndarray] = {}
    for each in surfaces:
        if isinstance(each.shape, Line):
            radii = each.axis.meridian(drawing.points(each.facets))[:, 0]
            if np.ptp(radii) < 2 * drawing.tolerance and abs(each.shape.angle) < 0.1:
                each.shape.angle, each.shape.offset = 0.0, float(radii.mean())
    fixed = _across(drawing, surfaces, planes)
    by_axis: dict[int, list[Swept]] = {}
    for each in surfaces:
        by_axis.setdefault(id(each.axis), []).append(each)
    for own in by_axis.values():
        _about_axis(drawing, own, planes, fixed)
    return planes
