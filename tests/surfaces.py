"""What balls meet on random closed surfaces against closed forms: python -m tests.surfaces [--count N] [--seed S].

Each seed makes a hollow (`tests.profiles`), draws it as an STL file, has the library read it, and puts balls near its
wall. They must touch where the closed form says (`tests.closed_distances`), as deep, in that direction, and once for a
foot. Where a file of two decimals says too little of a round wall, which stays flat then, they must touch where the
triangles are. On every tenth surface balls hit the wall and slide along it without losses, and must keep their energy,
and the library's signed distance must be right. The command prints the seeds that fail, with profile and places, and
ends with 1 if there are any. One surface again, with hits whatever its number, drawn as in the slow test:

    python -m tests.surfaces --seed 4711 --count 1 --largest 24
"""

import argparse
import math
import os
import sys
import tempfile
from collections import Counter
from itertools import count as numbers
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from millprint.config.errors import ConfigError, SimulationError
from millprint.config.mill import MillConfig
from millprint.dem.layout import LANE, LANES
from millprint.dem.simulation import walls_for
from millprint.mill.bodies import build_bodies
from millprint.mill.distance import signed_distance
from millprint.mill.outlines import facets_of
from millprint.mill.vessel import Vessel, build_vessel
from tests.closed_distances import SMOOTH, Feet, distance_to_triangles, feet, nearest_on_triangles
from tests.physics.setups import CALIBRATED, FewBalls
from tests.profiles import LARGEST_STEP, Hollow, hollow_of, mesh, straightened, turned_by, write_stl

ELASTIC = CALIBRATED.model_copy(update={"restitution": 1.0, "static_friction": 0.0, "rolling_friction": 0.0})
# In a concave seam that turns by more, a ball has a contact with each side; in one that turns by less, a single one.
SHARP, UNSURE = math.acos(0.8), math.radians(2)
MM = 1e-3
# Decimals of files that may say too little of a round wall in a hollow of this size: it may stay flat.
SHORT = 2
# Facets a turn of the meshes that solids are compared with.
FINE = 120


class Case(NamedTuple):
    """A hollow as the library has it. tolerance: what distances may be off, from the rounding of the file [mm].

    triangles (t, 3, 3) [mm]: those that are rounded in the file, where a round wall stays flat; sagitta: how far these
    are from the hollow at most [mm].
    """

    hollow: Hollow
    vessel: Vessel
    tolerance: float
    words: str
    triangles: np.ndarray | None = None
    sagitta: float = 0.0


class Contacts(NamedTuple):
    """Contacts of balls that are put somewhere: the ball of each, its overlap [mm], its feature."""

    ball: np.ndarray
    overlap: np.ndarray
    feature: np.ndarray
    push: np.ndarray  # (balls, 3) unit vectors of the force on each ball; nan where there is none


def vessel_of(geometry: dict, solid: bool = False) -> Vessel:
    """The vessel of a geometry section, by the public way; or the solid of it, an insert of a box, with the box."""
    inserts = [{"name": "solid", "geometry": geometry}] if solid else []
    box = {"kind": "box", "x_mm": 600, "y_mm": 600, "z_mm": 600}
    mill = MillConfig(
        name="made", title="x", source="x", volume_ml=1, geometry=box if solid else geometry, inserts=inserts,
        motion={"kind": "rest"},
    )  # fmt: skip
    if not solid:
        return build_vessel(mill)
    outer, inner = (body.vessel for body in build_bodies(mill, 60.0))
    # Its floor is at z = 0.
    walls = facets_of([[loop - [0, 0, 0.3] for loop in facet.loops] for facet in outer.facets])
    return Vessel([*walls, *inner.facets], "made", curves=inner.curves,
                  on_curves=np.append(np.full(len(walls), -1), inner.facet_curves), report=inner.report)  # fmt: skip


