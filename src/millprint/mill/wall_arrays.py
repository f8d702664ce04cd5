"""The walls of a vessel as flat arrays, and a grid of cells that finds what is near a ball."""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from millprint.mill.curved_surfaces import curve_rows
from millprint.mill.patches import find_patches, outline_slack
from millprint.mill.vectors import add_scaled, row
from millprint.mill.vessel import Vessel, ahead
from millprint.mill.walls import SURFACE, Walls, closeness_of
from millprint.run.kernel import array_maker, inlined, inner

# The most cells of the grids, of 8 bytes each: where they would be more, as in a vessel of 20 L with balls of 5 mm,
# they are wider. They only find what may be near a ball, so that a run does not depend on their size.
CELLS_MAX = 1 << 24


def facet_sides(vessel: Vessel) -> tuple[np.ndarray, np.ndarray]:
    """Number of sides of each facet (f,), and the sides (s, 7) in the facets' own axes (see `Walls.side`)."""
    counts, sides = [], []
    for facet in vessel.facets:
        axes = np.array(facet.axes).T
        for loop in facet.loops:
            flat = loop @ axes
            ends = ahead(flat)
            length = np.linalg.norm(ends - flat, axis=1)[:, None]
            sides.append(np.hstack([flat, (ends - flat) / length, length, ends]))
        counts.append(sum(map(len, facet.loops)))
    return np.array(counts), np.concatenate(sides)


def _edge_rows(vessel: Vessel) -> np.ndarray:
    rows = np.zeros((len(vessel.convex_edges), 5, 3))
    for row_of, edge in zip(rows, vessel.convex_edges, strict=True):
        length = np.linalg.norm(edge.end - edge.start)
        row_of[:] = edge.start, (edge.end - edge.start) / length, *edge.inward, (length, 0, 0)
    return rows


