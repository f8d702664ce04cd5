"""The bodies of a mill: its vessel first, then solid inserts, each with a shape and a motion."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig, StlGeometry
from millprint.mill.distance import signed_distance
from millprint.mill.motion import Motion, motion_from_law
from millprint.mill.outlines import Outlines
from millprint.mill.shapes import SHAPES
from millprint.mill.vessel import Vessel, build_vessel, shape_vessel

# Poses at which the inserts are checked for a turn of the fastest body.
ANGLES = 72
# Samples along an edge in that check: a body may cross another without a vertex inside it.
EDGE_SAMPLES = 9
# Inserts that move together may overlap by this share of the vessel's size; other bodies must be apart by as much.
TOUCH = 1e-6
# Cells along each axis of the grid by which the part of an insert within the vessel is measured.
CELLS = 64
# Most poses that the check tries, for bodies whose speeds differ much.
POSES_MAX = 2000
# A file is the wall of a cup if what its convex hull has in addition is at least this share of the hull, or the volume
# that is wanted, has walls around it in most directions, and is open to one side: the directions without a wall have a
# mean of at least this length [-].
CUP_SHARE, CUP_WALLED, CUP_OPEN = 0.2, 0.6, 0.5
CUP_RAYS, CUP_ALIKE = 100, 0.05


@dataclass(frozen=True)
class Body:
    """A rigid body whose walls the balls touch: a vessel, or with `vessel.solid` a body inside it."""

    name: str
    vessel: Vessel
    motion: Motion

    def to_laboratory(self, points: np.ndarray, time_s: float) -> np.ndarray:
        """Points (n, 3) [m] of the body frame in the laboratory frame at a time [s]."""
        return points @ self.motion.rotation(time_s).T + self.motion.position(time_s)

    def to_body(self, points: np.ndarray, time_s: float) -> np.ndarray:
        """Points (n, 3) [m] of the laboratory frame in the body frame at a time [s]."""
        return (points - self.motion.position(time_s)) @ self.motion.rotation(time_s)


def build_bodies(mill: MillConfig, speed_hz: float = 1.0) -> list[Body]:
    """The vessel of a mill and its inserts, moving at a speed [Hz]. Raises ConfigError for a refused shape.

    An insert without a motion of its own moves with the vessel, and has the same object as its motion.
    """
    motion = motion_from_law(mill.motion, speed_hz)
    bodies = [Body("vessel", build_vessel(mill), motion)]
    for index, insert in enumerate(mill.inserts):
        place = f"{_place(mill)}: inserts.{index}.geometry"
        solid = shape_vessel(insert.geometry, place, solid=True)
        law = insert.motion or mill.motion
        own = motion if law == mill.motion else motion_from_law(law, speed_hz)
        bodies.append(Body(insert.name, solid, own))
    return bodies


def check_volume(mill: MillConfig, vessel: Vessel) -> None:
    """Raise ConfigError where `volume_ml` is not the volume of the mill's vessel within `volume_tolerance`.

    Inserts are not taken off, as fill ratios refer to the vessel without them. A file with the wall of a cup in place
    of its hollow is named as that, also where the volume is that of the wall.
    """
    volume, shape, sizes = vessel.volume_m3 * 1e6, *mill.geometry.origin()
    if SHAPES[mill.geometry.kind].is_mesh and (hollow := cup_volume(vessel, mill.volume_ml * 1e-6)):
        raise ConfigError(
            f"{vessel.name}: {shape} is the wall of a cup, {volume:.4g} mL, open at one side; give its hollow, about "
            f"{hollow * 1e6:.4g} mL, closed by the lid (what stands in a hollow is one of `inserts`)"
        )
    if abs(volume - mill.volume_ml) > mill.volume_tolerance * volume:
        if isinstance(mill.geometry, StlGeometry) and (unit := mill.geometry.unit_of_volume(mill.volume_ml / volume)):
            sizes = f"write unit: {unit} in geometry"
        raise ConfigError(
            f"{_place(mill)}: volume_ml = {mill.volume_ml:g}: {shape} holds {volume:.4g} mL; correct it, or {sizes}, "
            "or allow the difference by volume_tolerance"
        )


def cup_volume(vessel: Vessel, wanted_m3: float) -> float:
    """The volume [m3] in the cup whose wall a surface encloses, by its convex hull; 0 for any other surface."""
    # Takes long to import, and few mills need it.
    import trimesh

    points, triangles = vessel.triangles()
    mesh = trimesh.Trimesh(points, triangles[:, ::-1], process=False)
    hull = mesh.convex_hull
    volume = hull.volume - mesh.volume
    if volume < CUP_SHARE * hull.volume and not math.isclose(volume, wanted_m3, rel_tol=CUP_ALIKE):
        return 0.0
    middle = (hull.volume * hull.center_mass - mesh.volume * mesh.center_mass) / volume
    # Directions evenly over the sphere, on a spiral.
    height = 1 - (2 * np.arange(CUP_RAYS) + 1) / CUP_RAYS
    angle = np.pi * (1 + 5**0.5) * np.arange(CUP_RAYS)
    level = np.sqrt(1 - height**2)
    rays = np.column_stack([level * np.cos(angle), level * np.sin(angle), height])
    # A ray passes through a triangle if it is on the inner side of the planes through the middle and each side.
    corners = mesh.triangles - middle
    sides = np.cross(corners, np.roll(corners, -1, axis=1))
    sides *= np.sign((sides[:, 0] * corners[:, 2]).sum(axis=1))[:, None, None]
    crossings = np.array([(sides @ ray > 0).all(axis=1).sum() for ray in rays])
    free = rays[crossings == 0]
    is_outside = (crossings % 2 == 0).mean() > 0.5
    is_walled = len(free) < (1 - CUP_WALLED) * CUP_RAYS
    is_open = len(free) > 0 and np.linalg.norm(free.mean(axis=0)) > CUP_OPEN
    return volume if is_outside and is_walled and is_open else 0.0


def _place(mill: MillConfig) -> str:
    return f"config/mills/{mill.name}.yaml"


def ball_space_m3(bodies: Sequence[Body]) -> float:
    """Volume that the balls can fill [m3]: the vessel less the inserts, of which a part may stand in its wall."""
    vessel = bodies[0].vessel
    return vessel.volume_m3 - sum(
        volume_within(vessel, body.vessel) if body.motion is bodies[0].motion else -body.vessel.volume_m3
        for body in bodies[1:]
    )


@lru_cache(maxsize=32)
def volume_within(vessel: Vessel, solid: Vessel) -> float:
    """Volume [m3] of the part of a solid that is in a vessel; both in one frame.

    All of it for a solid that nowhere reaches into the wall. Otherwise from a grid over the part of the solid's box in
    the vessel's: a cell counts by how far its middle is within both, so that the error goes with the cells' area.
    """
    if signed_distance(vessel)(_samples(solid))[0].max() <= TOUCH * vessel.size:
        return -solid.volume_m3
    low = np.maximum(vessel.bounds[0], solid.bounds[0])
    sides = np.minimum(vessel.bounds[1], solid.bounds[1]) - low
    if sides.min() <= 0:
        return 0.0
    cell = sides / CELLS
    middles = (np.indices([CELLS] * 3).reshape(3, -1).T + 0.5) * cell + low
    # Balls are inside a vessel and outside a solid: the sign of the distance to a solid is the other way round.
    distance, slope = signed_distance(vessel)(middles)
    of_solid, solid_slope = signed_distance(solid)(middles)
    outside, slope = np.maximum(distance, -of_solid), np.where((distance > -of_solid)[:, None], slope, solid_slope)
    width = np.abs(slope) @ cell
    return float(np.clip(0.5 - outside / width, 0, 1).sum() * cell.prod())


def travel_m(bodies: Sequence[Body]) -> float:
    """Half of the longest distance along one axis that a point of a wall covers in a turn of the mill [m].

    It is the amplitude A of a translation on a circle, the radius of a drum, and the reach of a stirrer's blades.
    """
    speed_hz = max(body.motion.frequency_hz for body in bodies)
    times = np.linspace(0, 1 / speed_hz, 361) if speed_hz else np.zeros(1)
    largest = 0.0
    for body in bodies:
        if body is not bodies[0] and body.motion is bodies[0].motion:
            # What moves with the vessel is in it, but for what stands in its wall.
            continue
        points = body.vessel.vertices
        path = np.einsum("tij,pj->tpi", body.motion.rotation(times), points) + body.motion.position(times)[:, None]
        largest = max(largest, float(np.ptp(path, axis=0).max()) / 2)
    return largest


def inserts_in_vessel(bodies: Sequence[Body]) -> list[Vessel]:
    """The inserts as solids in the vessel's frame, where they are at the start."""
    vessel, zero = bodies[0], np.zeros((1, 3))
    placed = []
    for body in bodies[1:]:
        outlines = body.vessel.outlines
        points = vessel.to_body(body.to_laboratory(outlines.points, 0.0), 0.0)
        facets = Outlines(points, outlines.loops, outlines.facets)
        rotation, shift = (vessel.to_body(body.to_laboratory(points, 0.0), 0.0) for points in (np.eye(3), zero))
        curves = [curve.moved((rotation - shift).T, shift[0]) for curve in body.vessel.curves]
        placed.append(Vessel(facets, body.vessel.name, solid=True, curves=curves))
    return placed


