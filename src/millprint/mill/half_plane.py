"""The half plane about an axis: which walls of a drawing are lines and arcs there, and so surfaces that turn."""

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

# Four points may lie on one circle by chance of symmetry; this number of steps around or across does not.
FEWEST_STEPS = 5
# A step that is longer than most of its arc's, by this factor, may be one of the next arc, which ends on this one too.
EVEN = 1.25
# How far the middle of a facet is below its surface, over the radii, where it is drawn in steps of LARGEST_TURN.
SAG = 1.3 * (1 - math.cos(LARGEST_TURN / 2))
# Seeds that lead nowhere, after which the search about one axis, or for one kind, ends; the first ones in a row.
MOST_FAILURES, FIRST_FAILURES = 300, 20
# So many of the next facets lie on a surface where it begins, if nothing interrupts it.
NEAR, FEWEST_NEAR = 100, 6
# To name a place of a lattice by one number.
PRIMES = 73856093, 19349663
# Directions that differ by less may be one, if the vertices allow it [rad].
NEARLY = 0.02


class HalfPlane:
    """Facets of a drawing, all or some, in the half plane about an axis.

    vertices: the numbers of their vertices; flat: these in the half plane; corners: the rows of `flat` at the facets'
    corners; middles and facing (f, 2): the facets' middles and normals; is_ring (f,): whether all vertices are one.
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
        (x, z), (r, up) = np.repeat(self.middles[rows] - [arc.r, arc.z], counts, axis=0).T, away.T
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
                sphere = _on_axis_circle(own)
                is_sphere = abs(shape.r) < self.near or np.abs(sphere.off(own)).max() <= drawing.tolerance
                shape = sphere if is_sphere else shape
            holds = free & self.on(drawing, shape, slack)
            facing = np.vecdot(self.facing, _slopes(shape, self.middles))
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
                return best
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


def _fitted(drawing: Drawing, plane: HalfPlane, seed: Sequence[int], kind: type[Line] | type[Circle]) -> Swept | None:
    """The surface about an axis that begins with two facets, each of whose vertices lies on it."""
    found = plane.fit(drawing, seed, kind) if surface_begins(drawing, plane.axis, seed, (kind,)) else None
    return Swept(plane.axis, *found) if found else None


def surface_begins(
    drawing: Drawing, axis: Axis, seam: Sequence[int], kinds: Sequence[type[Line] | type[Circle]] = (Circle, Line)
) -> bool:
    """Whether a surface about an axis begins at a seam, as far as the facets near it show."""
    plane = HalfPlane(drawing, axis, np.array(drawing.around(seam, NEAR)))
    found = [plane.fit(drawing, (0, 1), kind) for kind in kinds]
    # Where other walls interrupt a surface, there are few of it.
    least = FEWEST_NEAR if len(plane.facets) == NEAR else 1
    return any(fit is not None and len(fit[1]) >= least for fit in found)


def _slopes(shape: Line | Circle, flat: np.ndarray) -> np.ndarray:
    """Unit normals (n, 2) of a line or circle at points (n, 2) near it."""
    if isinstance(shape, Line):
        return np.broadcast_to([math.cos(shape.angle), math.sin(shape.angle)], flat.shape)
    away = flat - [shape.r, shape.z]
    return away / np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)


def _on_axis_circle(flat: np.ndarray) -> Circle:
    """The circle with its middle on the axis that is nearest to points (n, 2)."""
    middle = flat[:, 1].mean()
    local = flat[:, 1] - middle
    columns = np.column_stack([2 * local, np.ones(len(local))])
    solution, *_ = np.linalg.lstsq(columns, (flat[:, 0] ** 2 + local**2), rcond=None)
    return Circle(0.0, float(solution[0] + middle), math.sqrt(max(solution[1] + solution[0] ** 2, 0.0)))


def _again(arc: Circle, flat: np.ndarray) -> Circle:
    """An arc fitted to other points (n, 2); a sphere stays one."""
    return Circle.through(flat) if arc.r else _on_axis_circle(flat)


def _steps(drawing: Drawing, swept: Swept) -> tuple[int, int]:
    """How many different places the vertices of a surface have around the axis, and along its line or arc."""
    points = drawing.points(swept.facets)
    flat, angles = swept.axis.meridian(points), swept.axis.angles(points)
    off_axis = flat[:, 0] > LOOSE * drawing.tolerance
    around = places(angles[off_axis] * flat[off_axis, 0].max(initial=0.0), 4 * drawing.tolerance)
    return around, places(swept.shape.along(flat), 4 * drawing.tolerance)


def places(values: np.ndarray, apart: float) -> int:
    """How many different ones there are of some values (n,) that are the same if they are not farther apart."""
    return 1 + int((np.diff(np.sort(values)) > apart).sum()) if len(values) else 0


def is_round(drawing: Drawing, facets: np.ndarray, middle: np.ndarray) -> bool:
    """Whether vertices on a sphere lie on more than two parallel circles of it: any two have a sphere through them.

    Circles are as far apart as on the sphere: near its pole their heights are nearly one.
    """
    out = drawing.points(facets) - middle
    radii = lengths(out)
    _, _, directions = np.linalg.svd(out - out.mean(axis=0), full_matrices=False)
    ways = radii.mean() * np.arccos(np.clip(out / radii @ directions.T, -1, 1))
    return min(places(way, LOOSE * drawing.tolerance) for way in ways.T) > FEWEST_STEPS


def _is_enough(drawing: Drawing, plane: HalfPlane, swept: Swept) -> bool:
    around, across = _steps(drawing, swept)
    if isinstance(swept.shape, Line):
        # A plane across the axis is flat by itself.
        return around > FEWEST_STEPS and abs(math.cos(swept.shape.angle)) > 1e-4
    # A mantle with a port has vertices at many heights, which are also on an arc of a huge radius.
    flat = swept.axis.meridian(drawing.points(swept.facets))
    if np.abs(Line.through(flat).off(flat)).max() <= drawing.tolerance:
        return False
    # Three columns of a wall that is bent both ways seem to turn about an axis across it too, and one row of facets
    # about any axis that is slanted.
    if around <= FEWEST_STEPS or len(swept.facets) < FEWEST_STEPS**2:
        return False
    middle = swept.axis.origin + swept.shape.z * swept.axis.along
    is_many = is_round(drawing, swept.facets, middle) if swept.shape.r == 0.0 else across > FEWEST_STEPS
    return is_many or _is_rounding(drawing, plane, swept.shape, swept.facets)


def _turns(drawing: Drawing, plane: HalfPlane, arc: Circle, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where an arc has its rings: a direction (2,) from its middle, and angles from there, ascending [rad].

    Of a sphere's, the direction is that of the nearer pole, and each ring is on both sides of it.
    """
    towards = np.median(plane.middles[facets], axis=0) - [arc.r, arc.z]
    if arc.r == 0.0:
        towards[0] = 0.0
    towards /= np.linalg.norm(towards)
    x, z = (plane.points(facets) - [arc.r, arc.z]).T
    turns = np.arctan2(towards[0] * z - towards[1] * x, towards[0] * x + towards[1] * z)
    turns = np.sort(np.append(turns, -turns) if arc.r == 0.0 else turns)
    apart = np.flatnonzero(np.diff(turns) * arc.radius > 4 * drawing.tolerance) + 1
    return towards, np.array([ring.mean() for ring in np.split(turns, apart)])


