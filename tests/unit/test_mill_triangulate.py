"""Outlines of any shape, with holes, cut into triangles that keep every side and fill the area."""

import numpy as np
import pytest

from millprint.config.errors import ConfigError
from millprint.mill.outlines import facets_of, triangulate_facet, triangulate_polygon


def ring(radius: float, count: int, centre=(0.0, 0.0), inner: float | None = None) -> np.ndarray:
    """A regular outline; with `inner` a star whose points reach in to that radius."""
    angle = 2 * np.pi * np.arange(count) / count
    reach = np.where(np.arange(count) % 2, inner or radius, radius)
    return np.column_stack([np.cos(angle), np.sin(angle)]) * reach[:, None] + centre


def area(loop: np.ndarray) -> float:
    x, y = loop.T
    return float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2)


COMB = np.array([[0, 0], [9, 0], [9, 5], [8, 5], [8, 1], [6, 1], [6, 5], [5, 5], [5, 1], [1, 1], [1, 5], [0, 5]], float)
OUTLINES = {
    "comb": [COMB],
    "star": [ring(10, 40, inner=2)],
    "thin slot": [ring(10, 24), np.array([[-9, -0.01], [-9, 0.01], [9, 0.01], [9, -0.01]])],
    "star in a star": [ring(10, 30, inner=6), ring(5, 26, inner=3)[::-1]],
    "three holes": [ring(10, 8), *(ring(2, n, (4 * k - 4, k))[::-1] for k, n in enumerate((3, 12, 5)))],
    "vertices on straight sides": [np.array([[0, 0], [1, 0], [2, 0], [5, 0], [5, 1], [5, 3], [0, 3], [0, 2.9]], float)],
    "a hole behind a hole": [ring(10, 6), ring(3, 30)[::-1], ring(1, 5, (0, 5.5))[::-1], ring(0.5, 4, (0, 7.5))[::-1]],
}


@pytest.mark.parametrize("name", OUTLINES)
@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_triangles_fill_an_outline_and_keep_its_sides(name, turn):
    matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    loops = [loop @ matrix for loop in OUTLINES[name]]
    points, triangles = np.concatenate(loops), triangulate_polygon(loops, sum(map(area, loops)))
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (twice > 0).all()
    assert twice.sum() / 2 == pytest.approx(sum(map(area, loops)))
    assert len(triangles) == len(points) + 2 * (len(loops) - 1) - 2
    sides = {tuple(pair) for row in triangles.tolist() for pair in zip(row, row[1:] + row[:1], strict=True)}
    begin = 0
    for loop in loops:
        for k in range(len(loop)):
            assert (begin + k, begin + (k + 1) % len(loop)) in sides
        begin += len(loop)


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(20))
def test_every_vertex_in_the_middle_of_a_side_is_kept(seed, turn):
    """A facet has such vertices where two others meet at its side: without them the mesh would not close."""
    matrix = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    rng = np.random.default_rng(seed)
    corners = ring(10, 7, inner=6) + rng.uniform(-1, 1, (7, 2))
    hole = ring(2, 4)[::-1]
    loops = [
        np.concatenate(
            [np.linspace(a, b, rng.integers(1, 5), endpoint=False) for a, b in zip(loop, after, strict=True)]
        )
        @ matrix
        for loop, after in ((corners, np.roll(corners, -1, axis=0)), (hole, np.roll(hole, -1, axis=0)))
    ]
    triangles = triangulate_polygon(loops, sum(map(area, loops)))
    assert triangles is not None
    points = np.concatenate(loops)
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    assert (twice > 1e-9).all() and twice.sum() / 2 == pytest.approx(sum(map(area, loops)))
    assert len(triangles) == len(points) and set(triangles.flat) == set(range(len(points)))


@pytest.mark.parametrize("count", [5, 7])
def test_an_outline_that_crosses_itself_is_refused(count):
    """A pentagram, and one of seven points."""
    flat = ring(10, count)[np.arange(count) * 2 % count]
    (facet,) = facets_of([[np.column_stack([flat, np.zeros(count)])]])
    with pytest.raises(ConfigError, match="cannot be cut into triangles"):
        triangulate_facet(facet)