def from_file(
    hollow: Hollow, facets: int, decimals: int | None, phase: float = 0.0, name: str = "made.stl", solid: bool = False
) -> Case:
    """A hollow by way of an STL file in the working directory, see profiles.write_stl. Raises ConfigError.

    solid: the body that fills it, for balls outside.
    """
    triangles = mesh(hollow, facets, phase)
    rounding = write_stl(Path(name), triangles, decimals)
    vessel = vessel_of({"kind": "stl", "path": name, "unit": "mm"}, solid)
    words = f"{facets} facets a turn, {'binary' if decimals is None else f'{decimals} decimals'}"
    case = Case(hollow, vessel, 3 * rounding + 1e-7, words)
    if decimals != SHORT or not has_flat_seams(vessel):
        return case
    return case._replace(triangles=triangles, sagitta=sagitta_of(hollow, facets), words=f"{words}, flat")


def has_flat_seams(vessel: Vessel) -> bool:
    """Whether flat facets meet at small angles, as those of a round wall that was not known do."""
    turn, sides = np.abs(vessel.edge_arrays.turn), vessel.facet_curves[vessel.edge_arrays.facets]
    return bool(((turn < 1.5 * LARGEST_STEP) & (sides < 0).all(axis=1)).any())


def sagitta_of(hollow: Hollow, facets: int) -> float:
    """How far a drawn hollow is from the exact one at most [mm]."""
    step = min(LARGEST_STEP, 2 * math.pi / facets)
    around = hollow.outline(0.05)[:, 0].max() * (1 - math.cos(math.pi / facets)) if hollow.is_turned else 0.0
    across = [piece.radius * (1 - math.cos(step / 2)) for piece in hollow.pieces if piece.sweep]
    return float(around + max(across, default=0.0))


def style_of(seed: int, largest: int = 192) -> tuple[int, int | None, float]:
    """How the hollow of a seed is drawn: facets a turn, decimals (None for a binary file), phase."""
    rng = np.random.default_rng([seed, 2])
    facets = round(24 * (largest / 24) ** (rng.random() ** 2))
    decimals = rng.choice([None, 2, 3, 4, 5, 6], p=[0.3, 0.1, 0.15, 0.15, 0.15, 0.15])
    return facets, decimals, rng.uniform(0, 6)


def radius_of(case: Case, rng: np.random.Generator) -> float:
    """Radius of a ball [mm]: from a bead to 90 % of the tightest rounding, and for every fourth larger than this."""
    low = max(0.1, 60 * case.tolerance)
    high = 0.9 * case.hollow.tightest if rng.random() < 0.75 else 0.7 * case.hollow.inscribed
    return low * (max(high, 1.5 * low) / low) ** rng.random()