def _is_rounding(drawing: Drawing, plane: HalfPlane, arc: Circle, facets: np.ndarray) -> bool:
    """Whether an arc is meant by few steps about an axis, as far as the file's rounding can show it.

    They are alike, and four at least, or the walls at both ends are tangent to the arc. A chain of cones is neither.
    """
    near, middle = 4 * drawing.tolerance, np.array([arc.r, arc.z])
    towards, turns = _turns(drawing, plane, arc, facets)
    steps = arc.radius * np.diff(turns)
    if arc.r == 0.0 and np.ptp(steps) > near:
        # It does not reach its pole.
        turns = turns[turns > 0]
        steps = arc.radius * np.diff(turns)
    if len(steps) < 2 or np.ptp(steps) > near:
        return False
    if len(steps) >= FEWEST_STEPS - 1:
        return True
    # The wall that follows is tangent, or turns by half a step more, which must be told from it over a step's length.
    near = min(near, steps.mean() ** 2 / (4 * arc.radius))
    if near < drawing.tolerance:
        return False
    beside = np.setdiff1d(np.concatenate([drawing.neighbours[facet] for facet in facets]), facets).astype(np.int64)
    for cosine, sine in zip(np.cos(turns[[0, -1]]), np.sin(turns[[0, -1]]), strict=True):
        normal = np.array([cosine * towards[0] - sine * towards[1], sine * towards[0] + cosine * towards[1]])
        apart = np.linalg.norm(plane.flat - middle - arc.radius * normal, axis=1)
        walls = beside[(-plane.largest(-apart) < 4 * drawing.tolerance)[beside]]
        # Of a floor, all vertices are one place.
        slopes = plane.facing[walls[plane.is_ring[walls]]]
        if len(walls := walls[~plane.is_ring[walls]]):
            wall = Line.through(plane.points(walls))
            slopes = np.vstack([slopes, _slopes(wall, normal[None])])
        off = np.abs(slopes[:, 0] * normal[1] - slopes[:, 1] * normal[0])
        if not len(off) or off.max() * steps.mean() > near:
            return False
    return True


