"""Starting positions: a jittered hexagonal packing, turned and shifted by the seed, thinned to the number of balls.

Its planes are horizontal. If the balls do not fit that way, as in a slice of a drum that is little wider than a ball,
the planes are perpendicular to the vessel's thinnest direction, in its middle, and as many as fit.
"""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from millprint.config.errors import SimulationError
from millprint.config.sweep import ball_count
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import Vessel
from millprint.run.numbers import do_not_fit

# Number of packings tried for each orientation of the planes, before the balls are refused.
TRIALS = 24

# Neighbours start at least this fraction of a diameter apart.
GAP = 1e-3


# Points times facets that are checked together, to limit the memory in vessels with many facets.
CHUNK = 1 << 22


def inside(vessel: Vessel, points: np.ndarray, clearance: float, inserts: Sequence[Vessel] = ()) -> np.ndarray:
    """Which of `points` (n, 3) [m] lie inside the vessel, at least `clearance` [m] from every wall.

    inserts: solids in the vessel's frame (mill.bodies.inserts_in_vessel), which count as walls too.
    """
    if vessel.is_convex:
        fits = _inside_convex(vessel, points, clearance)
    else:
        # Only a vessel that is not convex needs the exact distance.
        fits = signed_distance(vessel)(points)[0] <= -clearance
    for insert in inserts:
        fits[fits] = signed_distance(insert)(points[fits])[0] <= -clearance
    return fits


