"""Any outline with holes cut into triangles by clipping ears, every vertex kept."""

import numpy as np


def _turn(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Twice the area of triangles a, b, c (..., 2), positive counter-clockwise."""
    return (b[..., 0] - a[..., 0]) * (c[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (c[..., 0] - a[..., 0])


def _is_seen(points: np.ndarray, ring: list[int], a: int, b: int) -> bool:
    """Whether the straight line between two vertices meets no side of a ring that does not end in one of them."""
    start, end = points[ring], points[np.roll(ring, -1)]
    ends = np.stack([ring, np.roll(ring, -1)], axis=1)
    apart = ~np.isin(ends, [a, b]).any(axis=1)
    p, q = points[a], points[b]
    crosses = (_turn(p, q, start) * _turn(p, q, end) <= 0) & (_turn(start, end, p) * _turn(start, end, q) <= 0)
    return not (crosses & apart).any()


def _bridge(points: np.ndarray, outer: list[int], hole: list[int], others: list[list[int]]) -> list[int] | None:
    """The outline with a hole joined to it by the shortest line that crosses nothing; None if there is none."""
    length = np.linalg.norm(points[outer][:, None] - points[hole], axis=2)
    for flat in np.argsort(length, axis=None, kind="stable"):
        i, j = divmod(int(flat), len(hole))
        if _fits(points, outer, i, hole[j]) and all(
            _is_seen(points, ring, outer[i], hole[j]) for ring in (outer, hole, *others)
        ):
            return [*outer[: i + 1], *hole[j:], *hole[: j + 1], *outer[i:]]
    return None


def _fits(points: np.ndarray, ring: list[int], i: int, target: int) -> bool:
    """Whether the way from ring vertex i to a point starts out into the interior, on the left of the ring."""
    before, here, after, there = (points[k] for k in (ring[i - 1], ring[i], ring[(i + 1) % len(ring)], target))
    left_of_both = _turn(before, here, there) > 0, _turn(here, after, there) > 0
    return all(left_of_both) if _turn(before, here, after) >= 0 else any(left_of_both)


def _ear_quality(points: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """Twice the area over the longest side squared of the triangle at each vertex; -1 where it is no ear."""
    a, b, c = points[np.roll(ring, 1)], points[ring], points[np.roll(ring, -1)]
    twice = _turn(a, b, c)
    longest = np.max([((u - v) ** 2).sum(axis=1) for u, v in ((a, b), (b, c), (c, a))], axis=0)
    quality = np.where(twice > 1e-12 * longest, twice / longest, -1.0)
    for k in np.flatnonzero(quality > 0):
        other = points[ring]
        within = (_turn(a[k], b[k], other) >= 0) & (_turn(b[k], c[k], other) >= 0) & (_turn(c[k], a[k], other) >= 0)
        # A bridge passes its vertices twice; the same place again does not bar an ear.
        at_corner = (other[:, None] == np.array([a[k], b[k], c[k]])).all(axis=2).any(axis=1)
        if (within & ~at_corner).any():
            quality[k] = -1.0
    return quality


def clip_ears(loops: list[np.ndarray]) -> np.ndarray | None:
    """Triangles (t, 3) as rows of the loops' vertices one after the other, counter-clockwise.

    loops: (k, 2) each, the outer one counter-clockwise first, then holes clockwise. At each step the ear nearest to
    equal sides goes, of those that hold no other vertex. None where an outline that crosses itself leaves no ear.
    """
    points = np.concatenate(loops)
    first = np.cumsum([0, *(len(loop) for loop in loops)])
    ring, *holes = [list(range(first[k], first[k + 1])) for k in range(len(loops))]
    while holes:
        # The nearest hole first, so that a bridge seldom has to pass another.
        gaps = [np.linalg.norm(points[ring][:, None] - points[hole], axis=2).min() for hole in holes]
        hole = holes.pop(int(np.argmin(gaps)))
        joined = _bridge(points, ring, hole, holes)
        if joined is None:
            return None
        ring = joined
    triangles = []
    while len(ring) > 3:
        quality = _ear_quality(points, np.array(ring))
        best = int(np.argmax(quality))
        if quality[best] <= 0:
            return None
        triangles.append([ring[best - 1], ring[best], ring[(best + 1) % len(ring)]])
        del ring[best]
    return np.array([*triangles, ring])
