"""Random closed hollows of lines and arcs, turned about an axis or extruded along one, and meshes of them.

A profile runs round the hollow with the balls on its left. That of a turned hollow runs in the half plane (r, z) from
the axis to the axis; that of an extruded one is closed. All lengths are in mm. `hollow_of(seed)` is the same for the
same seed, whatever was made before.
"""

import math
import struct
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
import shapely

FEWEST_STEPS, LARGEST_STEP = 5, math.radians(18)  # of an arc in a mesh
LARGEST_TURN = math.radians(130)  # of a joint


@dataclass(frozen=True)
class Piece:
    """A line, or an arc of less than a turn, from `start` to `end` (2,).

    sweep: angle by which an arc turns left [rad]: positive where it is hollow as seen by a ball; 0 for a line.
    """

    start: np.ndarray
    end: np.ndarray
    sweep: float = 0.0

    @cached_property
    def chord(self) -> np.ndarray:
        """From start to end."""
        return self.end - self.start

    @cached_property
    def radius(self) -> float:
        """Of an arc."""
        return float(np.linalg.norm(self.chord)) / (2 * math.sin(abs(self.sweep) / 2))

    @cached_property
    def centre(self) -> np.ndarray:
        """Of an arc."""
        return (self.start + self.end) / 2 + left(self.chord) / (2 * math.tan(self.sweep / 2))

    @cached_property
    def length(self) -> float:
        """Along the piece."""
        return self.radius * abs(self.sweep) if self.sweep else float(np.linalg.norm(self.chord))

    def at(self, share: np.ndarray) -> np.ndarray:
        """Points (n, 2) at shares of the way from start to end; the ends are exact."""
        share = np.asarray(share, dtype=float)[:, None]
        if not self.sweep:
            return self.start + share * self.chord
        angle = share * self.sweep
        arm = self.start - self.centre
        points = self.centre + np.cos(angle) * arm + np.sin(angle) * left(arm)
        return np.where(share == 0, self.start, np.where(share == 1, self.end, points))

    def along(self, share: float) -> np.ndarray:
        """The unit tangent (2,) there."""
        angle = (share - 0.5) * self.sweep
        return turned_by(self.chord, angle) / np.linalg.norm(self.chord)