def _grids(bodies: Sequence[Vessel], reach_out: float, pitch: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origin (b, 3) and shape (b, 3) of every body's grid, and the number of its first cell (b + 1,).

    A ball's centre is inside the vessel; it can touch an insert from outside the insert's box.
    """
    origins, shapes = [], []
    for number, body in enumerate(bodies):
        low, high = body.bounds
        if number:
            low, high = low - reach_out, high + reach_out
        origins.append(low)
        shapes.append(np.ceil((high - low) / pitch).astype(np.int64))
    return np.array(origins), np.array(shapes), np.cumsum([0, *(int(shape.prod()) for shape in shapes)])


def _body_numbers(bodies: Sequence[Vessel]) -> np.ndarray:
    """The body of every feature: all facets, then all convex edges, all corners, and all curves."""
    kinds = ("facets", "convex_edges", "corners", "curves")
    groups = [[len(getattr(body, kind)) for body in bodies] for kind in kinds]
    return np.concatenate([np.repeat(np.arange(len(bodies)), counts) for counts in groups])


def _surfaces(bodies: Sequence[Vessel]) -> np.ndarray:
    """The surface of every feature: only facets can be smooth."""
    surface = np.full(len(_body_numbers(bodies)), SURFACE.rough)
    smooth = np.concatenate([body.is_smooth for body in bodies])
    surface[: len(smooth)][smooth] = SURFACE.smooth
    return surface


def _patches(bodies: Sequence[Vessel]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Walls.patch, is_drawing, first_vertex and vertex: those of each body, numbered one body after the other."""
    patches: list[list[np.ndarray]] = [[], [], [], []]
    drawings: list[list[np.ndarray]] = [[], [], [], []]
    vertices: list[list[np.ndarray]] = [[], [], [], []]
    first_patch, first_vertex = 0, 0
    for body in bodies:
        found = find_patches(body)
        for kind in range(4):
            patches[kind].append(found.patch[kind] + first_patch)
            drawings[kind].append(found.is_drawing[kind])
            vertices[kind] += [numbers + first_vertex for numbers in found.vertices[kind]]
        first_patch += found.patches
        first_vertex += len(body.vertices)
    rows = [numbers for kind in vertices for numbers in kind]
    patch, is_drawing = (np.concatenate([each for kind in kinds for each in kind]) for kinds in (patches, drawings))
    return patch, is_drawing.astype(np.uint8), np.cumsum([0, *map(len, rows)]), np.concatenate(rows)


def _boxes(bodies: Sequence[Vessel]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners (features, 3) of boxes that hold every feature [m]: of a curve, that of its body."""
    outlines = [np.concatenate(facet.loops) for body in bodies for facet in body.facets]
    outlines += [np.array([edge.start, edge.end]) for body in bodies for edge in body.convex_edges]
    outlines += [np.array([corner.point]) for body in bodies for corner in body.corners]
    outlines += [body.bounds for body in bodies for _ in body.curves]
    return np.array([each.min(axis=0) for each in outlines]), np.array([each.max(axis=0) for each in outlines])


def build_walls(bodies: Sequence[Vessel], radius: float, margin: float, pitch: float) -> Walls:
    """Flat arrays of bodies, the vessel first, for balls of at most `radius`, and grids that find what is near a ball.

    margin: how far a ball may move before the lists are rebuilt [m]; pitch: size of the grids' cells [m], if these are
    not more than CELLS_MAX.

    Nothing writes into the arrays, so simulations of a job in the same bodies share them.
    """
    boxes = sum(float(np.prod(np.ptp(body.bounds, axis=0))) for body in bodies)
    return _build_walls(tuple(bodies), radius, margin, max(pitch, math.cbrt(boxes / CELLS_MAX)))


@lru_cache(maxsize=2)
def _build_walls(bodies: tuple[Vessel, ...], radius: float, margin: float, pitch: float) -> Walls:
    counts, sides = zip(*(facet_sides(body) for body in bodies), strict=True)
    side, first_side = np.concatenate(sides), np.cumsum([0, *np.concatenate(counts)])
    facets = [facet for body in bodies for facet in body.facets]
    corners = [corner for body in bodies for corner in body.corners]
    origin, shape, grid_first = _grids(bodies, radius + margin, pitch)
    patch, is_drawing, first_vertex, vertex = _patches(bodies)
    walls = Walls(
        plane=np.array([[*facet.normal, facet.offset] for facet in facets]),
        axes=np.array([facet.axes for facet in facets]),
        first_side=first_side,
        side=side,
        slack=np.concatenate([outline_slack(body) for body in bodies]),
        edge=np.concatenate([_edge_rows(body) for body in bodies]),
        corner=np.array([corner.point for corner in corners]).reshape(-1, 3),
        first_direction=np.cumsum([0, *(len(corner.directions) for corner in corners)]),
        direction=np.concatenate([np.empty((0, 3)), *(corner.directions for corner in corners)]),
        body=_body_numbers(bodies),
        surface=_surfaces(bodies),
        curves=np.concatenate([curve_rows(body.curves) for body in bodies]),
        is_drawing=is_drawing,
        patch=patch,
        first_vertex=first_vertex,
        vertex=vertex,
        grid_origin=origin,
        grid_shape=shape,
        grid_pitch=float(pitch),
        grid_first=grid_first[:-1],
        cell_first=np.zeros(grid_first[-1] + 1, dtype=np.int64),
        cell_feature=np.empty(0, dtype=np.int64),
        cell_sure=np.empty(0, dtype=np.uint8),
    )
    # Nothing of a cell is farther from its middle than half its diagonal.
    reach = margin + pitch * math.sqrt(3) / 2
    low, high = _boxes(bodies)
    around = (1 + 1e-9) * (radius + 2 * reach) + walls.slack.max()
    features, sure = fill_cells(walls, radius, reach, low - around, high + around)
    return walls._replace(cell_feature=features, cell_sure=sure)


@inlined()
def cells_between(walls, body, axis, low, high):
    """First and last plus one of a grid's cells, along an axis, whose middles lie between two numbers [m]."""
    origin, cells = walls.grid_origin[body, axis], walls.grid_shape[body, axis]
    first = math.floor((low - origin) / walls.grid_pitch - 0.5)
    last = math.ceil((high - origin) / walls.grid_pitch - 0.5)
    return int(min(max(first, 0.0), cells)), int(min(max(last + 1, 0.0), cells))


@inner()
def visit_cells(walls, radius, margin, low, high, feature, features, sure):
    """Count a feature in the cells near it or, where there is room in `features`, write it there from the back."""
    body = walls.body[feature]
    shape = row(walls.grid_shape, body)
    x_from, x_to = cells_between(walls, body, 0, low[feature, 0], high[feature, 0])
    y_from, y_to = cells_between(walls, body, 1, low[feature, 1], high[feature, 1])
    z_from, z_to = cells_between(walls, body, 2, low[feature, 2], high[feature, 2])
    for x in range(x_from, x_to):
        for y in range(y_from, y_to):
            for z in range(z_from, z_to):
                middle = add_scaled(row(walls.grid_origin, body), walls.grid_pitch, (x + 0.5, y + 0.5, z + 0.5))
                closeness = closeness_of(walls, feature, middle, radius, margin)
                if closeness == 0:
                    continue
                cell = walls.grid_first[body] + (x * shape[1] + y) * shape[2] + z
                if features.size == 0:
                    walls.cell_first[cell] += 1
                else:
                    walls.cell_first[cell] -= 1
                    features[walls.cell_first[cell]] = feature
                    sure[walls.cell_first[cell]] = closeness - 1


@array_maker()
def fill_cells(walls, radius, margin, low, high):
    """List for every cell the features near its middle; fills walls.cell_first; returns features and sureness.

    low, high: corners (features, 3) of boxes outside of which nothing is near a feature [m].
    """
    walls.cell_first[:] = 0
    features, sure = np.empty(0, dtype=np.int64), np.empty(0, dtype=np.uint8)
    for feature in range(walls.body.size):
        visit_cells(walls, radius, margin, low, high, feature, features, sure)
    # Counts become ends; filling from the back turns ends into beginnings.
    for cell in range(1, walls.cell_first.size):
        walls.cell_first[cell] += walls.cell_first[cell - 1]
    count = walls.cell_first[-1]
    features, sure = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.uint8)
    for feature in range(walls.body.size - 1, -1, -1):
        visit_cells(walls, radius, margin, low, high, feature, features, sure)
    return features, sure