def _inside_convex(vessel: Vessel, points: np.ndarray, clearance: float) -> np.ndarray:
    """Which points (n, 3) are on the inner side of every facet's plane, which is enough in a convex vessel."""
    rows = max(1, CHUNK // len(vessel.offsets))
    fits = np.empty(len(points), dtype=bool)
    for k in range(0, len(points), rows):
        fits[k : k + rows] = (points[k : k + rows] @ vessel.normals.T - vessel.offsets).min(axis=1) >= clearance
    return fits


# Distance of the planes of a close packing, over that of its sites.
PLANES = math.sqrt(2 / 3)


def _close_packed(half: np.ndarray, planes: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Sites (n, 3) of a hexagonal close packing about the origin, in units of the spacing, before they are turned.

    half: half the sizes (3,) of the box that they cover once they are turned; planes: the numbers (l,) of the planes
    one above the other; turn: rotation (3, 3) about the third axis; shift: (3,).
    """
    # Rows over the turned box in plan, two spacings more for stagger and shift, each through all planes.
    across = math.hypot(half[0], half[1])
    rows = (np.arange(-n, n + 1) for n in (math.ceil(across) + 2, math.ceil(across / math.sqrt(3 / 4)) + 2))
    i, j = (index.reshape(-1, 1) for index in np.meshgrid(*rows, indexing="ij"))
    plan = np.hstack([i + j % 2 / 2, math.sqrt(3) / 2 * j]) @ turn[:2, :2].T
    i, j = (index[(np.abs(plan) <= half[:2] + 2).all(axis=1)] for index in (i, j))
    x = i + ((j + planes) % 2) / 2
    y = math.sqrt(3) / 2 * (j + (planes % 2) / 3)
    z = PLANES * planes
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1).reshape(-1, 3) + shift


def _turn(angle: float) -> np.ndarray:
    return np.array([[math.cos(angle), -math.sin(angle), 0], [math.sin(angle), math.cos(angle), 0], [0, 0, 1]])


def lattice(vessel: Vessel, spacing: float, angle: float, shift: np.ndarray) -> np.ndarray:
    """Sites (n, 3) [m] of a hexagonal close packing of level planes over the vessel's bounding box.

    angle: turn about the vertical [rad]; shift: (3,) in units of the spacing.
    """
    low, high = vessel.bounds
    middle, half = (low + high) / 2, (high - low) / 2 / spacing
    layers = math.ceil(half[2] / PLANES) + 2
    turn = _turn(angle)
    return spacing * _close_packed(half, np.arange(-layers, layers + 1), turn, shift) @ turn.T + middle


def thin_direction(vessel: Vessel) -> np.ndarray:
    """The unit vector (3,) along which the vessel is thinnest: an axis of its frame, or across its largest facet."""
    directions = np.vstack([np.eye(3), vessel.normals[np.argmax(vessel.areas)]])
    # The facet counts only if it is perpendicular to no axis, and the vessel is thinner there by more than rounding.
    widths = np.ptp(vessel.vertices @ directions.T, axis=0) * [1, 1, 1, 1 + 1e-9]
    return directions[np.argmin(widths)]


def laid_lattice(vessel: Vessel, diameter: float, spacing: float, angle: float, shift: np.ndarray) -> np.ndarray:
    """Sites (n, 3) [m] of a hexagonal close packing whose planes lie across the vessel's thinnest direction.

    There are as many planes as balls of a diameter [m] have room for, in the middle of that direction.
    angle: turn about that direction [rad]; shift: (2,) within the planes, in units of the spacing.
    """
    normal = thin_direction(vessel)
    first = np.eye(3)[np.argmin(np.abs(normal))]
    first = np.cross(first, normal) / np.linalg.norm(np.cross(first, normal))
    frame = np.array([first, np.cross(normal, first), normal])
    ends = vessel.vertices @ frame.T
    low, high = ends.min(axis=0), ends.max(axis=0)
    room = high[2] - low[2] - diameter * (1 + GAP)
    planes = np.arange(math.floor(room / (PLANES * spacing) + 1e-9) + 1 if room >= 0 else 0)
    turn, upwards = _turn(angle), -PLANES * (len(planes) - 1) / 2
    sites = _close_packed((high - low) / 2 / spacing, planes, turn, np.array([*shift, upwards]))
    return (spacing * sites @ turn.T + (low + high) / 2) @ frame


def _sites(
    is_laid: bool, vessel: Vessel, diameter: float, spacing: float, rng: np.random.Generator, inserts: Sequence[Vessel]
) -> np.ndarray:
    """The sites (n, 3) [m] of a packing, level or laid, at which a ball has room; spacing: of the sites [m]."""
    angle = rng.uniform(0, math.pi / 3)
    if is_laid:
        points = laid_lattice(vessel, diameter, spacing, angle, rng.uniform(0, 1, 2))
    else:
        points = lattice(vessel, spacing, angle, rng.uniform(0, 1, 3))
    low, high = vessel.bounds + np.array([[diameter / 2], [-diameter / 2]])
    points = points[((points >= low) & (points <= high)).all(axis=1)]
    return points[inside(vessel, points, diameter / 2 * (1 + GAP), inserts)]


def capacity(vessel: Vessel, diameter_m: float, inserts: Sequence[Vessel] = (), enough: int | None = None) -> int:
    """How many balls of a diameter [m] the start can place: the best of some packings in both orientations.

    enough: the search stops at the first packing that holds this number.
    """
    most = 0
    for is_laid in (False, True):
        rng = np.random.default_rng(0)
        for _ in range(TRIALS):
            most = max(most, len(_sites(is_laid, vessel, diameter_m, diameter_m * (1 + GAP), rng, inserts)))
            if enough is not None and most >= enough:
                return most
    return most


def widest_ball(vessel: Vessel, inserts: Sequence[Vessel] = ()) -> float:
    """Diameter [m] of the largest ball that has room between the walls, by a search that gets finer.

    inserts: solids in the vessel's frame.
    """
    low, high = vessel.bounds
    pitch = (high - low) / 16
    points = low + (np.indices((15, 15, 15)).reshape(3, -1).T + 1) * pitch
    around = np.indices((3, 3, 3)).reshape(3, -1).T - 1
    while True:
        room = -np.max([signed_distance(body)(points)[0] for body in (vessel, *inserts)], axis=0)
        best = np.argsort(-room)[:12]
        if pitch.max() < 1e-5 * vessel.size:
            return 2 * float(room[best[0]])
        pitch = pitch / 2
        points = (points[best][:, None] + around * pitch).reshape(-1, 3)


def widest_in_mm(vessel: Vessel, inserts: Sequence[Vessel] = ()) -> str:
    """The diameter of `widest_ball` for a message, rounded down: "7.99 mm"."""
    return f"{math.floor(1e5 * widest_ball(vessel, inserts)) / 100:g} mm"


def room_in_words(
    vessel: Vessel, diameter_m: float, volume_m3: float, inserts: Sequence[Vessel] = (), most: int | None = None
) -> str:
    """Why balls of a diameter [m] could not be placed, and what to do.

    volume_m3: nominal, of the fill ratio; most: how many can be placed, `capacity` if left out.
    """
    most = capacity(vessel, diameter_m, inserts) if most is None else most
    if not most and diameter_m > widest_ball(vessel, inserts):
        return f"nowhere is room for a ball of {1e3 * diameter_m:g} mm; at most {widest_in_mm(vessel, inserts)}"
    if not most:
        return "the packing method, which starts with a lattice of balls, places none of them; take smaller balls"
    fill = math.floor(100 * most * math.pi / 6 * diameter_m**3 / volume_m3) / 100
    while ball_count(fill, volume_m3, diameter_m) > most:
        fill -= 0.01
    return (
        f"the packing method, which starts with a lattice of balls, places at most {most}, a fill ratio of {fill:.2f}; "
        "lower it, or take smaller balls"
    )


def cell_order(points: np.ndarray, pitch: float) -> np.ndarray:
    """The order (n,) of points (n, 3) [m] by the cells of a grid, `pitch` [m] wide, that they lie in.

    Balls whose numbers are near each other's then are near in space too, and in memory: that saves much of the
    time of a large charge, which is sorted again as it mixes (dem.neighbours).
    """
    cell = np.floor((points - points.min(axis=0)) / pitch).astype(int)
    return np.lexsort((cell[:, 2], cell[:, 1], cell[:, 0]))


def _tries(seed: int) -> Iterator[tuple[bool, np.random.Generator]]:
    """The packings that are tried for a start, one after another, whether laid and its draws: level ones first.

    After some packings of this seed come all packings that decide the capacity: charges within the capacity must fit.
    """
    for is_laid in (False, True):
        own, judged = np.random.default_rng(seed), np.random.default_rng(0)
        yield from [(is_laid, own)] * (TRIALS // 2) + [(is_laid, judged)] * TRIALS


def pack_mixture(
    vessel: Vessel, diameters_m: np.ndarray, counts: Sequence[int], seed: int, inserts: Sequence[Vessel] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Random centres (n, 3) [m] of balls of several sizes, and the size (n,) of each, its row in `diameters_m` (k,).

    counts: balls of each size. The largest are placed first, each size on a packing of its own around those already
    there: at random over the whole vessel or, where that leaves too little room for the rest, from below.
    Raises SimulationError if they do not fit.
    """
    for trial in range(TRIALS):
        for from_below in (False, True):
            placed = _place_sizes(
                vessel, diameters_m, counts, np.random.default_rng([seed, trial]), inserts, from_below
            )
            if placed is not None:
                points, species = placed
                # In the order of cells in space, as balls of one size.
                order = cell_order(points, float(np.max(diameters_m)))
                return points[order], species[order]
    sizes = ", ".join(f"{count} of {diameter * 1e3:g} mm" for count, diameter in zip(counts, diameters_m, strict=True))
    reason, largest = "the packing method cannot place them; lower the fill ratio", float(np.max(diameters_m))
    if largest > widest_ball(vessel, inserts):
        reason = f"nowhere is room for a ball of {1e3 * largest:g} mm; at most {widest_in_mm(vessel, inserts)}"
    raise SimulationError(f"{do_not_fit(sum(counts), f'({sizes})')} in the vessel: {reason}")


def _place_sizes(
    vessel: Vessel, diameters_m: np.ndarray, counts: Sequence[int], draw: np.random.Generator,
    inserts: Sequence[Vessel], from_below: bool,
) -> tuple[np.ndarray, np.ndarray] | None:  # fmt: skip
    """One try of `pack_mixture`; None if a size has no room."""
    points, radii, species = np.empty((0, 3)), np.empty(0), np.empty(0, dtype=np.int64)
    for size in np.argsort(diameters_m)[::-1]:
        diameter, count = float(diameters_m[size]), counts[size]
        for is_laid in (False, True):
            sites = _sites(is_laid, vessel, diameter, diameter * (1 + GAP), draw, inserts)
            # Balls of one size have one distance to keep.
            for radius in np.unique(radii):
                reach = (radius + diameter / 2) * (1 + GAP)
                # A third of a simulation's import time, and not needed for balls of one size.
                from scipy.spatial import cKDTree

                sites = sites[cKDTree(points[radii == radius]).query(sites, distance_upper_bound=reach)[0] >= reach]
            if len(sites) >= count:
                break
        else:
            return None
        order = np.argsort(sites[:, 2]) if from_below else draw.permutation(len(sites))
        points = np.concatenate([points, sites[order[:count]]])
        radii = np.append(radii, np.full(count, diameter / 2))
        species = np.append(species, np.full(count, size))
    return points, species


def _free_way(vessel: Vessel, normal: np.ndarray, diameter_m: float) -> float:
    """How far a ball of a laid packing may move to either side of its plane [m]: 0 where there is more than one plane.

    In a slice that is hardly wider than a ball, balls that all start in the middle would stay there, since no force
    points out of a plane that holds every centre: the charge would never touch the ends.
    """
    room = float(np.ptp(vessel.vertices @ normal)) - diameter_m * (1 + GAP)
    return 0.99 * room / 2 if 0 < room < PLANES * diameter_m * (1 + GAP) else 0.0


def pack(
    vessel: Vessel, diameter_m: float, count: int, seed: int, volume_m3: float, inserts: Sequence[Vessel] = ()
) -> np.ndarray:
    """Random centres (count, 3) [m] in the vessel's frame, no two closer than a diameter, none in a wall.

    inserts: solids in the vessel's frame (mill.bodies.inserts_in_vessel).
    The packing is as loose as holds that many sites, each ball then moves at random within its share of the gap.
    Raises SimulationError if they do not fit, with the reason.
    """
    for trial, (is_laid, rng) in enumerate(_tries(seed)):
        spacing = diameter_m * (1 + GAP)
        sites = _sites(is_laid, vessel, diameter_m, spacing, rng, inserts)
        if len(sites) < count:
            continue
        state = rng.bit_generator.state
        best = sites
        for wider in np.linspace(1.05, 2.0, 20):
            rng.bit_generator.state = state
            looser = _sites(is_laid, vessel, diameter_m, diameter_m * wider, rng, inserts)
            if len(looser) < count:
                break
            best, spacing = looser, diameter_m * wider
        draw = np.random.default_rng([seed, trial])
        chosen = best[draw.permutation(len(best))[:count]]
        room = (spacing - diameter_m) / 2 * 0.99
        move = draw.uniform(-1, 1, chosen.shape) * room / math.sqrt(3)
        if is_laid:
            normal = thin_direction(vessel)
            share = move @ normal / (room / math.sqrt(3))
            move += np.outer(share * _free_way(vessel, normal, diameter_m) - move @ normal, normal)
        moved = chosen + move
        fits = inside(vessel, moved, diameter_m / 2, inserts)
        placed = np.where(fits[:, None], moved, chosen)
        return placed[cell_order(placed, spacing)]
    reason = room_in_words(vessel, diameter_m, volume_m3, inserts)
    raise SimulationError(f"{do_not_fit(count, f'of {diameter_m * 1e3:g} mm')} in the vessel: {reason}")