def left(vector: np.ndarray) -> np.ndarray:
    """Vectors (..., 2) turned by a quarter to the left."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def turned_by(vector: np.ndarray, angle: float) -> np.ndarray:
    """A vector (2,) turned to the left by an angle [rad]."""
    return math.cos(angle) * vector + math.sin(angle) * left(vector)


def turn_between(before: np.ndarray, after: np.ndarray) -> float:
    """The angle from one tangent to the next [rad]: positive in a concave joint, negative at a convex one."""
    return math.atan2(before[0] * after[1] - before[1] * after[0], before @ after)


@dataclass(frozen=True)
class Hollow:
    """A closed hollow. height: how far the profile is extruded; None where it is turned about its axis r = 0.

    rotation (3, 3) and shift (3,) put it in its place.
    """

    kind: str
    pieces: tuple[Piece, ...]
    height: float | None = None
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))
    shift: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def is_turned(self) -> bool:
        """Whether it is turned about its axis."""
        return self.height is None

    def placed(self, rotation: np.ndarray, shift: np.ndarray) -> "Hollow":
        """The same elsewhere."""
        return replace(self, rotation=rotation, shift=shift)

    def to_space(self, local: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the hollow's own frame where it lies."""
        return local @ self.rotation.T + self.shift

    @cached_property
    def joints(self) -> list[tuple[int, int, float]]:
        """Pieces before and after each joint, and by how much the profile turns left there [rad]."""
        pairs = list(zip(range(len(self.pieces) - 1), range(1, len(self.pieces)), strict=True))
        if not self.is_turned:
            pairs.append((len(self.pieces) - 1, 0))
        return [(a, b, turn_between(self.pieces[a].along(1.0), self.pieces[b].along(0.0))) for a, b in pairs]

    @cached_property
    def tips(self) -> list[tuple[np.ndarray, np.ndarray, float]]:
        """Points in which a turned hollow juts in on its axis: place, tangent before, and how far its image turns."""
        if not self.is_turned:
            return []
        begin, end = self.pieces[0].along(0.0), self.pieces[-1].along(1.0)
        ends = [(self.pieces[0].start, begin * [1, -1], begin), (self.pieces[-1].end, end, end * [1, -1])]
        found = [(place, before, turn_between(before, after)) for place, before, after in ends]
        return [(place, before, turn) for place, before, turn in found if turn < -1e-7]

    @cached_property
    def inscribed(self) -> float:
        """Radius of the largest ball that fits in."""
        outline = shapely.Polygon(self.outline(0.05))
        if self.is_turned:
            outline = shapely.union(outline, shapely.transform(outline, lambda at: at * [-1, 1]))
        inscribed = shapely.maximum_inscribed_circle(outline, 0.05).length
        return inscribed if self.is_turned else min(inscribed, self.height / 2)

    @cached_property
    def tightest(self) -> float:
        """Radius of the largest ball that fits in all hollow arcs."""
        return min([self.inscribed, *(piece.radius for piece in self.pieces if piece.sweep > 0)])

    def outline(self, step: float) -> np.ndarray:
        """The profile as a closed polygon (k, 2), its arcs in steps of at most an angle [rad]."""
        points = [piece.at(np.linspace(0, 1, 1 + math.ceil(abs(piece.sweep) / step))[:-1]) if piece.sweep
                  else piece.start[None] for piece in self.pieces]  # fmt: skip
        return np.concatenate([*points, *([self.pieces[-1].end[None]] if self.is_turned else [])])

    def describe(self) -> str:
        """The profile in words."""
        rows = [
            f"  ({p.start[0]:.6g}, {p.start[1]:.6g}) " + (f"arc {math.degrees(p.sweep):.4g} deg, radius {p.radius:.4g}"
                                                          if p.sweep else "line") for p in self.pieces
        ]  # fmt: skip
        turns = ", ".join(f"{math.degrees(turn):.3g}" for *_, turn in self.joints)
        height = "" if self.is_turned else f", height {self.height:.5g}"
        return f"{self.kind}{height}\n" + "\n".join(rows) + f"\n  turns of the joints [deg]: {turns}"


def chain(points: list, sweeps: list[float], closed: bool) -> tuple[Piece, ...]:
    """Pieces through points (k, 2); `sweeps` of the ways between. Arcs of over 170 degrees are halved."""
    points = [np.asarray(point, dtype=float) for point in points]
    pieces = []
    ways = pairwise([*points, points[0]] if closed else points)
    for (start, end), sweep in zip(ways, sweeps, strict=True):
        whole = Piece(start, end, sweep)
        if abs(sweep) > math.radians(170):
            (middle,) = whole.at(np.array([0.5]))
            pieces += [Piece(start, middle, sweep / 2), Piece(middle, end, sweep / 2)]
        else:
            pieces.append(whole)
    return tuple(pieces)


def rounded(pieces: tuple[Piece, ...], joint: int, after: int, radius: float) -> tuple[Piece, ...]:
    """The profile with the corner between two lines, `joint` and `after`, rounded by a tangent arc."""
    first, second = pieces[joint], pieces[after]
    turn = turn_between(first.along(1.0), second.along(0.0))
    cut = radius * math.tan(abs(turn) / 2)
    begin, end = first.end - cut * first.along(1.0), second.start + cut * second.along(0.0)
    made = list(pieces)
    made[joint], made[after] = Piece(first.start, begin), Piece(end, second.end)
    made.insert(joint + 1, Piece(begin, end, turn))
    return tuple(made)


