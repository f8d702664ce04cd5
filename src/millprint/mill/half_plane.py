"""The half plane about an axis: which facets of a drawing lie on a line or arc there, and are steps of it."""

import math
from collections.abc import Sequence

import numpy as np

from millprint.mill.outlines import Ragged, cross, lengths
from millprint.mill.turned_shapes import (
    LARGEST_TURN,
    LOOSE,
    Axis,
    Circle,
    Drawing,
    Line,
    Swept,
    circles_through,
)

# A step that is longer than most of its arc's, by this factor, may be one of the next arc, which ends on this one too.
EVEN = 1.25
# How far the middle of a facet is below its surface, over the radii, where it is drawn in steps of LARGEST_TURN.
SAG = 1.3 * (1 - math.cos(LARGEST_TURN / 2))
# To name a place of a lattice by one number.
PRIMES = 73856093, 19349663
# Directions that differ by less may be one, if the vertices allow it [rad].
NEARLY = 0.02


class HalfPlane:
    """Facets of a drawing, all or some, in the half plane about an axis.

    vertices: the numbers of their vertices; flat: these in the half plane; corners: the rows of `flat` at the facets'
    corners; middles, means and facing (f, 2): the facets' middles, the means of their vertices, which are near a small
    rounding that the middles are far below, and the facets' normals; is_ring (f,): whether all vertices are one.
    """

    def __init__(self, drawing: Drawing, axis: Axis, facets: np.ndarray | None = None) -> None:
        self.axis, self.facets, self.of_facet = axis, np.arange(len(drawing.taken)), drawing.corners
        self.vertices, self.corners = np.arange(len(drawing.vessel.vertices)), drawing.flat
        if facets is not None:
            self.facets, self.of_facet = facets, Ragged(drawing.corners.counts[facets])
            self.vertices, self.corners = np.unique(drawing.flat[drawing.corners.rows(facets)], return_inverse=True)
        points = drawing.middles[self.facets]
        self.flat, self.middles = axis.meridian(drawing.vessel.vertices[self.vertices]), axis.meridian(points)
        self.near = LOOSE * drawing.tolerance
        means = np.add.reduceat(self.flat[self.corners], self.of_facet.first) / self.of_facet.counts[:, None]
        self.means = means
        # The middle of a flat ring is on the axis, where no wall is, and that of a part of one is outside of it too.
        has_hole = drawing.vessel.outlines.facets.counts[self.facets] > 1
        self.middles[has_hole] = means[has_hole]
        # A narrow facet of a band has its vertices nearly in one place too, and its middle there.
        self.is_ring = np.maximum(*(self.largest(each) + self.largest(-each) for each in self.flat.T)) < self.near
        self.is_ring &= (1 - SAG) * means[:, 0] > self.middles[:, 0] + drawing.tolerance
        is_level = self.largest(self.flat[:, 1]) + self.largest(-self.flat[:, 1]) <= 4 * drawing.tolerance
        is_inner = (1 - SAG) * -self.largest(-self.flat[:, 0]) > self.middles[:, 0] + drawing.tolerance
        for k in np.flatnonzero(is_level & is_inner & ~self.is_ring & ~has_hole).tolist():
            has_hole[k] = drawing.has_middle_outside(int(self.facets[k]))
        self.middles[has_hole] = means[has_hole]
        outwards = points - axis.origin - np.outer(self.middles[:, 1], axis.along)
        outwards /= np.maximum(self.middles[:, :1], 1e-12)
        away = drawing.vessel.vertices[self.vertices] - axis.origin
        self.around = away @ axis.u + 1j * (away @ axis.v)
        self.directions = np.add.reduceat(self.around[self.corners], self.of_facet.first)
        normals = drawing.normals[self.facets]
        self.facing = np.column_stack([np.vecdot(normals, outwards), normals @ axis.along])

    def largest(self, values: np.ndarray) -> np.ndarray:
        """For each facet (f,) the largest of what its vertices (v,) have."""
        return np.maximum.reduceat(values[self.corners], self.of_facet.first)

    def points(self, rows: np.ndarray) -> np.ndarray:
        """The vertices (n, 2) of some rows of `facets`, each once."""
        return self.flat[np.unique(self.corners[self.of_facet.rows(rows)])]

    def on(self, drawing: Drawing, shape: Line | Circle, slack: float) -> np.ndarray:
        """Which facets (f,) lie on a line or arc, whose chords they are: their vertices to a slack, in tolerances."""
        # A floor has its outline, a ring, on the fillet that it joins.
        sag = self.middles[:, 0] + (shape.radius if isinstance(shape, Circle) else 0.0)
        is_near = self.largest(np.abs(shape.off(self.flat))) <= slack * drawing.tolerance
        return is_near & (np.abs(shape.off(self.middles)) <= SAG * sag + drawing.tolerance)

    def steps(self, arc: Circle, rows: np.ndarray) -> np.ndarray:
        """How far rows (n,) of `facets` reach along an arc [m]."""
        counts = self.of_facet.counts[rows]
        away = self.flat[self.corners[self.of_facet.rows(rows)]] - [arc.r, arc.z]
        (x, z), (r, up) = np.repeat(self.means[rows] - [arc.r, arc.z], counts, axis=0).T, away.T
        turn, first = np.arctan2(x * up - z * r, x * r + z * up), Ragged(counts).first
        return arc.radius * (np.maximum.reduceat(turn, first) - np.minimum.reduceat(turn, first))

    def is_even(self, drawing: Drawing, shape: Line | Circle, own: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Which other rows are not far longer steps of an arc than its own ones; any is of a line.

        Neither are those that are as near to the arc as rounding allows, which may be several steps together.
        """
        if isinstance(shape, Line):
            return np.ones(len(others), dtype=bool)
        longest = EVEN * np.median(self.steps(shape, own)) + 4 * drawing.tolerance
        return self.steps(shape, others) <= max(longest, 4 * math.sqrt(drawing.tolerance * shape.radius))

    def is_even_around(self, drawing: Drawing, shape: Line | Circle, rows: np.ndarray) -> np.ndarray:
        """Which rows (n,) of `facets` on a line or arc are steps around the axis that are not far wider than others.

        A wider one is a flat on a mantle, which ends where the mantle does: its vertices are on that too.
        """
        if not len(rows) or (isinstance(shape, Circle) and shape.r == 0.0):
            return np.ones(len(rows), dtype=bool)
        every = np.sort(self.steps_around(np.flatnonzero(~self.is_ring & self.on(drawing, shape, 1.0))))
        # A mesh without rings.
        if np.count_nonzero(every) < len(every) / 2:
            return np.ones(len(rows), dtype=bool)
        radius = max(self.near, float(self.means[rows, 0].max()))
        # Steps of the largest quarter differ by less from the next one, up to a flat.
        most = every[-(len(every) // 4) - 1 :]
        is_last = np.append(most[1:] > EVEN * most[:-1] + 4 * drawing.tolerance / radius, True)
        return self.steps_around(rows) <= max(most[is_last.argmax()], 4 * math.sqrt(drawing.tolerance / radius))

    def steps_around(self, rows: np.ndarray) -> np.ndarray:
        """How far apart vertices that follow each other in rows (n,) of `facets` are about the axis, at most [rad].

        Several steps that are one facet, as rounding allows, have vertices between its ends. 0 where there are not two
        vertices on each side, as of a triangle: it may be of a mesh without rings.
        """
        corners, counts = self.corners[self.of_facet.rows(rows)], self.of_facet.counts[rows]
        turn = np.angle(self.around[corners] / np.repeat(self.directions[rows], counts))
        # At the axis a vertex is in any direction.
        turn[self.flat[corners, 0] <= self.near] = 0.0
        parts = Ragged(counts)
        ways = np.diff(turn[np.lexsort((turn, parts.owner))], prepend=0.0)
        place = np.arange(len(ways)) - parts.first[parts.owner]
        ways[(place < 2) | (place > counts[parts.owner] - 2)] = 0.0
        return np.maximum.reduceat(ways, parts.first)

    def is_nearer(self, drawing: Drawing, first: Swept, second: Swept, rows: np.ndarray) -> np.ndarray:
        """Which rows that lie on both of two surfaces are steps like those of the first, and not of the second.

        Any of two that are not both arcs, or if rounding may hide it.
        """
        arc, other = first.shape, second.shape
        if isinstance(arc, Line) or isinstance(other, Line):
            return np.ones(len(rows), dtype=bool)
        steps = self.steps(arc, rows)
        off = np.abs(steps - np.median(self.steps(arc, first.facets)))
        other_off = np.abs(self.steps(other, rows) - np.median(self.steps(other, second.facets)))
        is_hidden = steps <= 4 * math.sqrt(drawing.tolerance * arc.radius)
        return is_hidden | (off <= other_off + 4 * drawing.tolerance)

    def caps(self, drawing: Drawing, sphere: Circle, own: np.ndarray) -> np.ndarray:
        """The free rows that are flat discs about the poles of a sphere, as wide as a step of its own rows.

        A wider or narrower one is a floor.
        """
        rows = np.flatnonzero(self.is_ring & ~drawing.taken[self.facets] & self.on(drawing, sphere, 1.0))
        turn = self.largest(np.arctan2(self.flat[:, 0], np.abs(self.flat[:, 1] - sphere.z)))[rows]
        widths = 2 * sphere.radius * turn
        return rows[np.abs(widths - np.median(self.steps(sphere, own))) <= 4 * drawing.tolerance]

    def fit(
        self, drawing: Drawing, seed: Sequence[int], kind: type[Line] | type[Circle]
    ) -> tuple[Line | Circle, np.ndarray] | None:
        """The line or arc through the vertices of two rows of `facets`, and all rows on it; None if these are not."""
        free = ~drawing.taken[self.facets] & ~self.is_ring

        def again(rows: np.ndarray, slack: float) -> tuple[Line | Circle, np.ndarray]:
            """The shape through some rows, and the rows on it; none where the seed is not."""
            own = self.points(rows)
            shape = kind.through(own)
            if isinstance(shape, Circle):
                # A few steps say little of where their middle is: a sphere wherever they may be of one.
                sphere = on_axis_circle(own)
                is_sphere = abs(shape.r) < self.near or np.abs(sphere.off(own)).max() <= drawing.tolerance
                shape = sphere if is_sphere else shape
            holds = free & self.on(drawing, shape, slack)
            facing = np.vecdot(self.facing, slopes(shape, self.means))
            holds &= facing * facing[seed[0]] > 0.5
            if not holds[list(seed)].any():
                return shape, np.empty(0, dtype=np.int64)
            rows = np.flatnonzero(holds)
            return shape, rows if slack == 1.0 else rows[self.is_even(drawing, shape, rows, rows)]

        # The first slack may take a wall that turns by little against this one, or ends on it, and spoil the fit.
        for slacks in ((LOOSE, 2.0, 1.0, 1.0), (1.0, 1.0, 1.0)):
            rows = np.asarray(seed)
            for slack in slacks:
                if len(rows):
                    shape, rows = again(rows, slack)
            # Some steps of a fine arc fit many circles: on as long as there are more.
            before = 0
            while len(rows) > before:
                best, before = (shape, rows), len(rows)
                _, wider = again(rows, 2.0)
                shape, rows = again(wider, 1.0) if len(wider) else (shape, wider)
            if before:
                shape, rows = best
                rows = rows[self.is_even_around(drawing, shape, rows)]
                return (shape, rows) if len(rows) else None
        return None

    def rings(self, drawing: Drawing) -> tuple[np.ndarray, np.ndarray]:
        """How many different places the vertices at each seam (s,) have; and a number for these.

        None where a facet is taken or does not face the axis, where all places are one, or where more than two are on
        no circle. Two where they are on a line that is longer than an arc may be that looks straight: a mantle with a
        port has vertices at many heights. Seams between the same rings have one number.
        """
        counts, names = np.zeros(len(drawing.seams), dtype=np.int64), np.zeros(len(drawing.seams), dtype=np.int64)
        apart = 4 * drawing.tolerance
        # A plane through points about an axis faces it from between them.
        points = drawing.middles - self.axis.origin
        around = cross(np.broadcast_to(self.axis.along, points.shape), points)
        around /= np.maximum(lengths(around), 1e-12)
        away = drawing.vessel.vertices[self.corners] - drawing.middles[drawing.corners.owner]
        aside = np.abs(np.vecdot(away, around[drawing.corners.owner]))
        width = np.maximum.reduceat(aside, drawing.corners.first) / np.maximum(self.middles[:, 0], 1e-12)
        is_free = ~drawing.taken & (np.abs(np.vecdot(drawing.normals, around)) < width + NEARLY)
        is_open = is_free[drawing.seams].all(axis=1)
        for every, all_vertices in drawing.seam_vertices:
            seams, vertices = every[is_open[every]], all_vertices[:, is_open[every]]
            r, z = self.flat[:, 0][vertices], self.flat[:, 1][vertices]
            is_new = np.ones(vertices.shape, dtype=bool)
            for k in range(1, len(vertices)):
                for known in range(k):
                    is_same = (np.abs(r[known] - r[k]) <= apart) & (np.abs(z[known] - z[k]) <= apart)
                    is_new[k] &= ~(is_same & is_new[known])
            middle_r, middle_z, radius = circles_through(r, z, is_new)
            off = np.abs(np.hypot(r - middle_r, z - middle_z) - radius).max(axis=0)
            number = is_new.sum(axis=0)
            is_one = np.maximum(np.ptp(r, axis=0), np.ptp(z, axis=0)) < self.near
            extent = np.hypot(np.ptp(r, axis=0), np.ptp(z, axis=0))
            along = np.array([r - r.mean(axis=0), z - z.mean(axis=0)])
            a, b, c = (along[0] ** 2).sum(axis=0), (along[0] * along[1]).sum(axis=0), (along[1] ** 2).sum(axis=0)
            is_line = np.sqrt(np.maximum(a + c - np.hypot(a - c, 2 * b), 0) / 2) <= drawing.tolerance
            is_line &= extent > math.sqrt(8 * drawing.vessel.size * drawing.tolerance)
            number = np.where(is_line, np.minimum(number, 2), number)
            counts[seams] = np.where(~is_one & ((number < 3) | (off <= 2 * drawing.tolerance)), number, 0)
            row, column = (np.round(each / apart).astype(np.int64) for each in (r, z))
            names[seams] = (((row * PRIMES[0]) ^ (column * PRIMES[1])) * is_new).sum(axis=0)
        return counts, names


def slopes(shape: Line | Circle, flat: np.ndarray) -> np.ndarray:
    """Unit normals (n, 2) of a line or circle at points (n, 2) near it."""
    if isinstance(shape, Line):
        return np.broadcast_to([math.cos(shape.angle), math.sin(shape.angle)], flat.shape)
    away = flat - [shape.r, shape.z]
    return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)


def on_axis_circle(flat: np.ndarray) -> Circle:
    """The circle with its middle on the axis that is nearest to points (n, 2)."""
    middle = flat[:, 1].mean()
    local = flat[:, 1] - middle
    columns = np.column_stack([2 * local, np.ones(len(local))])
    solution, *_ = np.linalg.lstsq(columns, (flat[:, 0] ** 2 + local**2), rcond=None)
    return Circle(0.0, float(solution[0] + middle), math.sqrt(max(solution[1] + solution[0] ** 2, 0.0)))


def fitted_again(arc: Circle, flat: np.ndarray) -> Circle:
    """An arc fitted to other points (n, 2); a sphere stays one."""
    return Circle.through(flat) if arc.r else on_axis_circle(flat)