def _check_times(mill: MillConfig) -> np.ndarray:
    """Times [s] at one turn a second within which every body passes through all its positions."""
    laws = [mill.motion, *(insert.motion for insert in mill.inserts if insert.motion is not None)]
    own_turns = [law.drive().own_turns for law in laws]
    turns = max(1.0, *(1 / ratio for ratio in own_turns))
    count = min(POSES_MAX, int(np.ceil(ANGLES * turns * max(1.0, *own_turns))))
    return np.arange(count) / count * turns


def _samples(vessel: Vessel) -> np.ndarray:
    """Points (n, 3) [m] on the edges of a body, its vertices among them."""
    along = np.linspace(0, 1, EDGE_SAMPLES)[:, None, None]
    start, end = vessel.edge_arrays.start, vessel.edge_arrays.end
    return np.unique((start + along * (end - start)).reshape(-1, 3), axis=0)


def check_inserts(mill: MillConfig, bodies: Sequence[Body]) -> None:
    """Raise ConfigError where an insert leaves the vessel or meets a wall at any time of a turn of the mill.

    bodies: those of the mill at one turn a second. Points on the edges of each body are checked against every other
    body. Inserts that move together may touch, and one that moves with the vessel may stand in its wall.
    """
    laws = {"vessel": mill.motion, **{insert.name: insert.motion or mill.motion for insert in mill.inserts}}
    times = _check_times(mill)
    for body, other in itertools.permutations(bodies, 2):
        together = laws[body.name] == laws[other.name]
        if together and bodies[0] in (body, other):
            continue
        # The distance is negative where balls can be, and so it must be at the points of another body.
        allowed = (TOUCH if together else -TOUCH) * bodies[0].vessel.size
        met = _first_meeting(body, other, times[:1] if together else times, allowed)
        if met:
            turns, at = met
            first, second = (other, body) if body is bodies[0] else (body, other)
            when = "" if together else f" after {turns:.3g} turns"
            raise ConfigError(
                f"{_place(mill)}: inserts: {first.name} meets {second.name} at "
                f"({at[0] * 1e3:.4g}, {at[1] * 1e3:.4g}, {at[2] * 1e3:.4g}) mm{when}; {_remedy(body, other, bodies[0])}"
            )
    _check_inside(mill, bodies)