def with_fillets(pieces: tuple[Piece, ...], rng: np.random.Generator, closed: bool, share: float) -> tuple[Piece, ...]:
    """Some corners between lines rounded, concave and convex ones."""
    joint = 0
    while joint < len(pieces) - (0 if closed else 1):
        after = (joint + 1) % len(pieces)
        first, second = pieces[joint], pieces[after]
        turn = turn_between(first.along(1.0), second.along(0.0))
        if not first.sweep and not second.sweep and 0.2 < abs(turn) < LARGEST_TURN and rng.random() < share:
            room = 0.45 * min(first.length, second.length) / math.tan(abs(turn) / 2)
            pieces = rounded(pieces, joint, after, min(room, 12.0) * rng.uniform(0.3, 1.0))
            joint += 1
        joint += 1
    return pieces


def _end(rng: np.random.Generator, radius: float) -> tuple[list[tuple[float, float]], list[float]]:
    """Points (r, z) of a floor from the axis out to its rim, which is at z = 0 and left out, and sweeps of the ways."""
    kinds = ["flat", "dome", "half sphere", "cone", "tip", "bulge", "post"]
    kind = rng.choice(kinds, p=[0.4, 0.2, 0.1, 0.15, 0.05, 0.05, 0.05])
    if kind in ("dome", "bulge"):
        sweep = math.radians(rng.uniform(15, 80)) * (1 if kind == "dome" else -0.5)
        return [(0.0, -radius * math.tan(sweep / 2))], [sweep]
    if kind == "half sphere":
        return [(0.0, -radius)], [math.pi / 2]
    if kind in ("cone", "tip"):
        return [(0.0, -radius * math.tan(math.radians(rng.uniform(2, 40))) * (1 if kind == "cone" else -0.5))], [0.0]
    if kind == "post":
        out, up = radius * rng.uniform(0.2, 0.5), radius * rng.uniform(0.1, 0.8)
        return [(0.0, up), (out, up), (out + up * rng.choice([0.0, 0.2]), 0.0)], [0.0, 0.0, 0.0]
    return [(0.0, 0.0)], [0.0]


def _mantle(rng: np.random.Generator, radius: float) -> tuple[list[tuple[float, float]], list[float]]:
    """Points (r, z) from the rim of the floor up, and sweeps of the ways between."""
    size, points, sweeps = radius, [(radius, 0.0)], []
    for _ in range(rng.integers(1, 5)):
        r, z = points[-1]
        kind = rng.choice(["cylinder", "cone", "step", "hollow", "belly"], p=[0.3, 0.3, 0.15, 0.15, 0.1])
        length, sweep = size * rng.uniform(0.25, 0.9), 0.0
        if kind == "cylinder":
            way = (0.0, length)
        elif kind == "cone":
            draft = math.radians(rng.choice([rng.uniform(0.3, 3), rng.uniform(1, 36), rng.uniform(30, 40)]))
            draft *= rng.choice([-1, 1])
            way = (length * math.sin(draft), length * math.cos(draft))
        elif kind == "step":
            # A seat or a neck; rarely along another one, which would be no corner.
            way = (size * rng.uniform(0.05, 0.35) * rng.choice([-1, 1]), 0.0)
        else:
            draft = math.radians(rng.uniform(-30, 30))
            sweep = math.radians(rng.uniform(10, 110)) * (1 if kind == "hollow" else -1)
            way = (length * math.sin(draft), length * math.cos(draft))
        points.append((r + way[0], z + way[1]))
        sweeps.append(sweep)
    return points, sweeps


def turned(rng: np.random.Generator) -> Hollow | None:
    """A random profile from axis to axis; None where it is not one of a hollow that balls fit in."""
    radius = math.exp(rng.uniform(math.log(8), math.log(60)))
    mantle, sweeps = _mantle(rng, radius)
    floor, floor_sweeps = _end(rng, radius)
    lid, lid_sweeps = _end(rng, mantle[-1][0])
    points = [*floor, *mantle, *((r, mantle[-1][1] - z) for r, z in reversed(lid))]
    pieces = chain(points, [*floor_sweeps, *sweeps, *reversed(lid_sweeps)], closed=False)
    pieces = with_fillets(pieces, rng, closed=False, share=0.4)
    return _checked(Hollow("turned", pieces), rng)


def sphere(radius: float) -> Hollow:
    """A sphere."""
    return Hollow("sphere", chain([(0, -radius), (radius, 0), (0, radius)], [math.pi / 2] * 2, closed=False))


