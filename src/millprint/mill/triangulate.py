"""Plane outlines with holes cut into triangles, for meshes, pictures and STL files."""

import itertools

import numpy as np

# A smaller turn is not a corner [rad]: a fan would have triangles of no area there.
STRAIGHT = 1e-6


def _inside(points: np.ndarray, loops: list[np.ndarray]) -> np.ndarray:
    """Even-odd rule: which points (n, 2) lie inside the outlines (k, 2)."""
    inside = np.zeros(len(points), dtype=bool)
    for loop in loops:
        for (u0, v0), (u1, v1) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            crosses = (v0 > points[:, 1]) != (v1 > points[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                at = u0 + (points[:, 1] - v0) / (v1 - v0) * (u1 - u0)
            inside ^= crosses & (points[:, 0] < at)
    return inside


def _cover(points: np.ndarray, triangles: np.ndarray, loops: list[np.ndarray], area: float) -> bool:
    """Whether triangles (t, 3) fill the outlines, with every side of them: then they fit to the neighbours'."""
    if abs(np.abs(_twice(points, triangles)).sum() / 2 - area) > 1e-9 * area:
        return False
    sides = {frozenset(pair) for row in triangles.tolist() for pair in zip(row, row[1:] + row[:1], strict=True)}
    return all(
        frozenset((first + k, first + (k + 1) % len(loop))) in sides
        for first, loop in zip(_first_rows(loops), loops, strict=True)
        for k in range(len(loop))
    )


def _first_rows(loops: list[np.ndarray]) -> list[int]:
    """The row of each loop's first vertex among the vertices of all loops."""
    return [0, *itertools.accumulate(len(loop) for loop in loops[:-1])]


def _twice(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def _is_convex(loop: np.ndarray) -> bool:
    """Whether a counter-clockwise outline (k, 2) turns left at every vertex, and once around in all."""
    side = np.roll(loop, -1, axis=0) - loop
    after = np.roll(side, -1, axis=0)
    turn = np.arctan2(side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0], (side * after).sum(axis=1))
    return bool((turn > STRAIGHT).all() and abs(turn.sum() - 2 * np.pi) < 1e-6)


def _contour_triangles(points: np.ndarray, loops: list[np.ndarray]) -> np.ndarray:
    """Triangles (t, 3) of an outline with holes by VTK; fewer than fill it where the outline crosses itself."""
    # Slow to import, and few jars need them.
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    from vtkmodules.vtkFiltersGeneral import vtkContourTriangulator

    places, lines, outlines = vtkPoints(), vtkCellArray(), vtkPolyData()
    places.SetData(numpy_to_vtk(np.column_stack([points, np.zeros(len(points))]), deep=True))
    for first, loop in zip(_first_rows(loops), loops, strict=True):
        lines.InsertNextCell(len(loop) + 1)
        for k in range(len(loop) + 1):
            lines.InsertCellPoint(first + k % len(loop))
    outlines.SetPoints(places)
    outlines.SetLines(lines)
    triangulator = vtkContourTriangulator()
    triangulator.TriangulationErrorDisplayOff()
    triangulator.SetInputData(outlines)
    triangulator.Update()
    return vtk_to_numpy(triangulator.GetOutput().GetPolys().GetConnectivityArray()).reshape(-1, 3)


def triangulate_polygon(loops: list[np.ndarray], area: float) -> np.ndarray | None:
    """Triangles (t, 3) of an outline with holes, rows of the vertices of its loops in turn, counter-clockwise.

    loops: (k, 2) each, the outer one counter-clockwise first, then holes clockwise; area: what they enclose. Every side
    of a loop is the side of a triangle. A fan where the outline is convex, as that of most walls is; else Delaunay's
    triangles where they keep to the outlines, and VTK's where they do not. None for an outline that crosses itself.
    """
    if len(loops) == 1 and _is_convex(loops[0]):
        last = np.arange(2, len(loops[0]))
        return np.column_stack([np.zeros_like(last), last - 1, last])
    # Takes long to import, and few jars need it.
    from scipy.spatial import Delaunay

    points = np.concatenate(loops)
    triangles = Delaunay(points).simplices
    triangles = triangles[_inside(points[triangles].mean(axis=1), loops)]
    if not _cover(points, triangles, loops, area):
        triangles = _contour_triangles(points, loops)
        if not _cover(points, triangles, loops, area):
            return None
    return np.where((_twice(points, triangles) < 0)[:, None], triangles[:, ::-1], triangles)