def _remedy(body: Body, other: Body, vessel: Body) -> str:
    if vessel in (body, other):
        return (
            "an insert with a motion of its own must stay clear of the vessel throughout; one that is fixed to the "
            "vessel, as a lifter or a baffle, has no `motion`, and may stand in its wall"
        )
    return "inserts must stay clear of each other throughout; two that are one piece belong into one closed surface"


def _check_inside(mill: MillConfig, bodies: Sequence[Body]) -> None:
    """Raise ConfigError for an insert that moves with the vessel and is not in it, or fills it."""
    vessel = bodies[0]
    for body in bodies[1:]:
        if body.motion is vessel.motion and volume_within(vessel.vessel, body.vessel) < TOUCH * vessel.vessel.volume_m3:
            raise ConfigError(
                f"{_place(mill)}: inserts: {body.name} lies outside the hollow of the vessel; correct its place or unit"
            )
    if (space := ball_space_m3(bodies)) < TOUCH * vessel.vessel.volume_m3:
        raise ConfigError(f"{_place(mill)}: inserts: they leave {space * 1e6:.3g} mL of the vessel to the balls")


def _first_meeting(body: Body, other: Body, times: np.ndarray, allowed: float) -> tuple[float, np.ndarray] | None:
    """The first of some times [s] at which a point of `body` is deeper than `allowed` in `other`, and the point.

    A distance changes by no more than its point moves, so it is computed again only where that could matter.
    """
    points, distance_of = _samples(body.vessel), signed_distance(other.vessel)
    seen, distance = np.zeros_like(points), np.full(len(points), np.inf)
    for time_s in times:
        placed = body.to_laboratory(points, time_s)
        now = other.to_body(placed, time_s)
        stale = distance + np.linalg.norm(now - seen, axis=1) > allowed
        seen[stale], distance[stale] = now[stale], distance_of(now[stale])[0]
        if distance.max() > allowed:
            return float(time_s), placed[np.argmax(distance)]
    return None