def places(hollow: Hollow, radius: float, gaps: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Centres (n, 3) of balls [mm], most of them with a gap (n,) to the wall, negative for an overlap.

    Over pieces and in joints alike, however short they are.
    """
    count, pieces = len(gaps), hollow.pieces
    corners = [(pieces[after].start, pieces[before].along(1.0), turn) for before, after, turn in hollow.joints]
    corners += hollow.tips
    local = np.empty((count, 3))
    for k in range(count):
        if rng.random() < 0.65 or not corners:
            piece = pieces[rng.integers(len(pieces))]
            share = rng.random()
            (foot,), along = piece.at(np.array([share])), piece.along(share)
        else:
            foot, before, turn = corners[rng.integers(len(corners))]
            along = turned_by(before, turn * rng.random())
        at = foot + (radius + gaps[k]) * np.array([-along[1], along[0]])
        if hollow.is_turned:
            angle = rng.uniform(0, 2 * np.pi)
            local[k] = at[0] * math.cos(angle), at[0] * math.sin(angle), at[1]
        else:
            local[k] = *at, hollow.height * rng.random()
    points = hollow.to_space(local)
    # Away from walls that are nearer than the one it was put at: into seams and corners.
    for _ in range(6):
        found = feet(hollow, points)
        short = np.where(np.isfinite(found.nearest), np.maximum(radius + gaps - found.nearest, 0.0), 0.0)
        points = points + short[:, None] * found.towards
    found = feet(hollow, points)
    # In a tight corner a ball may still be pressed in.
    return points[found.inside & (found.nearest > (radius + gaps / 2 if gaps.min() > 0 else 0.9 * radius))]


def put(vessel: Vessel, points: np.ndarray, radius: float) -> Contacts:
    """The contacts of balls that are put at points (n, 3) [mm], each as if it were alone."""
    world = FewBalls(
        points * MM, radius=radius * MM, vessel=vessel, contact=ELASTIC, step=1e-12,
        walls=walls_for(vessel, radius * MM), friction=np.zeros((len(points), 2)),
    )  # fmt: skip
    world.run(1e-12)
    lanes = np.flatnonzero(world.open_contacts.slot >= 0)
    overlap = world.open_contacts.lanes[lanes // LANES, LANE.history.peak_overlap * LANES + lanes % LANES] / MM
    size = np.linalg.norm(world.balls.velocity, axis=1)
    push = world.balls.velocity / np.where(size > 0, size, np.nan)[:, None]
    return Contacts(world.open_contacts.ball[lanes], overlap, -1 - world.open_contacts.partner[lanes], push)


def bounds_of_count(hollow: Hollow, found: Feet, ball: int, reach: float) -> tuple[int, int]:
    """The fewest and the most contacts of a ball that has feet within reach [mm].

    Of feet on both sides of a shallow seam the nearer one is a contact. So a ball in a groove has two, where the arc at
    its bottom is farther away than both of its sides. Where further pieces lie between two feet, but no sharp seam, and
    their directions are within about a quarter of a turn, they may be one or two.
    """
    pieces, place = len(hollow.pieces), found.place
    near = np.flatnonzero(found.distance[ball] < reach)
    ends = int(np.isnan(place[near]).sum())
    along = sorted(near[~np.isnan(place[near])], key=lambda k: place[k])
    turns = {before: turn for before, _, turn in hollow.joints}
    # Beyond a tip on the axis.
    turns.setdefault(pieces - 1, -1.0)
    fewest, farther = len(along), set()
    pairs = [(a, b, place[b]) for a, b in pairwise(along)]
    if not hollow.is_turned and len(along) > 1:
        pairs.append((along[-1], along[0], place[along[0]] + pieces))
    for first, second, to in pairs:
        between = [turns[k % pieces] for k in range(math.floor(place[first]), math.ceil(to))]
        alike = found.direction[ball, first] @ found.direction[ball, second]
        if max(between) < SHARP + UNSURE and (len(between) == 1 or alike > -0.1):
            fewest -= 1
        if max(between) < SHARP - UNSURE and len(between) == 1:
            farther.add(max(first, second, key=lambda k: found.distance[ball, k]))
    least = int(len(along) > 0)
    return max(fewest, least) + ends, max(len(along) - len(farther), least) + ends


def hidden_turn(case: Case, distances: np.ndarray, places: np.ndarray) -> float:
    """The turn [rad] of a joint at the nearest foot of a point that the file's rounding may hide, or 0.

    There an arc leaves its tangent by less than the rounding, R (1 - cos turn): the walls may be tangent. Or the walls
    on both sides of a shallow joint are as near. distances: those of feet (k,) [mm]; places (k,): of them along the
    profile (tests.closed_distances).
    """
    pieces, place = case.hollow.pieces, places[distances.argmin()]
    near = places[distances < distances.min() + case.tolerance]
    hidden = 0.0
    for a, b, turn in case.hollow.joints:
        radii = [piece.radius for piece in (pieces[a], pieces[b]) if piece.sweep]
        is_tangent = bool(radii) and min(radii) * (1 - math.cos(turn)) < case.tolerance
        is_both = abs(turn) < SHARP and (near // 1 == a).any() and (near // 1 == b).any()
        if (is_tangent and (a <= place <= a + 1 or place == b)) or is_both:
            hidden = max(hidden, abs(turn))
    return hidden


def from_middles(hollow: Hollow, flat: np.ndarray, exact: Feet) -> np.ndarray:
    """How far points (n, 2) of the profile are from the middle of a hollow arc that may be nearest to them (n,) [mm].

    inf where there is none. The nearest foot of a point there may be on the walls that follow as well.
    """
    found = np.full(len(flat), math.inf)
    for piece in hollow.pieces:
        if piece.sweep > 0:
            away = np.linalg.norm(flat - piece.centre, axis=1)
            is_near = np.abs(piece.radius - exact.nearest) <= 2 * away
            found[is_near] = np.minimum(found, away)[is_near]
    return np.maximum(found, 1e-12)


def check_contacts(case: Case, radius: float, count: int, rng: np.random.Generator) -> list[str]:
    """What is wrong with contacts of balls of one radius [mm] near the wall, in words."""
    hollow, off = case.hollow, case.tolerance
    points = places(hollow, radius, radius * rng.uniform(-0.05, 0.03, count), rng)
    if not len(points):
        return []
    exact = feet(hollow, points)
    contacts = put(case.vessel, points, radius)
    drawn = None if case.triangles is None else distance_to_triangles(case.triangles, points)
    # Where a foot comes or goes within the tolerance, there may be a contact more or less.
    moved = [feet(hollow, points + 4 * off * shift) for shift in np.vstack([np.eye(3), -np.eye(3)])]
    local = (points - hollow.shift) @ hollow.rotation
    out = np.linalg.norm(local[:, :2], axis=1)
    from_axis = out if hollow.is_turned else np.full(len(points), math.inf)
    middles = from_middles(hollow, np.column_stack([out, local[:, 2]]) if hollow.is_turned else local[:, :2], exact)
    wrong = []
    for k in range(len(points)):
        overlaps = np.sort(contacts.overlap[contacts.ball == k])[::-1]
        depth = radius - exact.nearest[k]
        feet_here = [radius - each.distance[k] for each in (exact, *moved)]
        possible = np.concatenate(feet_here)
        # Two feet may come at once.
        bounds = [bounds_of_count(hollow, each, k, radius + reach) for each in (exact, *moved) for reach in (-off, off)]
        fewest, most = min(low for low, _ in bounds), max(high for _, high in bounds)
        said = ""
        if drawn is not None:
            # As deep as the triangles, or as the exact wall where that is known.
            most_deep = overlaps[0] if len(overlaps) else -math.inf
            depths = [each for each in (depth, radius - drawn[k]) if max(each, most_deep) > 2 * off]
            if len(depths) == 2 and min(abs(most_deep - each) for each in depths) > 2 * off:
                said = f"overlaps by {depths[1]:.6g} mm as it is drawn, not by {most_deep:.6g} mm"
        elif depth > off and not len(overlaps):
            said = f"overlaps by {depth:.3g} mm and touches nothing"
        elif depth < -off and len(overlaps):
            said = f"is clear by {-depth:.3g} mm and touches as by {overlaps[0]:.3g} mm"
        elif depth > off and abs(overlaps[0] - depth) > off + 1e-6 * radius:
            said = f"overlaps by {depth:.6g} mm, not by {overlaps[0]:.6g} mm"
        elif len(overlaps) and max(np.abs(possible - each).min() for each in overlaps) > 6 * off + 1e-6 * radius:
            said = f"has an overlap too many: {overlaps} mm for {np.sort(feet_here[0][feet_here[0] > 0])[::-1]} mm"
        elif not fewest <= len(overlaps) <= most + (middles[k] < 2 * off):
            said = f"has {len(overlaps)} contacts, not {fewest} to {most}"
        elif depth > off and len(overlaps) == most == 1:
            # In a shallow seam both walls may be as near.
            angle = min(float(np.linalg.norm(contacts.push[k] - each.towards[k])) for each in (exact, *moved))
            # On its axis a turned wall is as near all around.
            allowed = 1e-3 + 20 * off / radius + off / from_axis[k] + hidden_turn(case, exact.distance[k], exact.place)
            # And near the middle of an arc, as the profile is all along this.
            allowed += off / middles[k]
            if not angle < allowed:
                said = f"is pushed {math.degrees(angle):.3g} degrees off"
        if said:
            wrong.append(f"ball of {radius:.4g} mm at {np.round(points[k], 5).tolist()} mm {said}")
    return wrong


def keeps_energy_in(hollow: Hollow, radius: float) -> bool:
    """Whether hits of a few per cent of the radius are elastic in any case.

    In a rounding that is hardly tighter than the ball, a foot may leave its wall while another is pressed deeper.
    """
    arcs = [piece for piece in hollow.pieces if piece.sweep > SHARP]
    return all(p.radius > radius or (radius - p.radius) * (1 - math.cos(p.sweep)) > 0.06 * radius for p in arcs)


def check_hits(case: Case, radius: float, count: int, rng: np.random.Generator, fine: int = 2000) -> list[str]:
    """Which balls of one radius [mm] change their energy in elastic hits without friction, or pass the wall, in words.

    fine: steps in a tenth of the time in which a ball goes its radius; a contact takes about half as long. A step in
    the wall as high as the tolerance may change the energy of a ball that is pressed in by 2 % of its radius (Hertz).
    """
    hollow = case.hollow
    if not keeps_energy_in(hollow, radius):
        return []
    points = places(hollow, radius, np.full(count, 0.005 * radius + 2 * case.tolerance + case.sagitta), rng)
    if not len(points):
        return []
    normal = feet(hollow, points).towards
    sideways = np.cross(normal, rng.normal(size=normal.shape))
    sideways /= np.linalg.norm(sideways, axis=1)[:, None]
    lean = np.radians(rng.uniform(0, 80, len(points)))[:, None]
    velocity = -np.cos(lean) * normal + np.sin(lean) * sideways
    unit, wrong = 0.1 * radius * MM, []
    # What is left at a hundredth of the step is made by the walls: where a pressed ball passes from one side of a seam
    # to the other, the error grows with the step.
    for steps in (fine, 10 * fine, 100 * fine):
        world = FewBalls(
            points * MM, velocity, radius=radius * MM, vessel=case.vessel, contact=ELASTIC, step=unit / steps,
            walls=walls_for(case.vessel, radius * MM), friction=np.zeros((len(points), 2)), skin=0.1 * radius * MM,
        )  # fmt: skip
        try:
            world.run(2 * unit)
        except SimulationError as error:
            return [f"balls of {radius:.4g} mm: {error}"]
        free = np.ones(len(points), dtype=bool)
        free[world.open_contacts.ball[world.open_contacts.slot >= 0]] = False
        gain = (world.balls.velocity**2).sum(axis=1) - 1
        allowed = 1e-6 + 2.5 * case.tolerance / (0.02 * radius)
        end = feet(hollow, world.balls.position / MM)
        untouched = free & ~(end.inside & (end.nearest > 0.999 * radius - case.tolerance - case.sagitta))
        wrong = [
            f"ball of {radius:.4g} mm at {np.round(points[k], 5).tolist()} mm, velocity"
            f" {np.round(velocity[k], 5).tolist()} m/s,"
            f" {'is in the wall' if untouched[k] else f'has {1 + gain[k]:.7g} of its energy'} after the hit"
            for k in np.flatnonzero(free & (np.abs(gain) > allowed) | untouched)
        ]
        if not wrong:
            break
    return wrong


def check_slides(case: Case, radius: float, count: int, rng: np.random.Generator) -> list[str]:
    """Whether balls of one radius [mm] that are pressed along the wall by a weight make energy, in words.

    Without losses and friction they go twenty radii, over joints and hollows, as hops or in contact. Where a contact
    goes on to another wall, the force turns at once, and each time the step makes an error that falls with it: what
    such a slide gains at a tenth of the step is made by the walls.
    """
    if not keeps_energy_in(case.hollow, radius):
        return []
    points = places(case.hollow, radius, np.full(count, 1e-3 * radius + 2 * case.tolerance + case.sagitta), rng)
    if not len(points):
        return []
    normal = feet(case.hollow, points).towards
    velocity = np.cross(normal, rng.normal(size=normal.shape))
    velocity /= np.linalg.norm(velocity, axis=1)[:, None]
    unit, gain = radius * MM, 0.0
    for fine in (4000, 40000):
        world = FewBalls(
            points * MM, velocity, radius=unit, vessel=case.vessel, contact=ELASTIC, step=unit / fine, skin=0.1 * unit,
            walls=walls_for(case.vessel, unit), friction=np.zeros((len(points), 2)), gravity=-normal[0] * 0.2 / unit,
        )  # fmt: skip
        series = world.run(20 * unit, sample_every=fine)
        gain = np.abs(series["imbalance_J"]).max() / series["kinetic_J"].iloc[0] * len(points)
        # Over joints many times, and by the error of the step.
        if gain < 5e-4 + 50 * case.tolerance / (0.02 * radius):
            return []
    return [f"of {len(points)} balls of {radius:.4g} mm that slide, one gains or loses {gain:.3g} of its energy"]


def check_solid(case: Case, radius: float, count: int, rng: np.random.Generator) -> list[str]:
    """What is wrong with contacts of balls of one radius [mm] outside of a solid of the hollow's shape, in words.

    Compared with the nearest of the triangles of a fine mesh, whose chords are off the arcs.
    """
    triangles = mesh(case.hollow, FINE)
    radii = [np.ptp(triangles, axis=(0, 1)).max(), *(piece.radius for piece in case.hollow.pieces if piece.sweep)]
    off = case.tolerance + 1.5 * float(max(radii)) * (1 - math.cos(math.pi / FINE))
    chosen = triangles[rng.integers(len(triangles), size=count)]
    normal = np.cross(chosen[:, 1] - chosen[:, 0], chosen[:, 2] - chosen[:, 0])
    tilt = 0.5 * rng.normal(size=(count, 3)) * rng.integers(2, size=(count, 1))
    lean = normal / np.linalg.norm(normal, axis=1)[:, None] + tilt
    foot = (rng.dirichlet([1, 1, 1], count)[..., None] * chosen).sum(axis=1)
    reach = radius * (1 + rng.uniform(-0.05, 0.03, count))
    points = foot + reach[:, None] * lean / np.linalg.norm(lean, axis=1)[:, None]
    # Away from walls that are nearer than the one it was put at.
    for _ in range(3):
        nearest, winding = nearest_on_triangles(triangles, points)
        away = (points - nearest) * np.where(winding < 0.5, 1, -1)[:, None]
        distance = np.linalg.norm(away, axis=1)
        step = np.where(winding < 0.5, np.maximum(reach - distance, 0.0), reach + distance)
        points = points + (step / distance)[:, None] * away
    nearest, winding = nearest_on_triangles(triangles, points)
    depth = radius - np.linalg.norm(points - nearest, axis=1)
    # In a tight corner a ball may still be pressed in.
    kept = (winding < 0.5) & (depth < 0.1 * radius)
    points, depth = points[kept], depth[kept]
    contacts = put(case.vessel, points, radius)
    wrong = []
    for k in range(len(points)):
        overlap = contacts.overlap[contacts.ball == k].max(initial=-math.inf)
        if (depth[k] > off or overlap > off) and abs(overlap - depth[k]) > off:
            said = f"overlaps by {depth[k]:.4g} mm, not by {overlap:.4g} mm"
            wrong.append(f"ball of {radius:.4g} mm at {np.round(points[k], 5).tolist()} mm {said}")
    return wrong


def check_distance(case: Case, count: int, rng: np.random.Generator) -> list[str]:
    """Where the library's signed distance is not that of the closed form, in words; outside only its sign is known."""
    points = rng.uniform(*(case.vessel.bounds / MM), (count, 3))
    exact, found = feet(case.hollow, points), -signed_distance(case.vessel)(points * MM)[0] / MM
    error = np.where(exact.inside, np.abs(found - np.where(exact.inside, exact.nearest, 0.0)), found)
    return [
        f"the distance at {np.round(points[k], 5).tolist()} mm is {found[k]:.6g} mm, not "
        + (f"{exact.nearest[k]:.6g} mm" if exact.inside[k] else "negative")
        for k in np.flatnonzero(error > case.tolerance + case.sagitta)
    ]


def check(seed: int, places_each: int = 20, shots: int = 0, largest: int = 192, balls: int = 2) -> list[str]:
    """What is wrong with the surface of a seed for balls of some sizes; hits and distances only with `shots`.

    Where the file draws another hollow as well (`profiles.straightened`), nothing is if all is right for that one. No
    drawing is taken for more exact than a millionth of its size.
    """
    facets, *style = style_of(seed, largest)
    try:
        case = from_file(hollow_of(seed), facets, *style)
    except ConfigError as error:
        return [f"refused: {error}"]
    wrong = check_case(case, seed, places_each, shots, balls)
    size = 1e-6 * float(np.ptp(case.vessel.bounds, axis=0).max()) / MM
    other = straightened(case.hollow, facets, max(case.tolerance / 3, size))
    if wrong and other:
        return wrong if check_case(case._replace(hollow=other), seed, places_each, shots, balls) else []
    return wrong


def check_case(case: Case, seed: int, places_each: int, shots: int, balls: int) -> list[str]:
    """What is wrong with a surface, see `check`."""
    rng, rng_of_shots = np.random.default_rng([seed, 3]), np.random.default_rng([seed, 4])
    wrong = check_distance(case, places_each, rng_of_shots) if shots else []
    for _ in range(balls):
        radius = radius_of(case, rng)
        try:
            wrong += check_contacts(case, radius, places_each, rng)
            if shots:
                wrong += check_hits(case, radius, shots, rng_of_shots)
                wrong += check_slides(case, radius, 8, rng_of_shots)
        except SimulationError as error:
            wrong.append(f"balls of {radius:.4g} mm: {error}")
    return [f"{case.words}: {each}" for each in wrong]


def small(count: int, largest: int = 400) -> list[int]:
    """The first seeds whose surface has at most so many triangles where it is drawn with 24 facets a turn."""
    return list(islice((seed for seed in numbers() if len(mesh(hollow_of(seed), 24)) <= largest), count))


def kinds_of(hollow: Hollow, decimals: int | None) -> list[str]:
    """What a hollow has, and how it is drawn, for the table of the command."""
    turns = [turn for *_, turn in hollow.joints]
    lines = [p for p in hollow.pieces if not p.sweep and hollow.is_turned]
    has = {
        "turned": hollow.is_turned, "extruded": not hollow.is_turned,
        "cone": any(abs(p.chord[0]) > 1e-9 and abs(p.chord[1]) > 1e-9 for p in lines),
        "hollow arc": any(p.sweep > 0 for p in hollow.pieces), "belly": any(p.sweep < 0 for p in hollow.pieces),
        "rim under 37 deg": any(-SHARP < turn < -SMOOTH for turn in turns),
        "rim over 37 deg": any(turn < -SHARP for turn in turns),
        "seam under 37 deg": any(SMOOTH < turn < SHARP for turn in turns),
    }  # fmt: skip
    return [*(kind for kind, there in has.items() if there), f"{decimals} decimals" if decimals else "binary"]


def main() -> int:
    """Check surfaces and print what fails."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000, help="number of surfaces")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--largest", type=int, default=192, help="the most facets a turn")
    parser.add_argument("--places", type=int, default=20, help="places for each of two balls")
    parser.add_argument("--shots", type=int, default=20, help="hits on every tenth surface")
    arguments = parser.parse_args()
    every, bad, seen = Counter(), Counter(), []
    os.chdir(tempfile.mkdtemp())
    # Products of a few rows are no work for threads, which wait for each other.
    threadpool_limits(1)
    for done, seed in enumerate(range(arguments.seed, arguments.seed + arguments.count), 1):
        hollow = hollow_of(seed)
        shots = arguments.shots if seed % 10 == 0 or arguments.count == 1 else 0
        wrong = check(seed, arguments.places, shots, arguments.largest)
        every.update(kinds := kinds_of(hollow, style_of(seed)[1]))
        if wrong:
            bad.update(kinds)
            seen.append(seed)
            print(f"\nseed {seed}: {hollow.describe()}\n  " + "\n  ".join(wrong[:5]), flush=True)
        print(f"\r{done} of {arguments.count} surfaces, {len(seen)} fail", end="", file=sys.stderr, flush=True)
    print(f"\n{len(seen)} of {arguments.count} surfaces fail" + (f": seeds {seen}" if seen else ""))
    for kind in sorted(every):
        print(f"  {kind}: {bad[kind]} of {every[kind]}")
    return 1 if seen else 0


if __name__ == "__main__":
    sys.exit(main())
