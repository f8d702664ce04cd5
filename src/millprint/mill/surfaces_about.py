"""Which walls of a drawing are surfaces that turn about an axis, by lines and arcs in the half plane about it."""

import math
from collections.abc import Sequence

import numpy as np

from millprint.mill.half_plane import HalfPlane, fitted_again, slopes
from millprint.mill.outlines import lengths
from millprint.mill.turned_shapes import LOOSE, Axis, Circle, Drawing, Line, Swept

# Four points may lie on one circle by chance of symmetry; this number of steps around or across does not.
FEWEST_STEPS = 5
# Rings of an arc are apart by more than this share of its length.
APART = 0.05
# Seeds that lead nowhere, after which the search about one axis, or for one kind, ends; the first ones in a row.
MOST_FAILURES, FIRST_FAILURES = 300, 20
# Pairs of facets that differ by less than this share of their extent in the half plane are of the same rings.
SAME_RING = 0.1
# So many of the next facets lie on a surface where it begins, if nothing interrupts it.
NEAR, FEWEST_NEAR = 100, 6


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


def _steps_around(drawing: Drawing, swept: Swept) -> int:
    """How many different places the vertices of a surface have around the axis."""
    points = drawing.points(swept.facets)
    flat, angles = swept.axis.meridian(points), swept.axis.angles(points)
    off_axis = flat[:, 0] > LOOSE * drawing.tolerance
    return places(angles[off_axis] * flat[off_axis, 0].max(initial=0.0), 4 * drawing.tolerance)


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


def _rings(turns: np.ndarray) -> int:
    """How many of some ascending angles are apart, by a share of what all of them span.

    A cone on each side of a small rounding may lie on one arc with it, and about an axis that is nearly right a ring
    is in many places.
    """
    count, last = 0, -math.inf
    for turn in turns.tolist():
        if turn - last > APART * (turns[-1] - turns[0]):
            count, last = count + 1, turn
    return count


def _is_enough(drawing: Drawing, plane: HalfPlane, swept: Swept) -> bool:
    around = _steps_around(drawing, swept)
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
    if swept.shape.r == 0.0:
        is_many = is_round(drawing, swept.facets, middle)
    else:
        is_many = _rings(_turns(drawing, plane, swept.shape, swept.facets)[1]) > FEWEST_STEPS
    return is_many or _is_rounding(drawing, plane, swept.shape, swept.facets)


def _turns(drawing: Drawing, plane: HalfPlane, arc: Circle, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where an arc has its rings: a direction (2,) from its middle, and angles from there, ascending [rad].

    Of a sphere's, the direction is that of the nearer pole, and each ring is on both sides of it.
    """
    towards = np.median(plane.means[facets], axis=0) - [arc.r, arc.z]
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
        facing = plane.facing[walls[plane.is_ring[walls]]]
        if len(walls := walls[~plane.is_ring[walls]]):
            wall = Line.through(plane.points(walls))
            facing = np.vstack([facing, slopes(wall, normal[None])])
        off = np.abs(facing[:, 0] * normal[1] - facing[:, 1] * normal[0])
        if not len(off) or off.max() * steps.mean() > near:
            return False
    return True


class _Failures:
    """Pairs of facets at which no surface about an axis begins.

    All between the same rings fail alike, and so do those that are in one failed fit, as rings that rounding has given
    different places. About an axis that is nearly right, a ring has many names, but is in one place but for a share of
    its steps.
    """

    def __init__(self, plane: HalfPlane, facets: int) -> None:
        self.plane = plane
        self.names: set[int] = set()
        self.fit_of = np.zeros(facets, dtype=np.int64)
        self.places = np.empty((0, 4))

    def are_enough(self, is_found: bool) -> bool:
        """Whether the search ends: an axis about which nothing begins soon is none."""
        return len(self.names) > MOST_FAILURES or (not is_found and len(self.places) > FIRST_FAILURES)

    def has(self, pair: Sequence[int], name: int) -> bool:
        """Whether a pair will fail as one before it; name: that of its rings."""
        if self.fit_of[pair[0]] == self.fit_of[pair[1]] > 0:
            self.names.add(name)
        return name in self.names

    def add(self, pair: Sequence[int], name: int, extent: float, fit: np.ndarray) -> None:
        """A pair that has failed; extent: its own in the half plane [m]; fit: the facets of its surface, if any."""
        self.names.add(name)
        self.fit_of[fit] = len(self.names)
        place = self.plane.middles[list(pair)].ravel()
        if (np.abs(self.places - place).max(axis=1) >= SAME_RING * extent).all():
            self.places = np.vstack([self.places, place])


def surfaces_about(drawing: Drawing, plane: HalfPlane) -> list[Swept]:
    """The surfaces about an axis: arcs first, since each of their steps is a line too; their facets are taken.

    Each of their pieces is one, where other walls interrupt them.
    """
    found: list[Swept] = []
    counts, names = plane.rings(drawing)

    def find(kind: type[Line] | type[Circle], fits: np.ndarray) -> None:
        """Take the surfaces of a kind that begin at some seams (s,)."""
        failures = _Failures(plane, len(drawing.taken))
        seams = np.flatnonzero(fits & ~drawing.taken[drawing.seams].any(axis=1))
        for pair, name in zip(drawing.seams[seams].tolist(), names[seams].tolist(), strict=True):
            if failures.are_enough(bool(found)):
                break
            if drawing.taken[pair[0]] or drawing.taken[pair[1]] or failures.has(pair, name):
                continue
            own = plane.flat[np.concatenate([drawing.vertices_of[facet] for facet in pair])]
            swept = None
            if np.abs(kind.through(_different(own, drawing.tolerance)).off(own)).max() <= drawing.tolerance:
                swept = _fitted(drawing, plane, pair, kind)
            if swept and _is_enough(drawing, plane, swept):
                drawing.taken[swept.facets] = True
                found.append(swept)
            else:
                fit = swept.facets if swept else np.empty(0, dtype=np.int64)
                failures.add(pair, name, float(np.ptp(own, axis=0).max()), fit)

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
            each.shape = fitted_again(each.shape, plane.points(each.facets))
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

    def is_like(number: int, other: int, rows: np.ndarray) -> np.ndarray:
        """Which rows that lie on two surfaces are steps like those of the first."""
        return is_even(number, rows) & plane.is_nearer(drawing, found[number], found[other], rows)

    for small, large in pairs():
        own = np.flatnonzero((owner == small) & is_on[large])
        owner[own[is_like(large, small, own)]] = large
        own = np.flatnonzero((owner == large) & is_on[small])
        owner[own[~is_like(large, small, own) & is_even(small, own)]] = small
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
            each.shape = line if is_line else fitted_again(each.shape, own)


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