def surfaces_about(drawing: Drawing, plane: HalfPlane) -> list[Swept]:
    """The surfaces about an axis: arcs first, since each of their steps is a line too; their facets are taken.

    Each of their pieces is one, where other walls interrupt them.
    """
    found: list[Swept] = []
    counts, names = plane.rings(drawing)

    def find(kind: type[Line] | type[Circle], fits: np.ndarray) -> None:
        """Take the surfaces of a kind that begin at some seams (s,)."""
        # All pairs between the same rings fail alike; an axis about which nothing begins soon is none.
        failed: set[int] = set()
        # So do those that are in one failed fit, as rings that rounding has given different places.
        failed_with = np.zeros(len(drawing.taken), dtype=np.int64)
        seams = np.flatnonzero(fits & ~drawing.taken[drawing.seams].any(axis=1))
        for pair, name in zip(drawing.seams[seams].tolist(), names[seams].tolist(), strict=True):
            if len(failed) > (MOST_FAILURES if found else FIRST_FAILURES):
                break
            if name in failed or drawing.taken[pair[0]] or drawing.taken[pair[1]]:
                continue
            if failed_with[pair[0]] == failed_with[pair[1]] > 0:
                failed.add(name)
                continue
            own = plane.flat[np.concatenate([drawing.vertices_of[facet] for facet in pair])]
            swept = None
            if np.abs(kind.through(_different(own, drawing.tolerance)).off(own)).max() <= drawing.tolerance:
                swept = _fitted(drawing, plane, pair, kind)
            if swept and _is_enough(drawing, plane, swept):
                drawing.taken[swept.facets] = True
                found.append(swept)
                continue
            failed.add(name)
            if swept:
                failed_with[swept.facets] = len(failed)

    find(Circle, counts > 2)
    for each in list(found):
        assert isinstance(each.shape, Circle)
        # A far longer step than the others of its arc may be of the next one, which had too few without it, or a wall.
        even = plane.is_even(drawing, each.shape, each.facets, each.facets)
        long = each.facets[~even]
        drawing.taken[long] = False
        is_long = np.isin(drawing.seams, long)
        find(Circle, (counts > 2) & is_long.any(axis=1))
        find(Line, ((counts == 1) | (counts == 2)) & is_long.all(axis=1))
        if drawing.taken[long].any():
            each.facets = np.sort(np.append(each.facets[even], long[~drawing.taken[long]]))
            each.shape = _again(each.shape, plane.points(each.facets))
        if each.shape.r == 0.0:
            each.facets = np.sort(np.append(each.facets, plane.caps(drawing, each.shape, each.facets)))
        drawing.taken[each.facets] = True
    find(Line, (counts == 1) | (counts == 2))
    _settle(drawing, plane, found)
    return [Swept(plane.axis, each.shape, piece) for each in found for piece in drawing.pieces(each.facets)]