def _polygon(rng: np.random.Generator, size: float) -> tuple[Piece, ...]:
    """A polygon about the origin, with corners that jut in."""
    count = rng.integers(3, 8)
    angle = (np.arange(count) + rng.uniform(-0.3, 0.3, count)) * 2 * np.pi / count
    out = size * rng.uniform(0.5, 1.0, count)
    points = np.column_stack([out * np.cos(angle), out * np.sin(angle)])
    sweeps = [math.radians(rng.uniform(-40, 60)) if rng.random() < 0.2 else 0.0 for _ in range(count)]
    return with_fillets(chain(list(points), sweeps, closed=True), rng, closed=True, share=0.5)


def _keyhole(rng: np.random.Generator, size: float) -> tuple[Piece, ...]:
    half = math.radians(rng.uniform(12, 50))
    out = size * rng.uniform(1.3, 2.2)
    foot, tip = size * np.array([math.cos(half), math.sin(half)]), np.array([out, size * math.sin(half)])
    points = [foot, (-size, 0.0), foot * [1, -1], tip * [1, -1], tip]
    arc = math.pi - half
    return with_fillets(chain(points, [arc, arc, 0, 0, 0], closed=True), rng, closed=True, share=0.4)


def stadium_pieces(radius: float, straight: float) -> tuple[Piece, ...]:
    """Two half circles and two straight sides, the long way along x."""
    x = straight / 2
    points = [(x, -radius), (x, radius), (-x, radius), (-x, -radius)]
    return chain(points, [math.pi, 0.0, math.pi, 0.0], closed=True)


def circle_pieces(radius: float) -> tuple[Piece, ...]:
    """A circle."""
    points = [radius * np.array([math.cos(a), math.sin(a)]) for a in (0, 2.1, 4.2)]
    return chain(points, [2.1, 2.1, 2 * math.pi - 4.2], closed=True)


def extruded(rng: np.random.Generator) -> Hollow | None:
    """A random outline times a height; None as in `turned`."""
    size = math.exp(rng.uniform(math.log(8), math.log(50)))
    kind = rng.choice(["polygon", "keyhole", "stadium", "D", "circle"], p=[0.5, 0.15, 0.15, 0.15, 0.05])
    if kind == "polygon":
        pieces = _polygon(rng, size)
    elif kind == "keyhole":
        pieces = _keyhole(rng, size)
    elif kind == "stadium":
        pieces = stadium_pieces(size, size * rng.uniform(0.2, 2))
    elif kind == "circle":
        pieces = circle_pieces(size)
    else:
        half = math.radians(rng.uniform(30, 140))
        corner = size * np.array([math.cos(half), math.sin(half)])
        pieces = chain([corner * [1, -1], (size, 0.0), corner], [half, half, 0.0], closed=True)
    return _checked(Hollow(str(kind), pieces, size * rng.uniform(0.4, 1.5)), rng)


def interrupted(rng: np.random.Generator, step: float) -> Hollow | None:
    """A mantle with flats, grooves, ribs, scallops and beads, drawn in steps [rad]; None as in `turned`.

    A flat is wider than a step by far: one that is not cannot be told from it.
    """
    radius = math.exp(rng.uniform(math.log(8), math.log(80)))
    begins = np.radians(np.sort(rng.permutation(12)[: rng.integers(1, 6)]) * 30 + rng.uniform(0, 3))
    points: list[np.ndarray] = []
    sweeps: list[float] = []
    for begin, following in pairwise([*begins, begins[0] + 2 * math.pi]):
        width = math.radians(rng.uniform(3, 26))
        kinds = ["groove", "rib", "scallop", "bead", "flat", "flats"][: 4 + (width > 1.4 * step) + (width > 2.8 * step)]
        kind, depth = rng.choice(kinds), radius * rng.uniform(0.04, 0.25)
        ways = {
            "flat": [(0.0, radius, 0.0)],
            "flats": [(0.0, radius, 0.0), (width / 2, radius, 0.0)],
            "groove": [(0.0, radius, 0.0), (0.0, radius + depth, width), (width, radius + depth, 0.0)],
            "rib": [(0.0, radius, 0.0), (0.0, radius - depth, 0.0), (width, radius - depth, 0.0)],
            "scallop": [(0.0, radius, rng.uniform(1.3 * width, 2.8))],
            "bead": [(0.0, radius, -rng.uniform(0.1, 2.5))],
        }[kind]
        for angle, out, sweep in [*ways, (width, radius, following - begin - width)]:
            points.append(out * np.array([math.cos(begin + angle), math.sin(begin + angle)]))
            sweeps.append(sweep)
    pieces = chain(points, sweeps, closed=True)
    return _checked(Hollow("interrupted", pieces, radius * rng.uniform(0.5, 2)), rng)