def _settle(drawing: Drawing, plane: HalfPlane, found: list[Swept]) -> None:
    """Let facets that are side by side about the axis be of one surface, the larger one if all lie on it.

    A far longer step than the others of its arc is of the other surface, however, and a step that lies on two arcs is
    of the one whose steps are like it.
    Where two surfaces meet, rounding gives some facets of a ring to either, and a step that is drawn as one facet with
    the next one, or with the wall that follows, makes rings that begin surfaces of their own.
    """
    found.sort(key=lambda each: len(each.facets))
    owner = np.full(len(drawing.taken), -1)
    for number, each in enumerate(found):
        owner[each.facets] = number
    is_on = [plane.on(drawing, each.shape, 1.0) for each in found]

    def is_even(number: int, rows: np.ndarray) -> np.ndarray:
        return plane.is_even(drawing, found[number].shape, found[number].facets, rows)

    def pairs() -> list[list[int]]:
        """The surfaces next to each other, the smaller one first, those with the largest ones first."""
        sides = np.sort(owner[drawing.vessel.edge_arrays.facets], axis=1)
        return np.unique(sides[(sides[:, 0] >= 0) & (sides[:, 0] != sides[:, 1])][:, ::-1], axis=0)[::-1, ::-1].tolist()

    for small, large in pairs():
        own = np.flatnonzero((owner == small) & is_on[large])
        owner[own[is_even(large, own) & plane.is_nearer(drawing, found[large], found[small], own)]] = large
        own = np.flatnonzero((owner == large) & is_on[small])
        owner[own[~is_even(large, own) & is_even(small, own)]] = small
    for small, large in pairs():
        meets = -plane.largest(-np.abs(found[large].shape.off(plane.flat))) <= LOOSE * drawing.tolerance
        own = np.flatnonzero(meets & np.isin(owner, (small, large)))
        along = _along(plane, found[large].shape, plane.corners[plane.of_facet.rows(own[owner[own] == large])])
        low, high = -plane.largest(-along)[own], plane.largest(along)[own]
        order = np.argsort(low, kind="stable")
        own, low, high = own[order], low[order], np.maximum.accumulate(high[order])
        for beside in np.split(own, np.flatnonzero(low[1:] >= high[:-1] - 4 * drawing.tolerance) + 1):
            if (owner[beside] == small).any() and (owner[beside] == large).any():
                for number in (small, large):
                    if is_on[number][beside].all():
                        owner[beside] = number
    for number, each in enumerate(found):
        before, each.facets = each.facets, np.flatnonzero(owner == number)
        if isinstance(each.shape, Circle) and 0 < len(each.facets) != len(before):
            own = plane.points(each.facets)
            line = Line.through(own)
            # An arc whose other steps are its neighbours' is the line that is left of it.
            is_line = np.abs(line.off(own)).max() <= drawing.tolerance
            each.shape = line if is_line else _again(each.shape, own)


def _along(plane: HalfPlane, shape: Line | Circle, own: np.ndarray) -> np.ndarray:
    """Ways (v,) along a shape to all vertices; those along a circle are cut across from some `own` ones."""
    along = shape.along(plane.flat)
    if isinstance(shape, Line):
        return along
    middle = shape.radius * float(np.angle(np.exp(1j * along[own] / shape.radius).sum()))
    return (along - middle) - 2 * math.pi * shape.radius * np.round((along - middle) / (2 * math.pi * shape.radius))


def _different(flat: np.ndarray, tolerance: float) -> np.ndarray:
    """The different ones of a few points (n, 2), within a tolerance."""
    kept: list[np.ndarray] = []
    for point in flat:
        if all(np.abs(point - other).max() > 4 * tolerance for other in kept):
            kept.append(point)
    return np.array(kept)