def _checked(hollow: Hollow, rng: np.random.Generator) -> Hollow | None:
    """The hollow in a random place, or None where it crosses itself, or is too narrow, or a joint is a cusp."""
    lengths = [piece.length for piece in hollow.pieces]
    outline = shapely.Polygon(hollow.outline(0.05))
    inner = np.array([piece.start[0] for piece in hollow.pieces[1:]])
    turns = np.abs([turn for *_, turn in hollow.joints])
    if min(lengths) < 0.8 or turns.max(initial=0) > LARGEST_TURN or not outline.is_valid:
        return None
    if hollow.is_turned and (inner.min() < 3 or (hollow.outline(0.05)[1:-1, 0] <= 0).any()):
        return None
    # Walls that nearly meet would be a crack, and the hollow in two parts.
    eroded = outline.buffer(-0.4 if not hollow.is_turned else -0.2)
    if eroded.geom_type != "Polygon" or outline.exterior.length < 1 or shapely.count_coordinates(eroded) < 4:
        return None
    return hollow.placed(random_rotation(rng), rng.uniform(-40, 40, 3))


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A rotation (3, 3): along the axes for a third of them."""
    if rng.random() < 0.33:
        return np.eye(3)[:, np.roll([0, 1, 2], rng.integers(3))]
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])  # fmt: skip


def hollow_of(seed: int) -> Hollow:
    """The hollow of a seed: two of three are turned, one of fifty is a sphere."""
    rng = np.random.default_rng([seed, 1])
    if rng.random() < 0.02:
        return sphere(rng.uniform(8, 40)).placed(random_rotation(rng), rng.uniform(-40, 40, 3))
    make = turned if rng.random() < 2 / 3 else extruded
    while (hollow := make(rng)) is None:
        pass
    return hollow


# Meshes


def _steps(piece: Piece, facets: int) -> int:
    if not piece.sweep:
        return 1
    return max(FEWEST_STEPS, math.ceil(abs(piece.sweep) / min(LARGEST_STEP, 2 * math.pi / facets) - 1e-9))


def mesh(hollow: Hollow, facets: int, phase: float = 0.0) -> np.ndarray:
    """Corners (t, 3, 3) [mm] of triangles whose vertices are on the surface, normals out of the hollow."""
    rings = [piece.at(np.linspace(0, 1, _steps(piece, facets) + 1)[:-1]) for piece in hollow.pieces]
    line = np.concatenate([*rings, *([hollow.pieces[-1].end[None]] if hollow.is_turned else [])])
    local = _turned_mesh(line, facets, phase) if hollow.is_turned else _extruded_mesh(line, hollow.height)
    return hollow.to_space(local.reshape(-1, 3)).reshape(-1, 3, 3)


def _turned_mesh(line: np.ndarray, facets: int, phase: float) -> np.ndarray:
    angle = phase + 2 * np.pi * np.arange(facets) / facets
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = np.concatenate([line[:, None, :1] * around, np.broadcast_to(line[:, None, 1:], (len(line), facets, 1))], 2)
    a, b = rings[:-1], rings[1:]
    a2, b2 = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    # Up the mantle and left to right: the normal of (a, a2, b) points away from the axis.
    lower, upper = np.stack([a, a2, b2], axis=2), np.stack([a, b2, b], axis=2)
    return np.concatenate([lower[1:].reshape(-1, 3, 3), upper[:-1].reshape(-1, 3, 3)])


def _extruded_mesh(line: np.ndarray, height: float) -> np.ndarray:
    low, high = (np.column_stack([line, np.full(len(line), z)]) for z in (0.0, height))
    low2, high2 = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    sides = [np.stack([low, low2, high2], axis=1), np.stack([low, high2, high], axis=1)]
    cut = shapely.get_parts(shapely.constrained_delaunay_triangles(shapely.Polygon(line)))
    flat = np.array([triangle.exterior.coords[:3] for triangle in cut])
    first, second = flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]
    clockwise = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    flat[clockwise] = flat[clockwise, ::-1]
    lid = np.concatenate([flat, np.full((*flat.shape[:2], 1), height)], axis=2)
    floor = np.concatenate([flat[:, ::-1], np.zeros((*flat.shape[:2], 1))], axis=2)
    return np.concatenate([*sides, floor, lid])


def straightened(hollow: Hollow, facets: int, rounding: float) -> Hollow | None:
    """The other hollow that a file may draw: where two arcs join, and the steps on both sides of the joint lie on one
    line to within the rounding [mm], that line is a piece of its own. The arcs are contrary, or bent one way and joined
    by an edge of the other way. None where there is no such joint.

    The same where a line joins an arc whose first step goes on along it, since such facets are one. A mesh of `facets`
    draws both hollows: which one is meant, a file of that rounding does not say. Of an extruded arc with fewer than
    FEWEST_STEPS left, each is a side of a prism.
    """
    pieces, lines, is_other = list(hollow.pieces), {}, False

    def step(number: int) -> float:
        whole, left_of_it = hollow.pieces[number].sweep, pieces[number].sweep
        return whole / _steps(hollow.pieces[number], facets) / left_of_it if whole else 1.0

    for number, following, turn in hollow.joints:
        first, second = pieces[number], pieces[following]
        is_one_way = first.sweep * second.sweep > 0 and turn * first.sweep > -1e-9
        if is_one_way or not (first.sweep or second.sweep):
            continue
        left_out, begun = step(number), step(following)
        (begin,), (end,) = first.at(np.array([1 - left_out])), second.at(np.array([begun]))
        line = Piece(begin, end)
        # A line between the three places is off each by half of what the middle one is off the chord.
        if abs(left(line.along(0.5)) @ (first.end - begin)) < 2 * rounding:
            is_other = True
            pieces[number] = Piece(first.start, begin, first.sweep * (1 - left_out)) if first.sweep else line
            pieces[following] = Piece(end, second.end, second.sweep * (1 - begun)) if second.sweep else line
            if first.sweep and second.sweep:
                lines[number] = [line]
    made: list[Piece] = []
    for number, piece in enumerate(pieces):
        steps = round(1 / step(number))
        is_prism = piece.sweep and not hollow.is_turned and steps < FEWEST_STEPS
        sides = pairwise(piece.at(np.linspace(0, 1, steps + 1))) if is_prism else []
        made += [*([Piece(*ends) for ends in sides] or [piece]), *lines.get(number, [])]
    return replace(hollow, pieces=tuple(made)) if is_other else None


def write_stl(path: Path, triangles: np.ndarray, decimals: int | None) -> float:
    """Write triangles (t, 3, 3) [mm], as text of so many decimals or, for None, in binary; returns the rounding [mm].

    That is by how much a vertex may be off.
    """
    if decimals is None:
        rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", 9), ("count", "<u2")])
        rows["corners"] = triangles.reshape(-1, 9)
        path.write_bytes(b"hollow".ljust(80) + struct.pack("<I", len(triangles)) + rows.tobytes())
        return math.sqrt(3) * float(np.abs(triangles).max()) * 2.0**-24
    lines = ["solid hollow"]
    for corners in triangles.tolist():
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += [f"vertex {x:.{decimals}f} {y:.{decimals}f} {z:.{decimals}f}" for x, y, z in corners]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid hollow", ""]))
    return math.sqrt(3) * 0.5 * 10.0**-decimals
