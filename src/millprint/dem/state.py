"""The state of a simulation as groups of flat arrays, which kernels take and change in place."""

import math
from typing import NamedTuple

import numpy as np

from millprint.config.contact_set import ContactConfig
from millprint.dem.law import IDLE, IDLE_PRESENT, SpeedTables, at_reference, law_row, speed_tables
from millprint.dem.layout import CELL, COUNTER, GROUP, HISTORY_WIDTH, LANES, LOAD_WIDTH, STATUS
from millprint.mill.gravity import GRAVITY
from millprint.mill.kernel_columns import width_of
from millprint.mill.motion import Motion, Motions, stack_motions
from millprint.run.cache_lines import aligned

# The most rows of an array that begins with a cache line.
LINED_ROWS = 10_000


class Balls(NamedTuple):
    """State of the balls; velocities are those of half a step ago, `..._now` those expected at the present position."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    velocity_now: np.ndarray  # (n, 3)
    force: np.ndarray  # (n, 3) of contacts [N]
    angular_velocity: np.ndarray  # (n, 3) [rad/s]
    angular_velocity_now: np.ndarray  # (n, 3)
    torque: np.ndarray  # (n, 3) of contacts [N m]
    species: np.ndarray  # (n,) row of the tables below
    radius: np.ndarray  # (species,) [m]
    mass: np.ndarray  # (species,) [kg]
    inertia: np.ndarray  # (species,) [kg m2]
    touching: np.ndarray  # (n,) open contacts, as they were last counted


# Fields of Balls with a row of three numbers for each ball: what changes in a run.
MOVING = Balls._fields[:7]


class Candidates(NamedTuple):
    """What may touch before a ball has moved by half the skin: all pairs of balls, then all balls with each body."""

    first: np.ndarray  # (n + 1,) pairs of ball i with balls of higher numbers are first[i] to first[i + 1]
    first_wall: np.ndarray  # (bodies, n + 1) and with features of body b first_wall[b, i] to first_wall[b, i + 1]
    ball: np.ndarray  # (s,)
    partner: np.ndarray  # (s,) a ball, or -1 - feature
    plane: np.ndarray  # (s, 4) walls.bounding_plane of a feature
    sure: np.ndarray  # (s,) 1 where the foot is surely on the facet
    lane: np.ndarray  # (s,) the contact's lane, or -1
    trigger: np.ndarray  # (s,) (squared) distance below which a contact opens [m2, wall: m]; negative while open
    # Of those that are closed, the ones that may come within reach before the next search (dem.neighbours): pairs from
    # the first place on, features of body b from place first_wall[b, 0] on.
    near: np.ndarray  # (s + 1,)
    near_end: np.ndarray  # (bodies + 1,) the places where those of each body end, and where pairs end
    stride: np.ndarray  # (bodies,) the farthest that a ball may go in a step, as seen from a body [m]
    found: np.ndarray  # (s + 1,) those that have come within reach in the present step
    anchor: np.ndarray  # (bodies, n, 3) positions in each body's frame when the lists were made [m]
    cell_place: np.ndarray  # (n, 4) layout.CellColumns
    cell_first: np.ndarray  # (cells + 1,) where a cell's members begin
    cell_member: np.ndarray  # (n,)


class Contacts(NamedTuple):
    """Open contacts. Each keeps its lane, and in it its history, until the lists are rebuilt."""

    lanes: np.ndarray  # (blocks, width * LANES) layout.LaneColumns, see dem.law
    present: np.ndarray  # (GROUP, width * LANES) layout.PresentColumns
    ball: np.ndarray  # (c,) the first partner
    partner: np.ndarray  # (c,) the second one: a ball, or -1 - feature
    slot: np.ndarray  # (c,) the candidate; -1 in a lane that is free
    free: np.ndarray  # (c,) stack of free lanes
    kept_ball: np.ndarray  # (c,) of contacts that are set aside while the lists are rebuilt
    kept_partner: np.ndarray  # (c,)
    kept_history: np.ndarray  # (c, width) layout.HistoryColumns


class Laws(NamedTuple):
    """Contact coefficients (law.law_row) by species."""

    pair: np.ndarray  # (species, species, width) layout.LawColumns
    wall: np.ndarray  # (surfaces, species, width), by walls.SURFACE
    surface: np.ndarray  # (features,) surface of every feature of the walls, walls.Walls.surface
    by_speed: SpeedTables | None  # of coefficients that depend on the speed of the hit; the kernels are compiled for it


class Clock(NamedTuple):
    """Time and motion of the bodies."""

    step: float  # [s]
    gravity: np.ndarray  # (3,) [m/s2]
    motions: Motions
    # Changes in a step; one number for all where the balls are of one size.
    gain: np.ndarray  # (3 n,) or (1,) of velocities by unit forces [m/s]
    turn: np.ndarray  # (3 n,) or (1,) of angular velocities by unit torques [rad/s]
    fall: np.ndarray  # (3 n,) of velocities by gravity [m/s]
    load: np.ndarray  # (bodies, 6) on the balls, torque about the body's origin, of the present step
    skin: float  # a candidate is listed up to this far from contact [m]


def on_cache_lines(values: np.ndarray) -> np.ndarray:
    """A copy that begins with a cache line (millprint.run.cache_lines), of LINED_ROWS at most.

    A longer array stays where it comes to lie: with 20,000 balls, whose numbers are far from the processor, steps were
    slower with all arrays at the start of a line.
    """
    return values.copy() if len(values) > LINED_ROWS else aligned(values)


def make_balls(position: np.ndarray, species: np.ndarray, radii: np.ndarray, density: float) -> Balls:
    """Balls at rest at `position` (n, 3) [m]; species (n,) are rows of `radii` [m]; density [kg/m3]."""
    position = np.ascontiguousarray(position, dtype=float)
    moving = {name: on_cache_lines(np.zeros_like(position)) for name in MOVING}
    moving["position"][:] = position
    radii = np.asarray(radii, dtype=float)
    mass = density * 4 / 3 * math.pi * radii**3
    species = np.asarray(species, dtype=np.int64)
    inertia, touching = 0.4 * mass * radii**2, np.zeros(len(position), dtype=np.int64)
    return Balls(**moving, species=species, radius=radii, mass=mass, inertia=inertia, touching=touching)


def make_candidates(balls: int, bodies: int = 1, per_ball: int = 12) -> Candidates:
    """Empty lists with room for `per_ball` candidates a ball."""
    room = balls * per_ball + 64
    return Candidates(
        # Unsigned numbers spare the compiled code the look for negative ones.
        first=np.zeros(balls + 1, dtype=np.uint64),
        first_wall=np.zeros((bodies, balls + 1), dtype=np.uint64),
        ball=np.zeros(room, dtype=np.uint32),
        partner=np.zeros(room, dtype=np.int64),
        plane=np.zeros((room, 4)),
        sure=np.zeros(room, dtype=np.uint8),
        lane=np.full(room, -1, dtype=np.int64),
        trigger=np.zeros(room),
        near=np.zeros(room + 1, dtype=np.uint32),
        near_end=np.zeros(bodies + 1, dtype=np.uint64),
        stride=np.zeros(bodies),
        found=np.zeros(room + 1, dtype=np.uint32),
        # No lists yet: the first step makes them, wherever the balls are.
        anchor=np.full((bodies, balls, 3), np.inf),
        cell_place=np.zeros((balls, width_of(CELL)), dtype=np.int64),
        cell_first=np.zeros(4 * balls + 1024, dtype=np.int64),
        cell_member=np.zeros(balls, dtype=np.int64),
    )


def make_present(rows: int) -> np.ndarray:
    """Present rows (rows, width * LANES) of lanes that are free."""
    return on_cache_lines(np.tile(np.repeat(IDLE_PRESENT, LANES), (rows, 1)))


def make_contacts(room: int) -> Contacts:
    """Free lanes for at least `room` contacts."""
    blocks = -(-room // LANES)
    room = blocks * LANES
    return Contacts(
        lanes=on_cache_lines(np.tile(np.repeat(IDLE, LANES), (blocks, 1))),
        present=make_present(GROUP),
        ball=np.zeros(room, dtype=np.uint32),
        partner=np.zeros(room, dtype=np.int64),
        slot=np.full(room, -1, dtype=np.int64),
        free=np.zeros(room, dtype=np.int64),
        kept_ball=np.zeros(room, dtype=np.int64),
        kept_partner=np.zeros(room, dtype=np.int64),
        kept_history=np.zeros((room, HISTORY_WIDTH)),
    )


def lengthened(candidates: Candidates, contacts: Contacts, counters: np.ndarray) -> tuple[Candidates, Contacts]:
    """Twice the room for candidates and contacts, where it is full; those that are open have been set aside and stay.

    The counters let the run go on.
    """
    bodies, balls, _ = candidates.anchor.shape
    longer = make_candidates(balls, bodies, max(1, 2 * candidates.partner.size // balls))
    aside, kept = int(counters[COUNTER.aside]), contacts
    contacts = make_contacts(longer.partner.size)
    contacts.kept_ball[:aside] = kept.kept_ball[:aside]
    contacts.kept_partner[:aside] = kept.kept_partner[:aside]
    contacts.kept_history[:aside] = kept.kept_history[:aside]
    counters[COUNTER.status] = STATUS.running
    counters[COUNTER.check_in] = 0
    return longer, contacts


def make_counters() -> np.ndarray:
    """Counters of a run that has not begun."""
    counters = np.zeros(width_of(COUNTER), dtype=np.int64)
    counters[COUNTER.aside] = -1
    return counters


def make_laws(balls: Balls, contact: ContactConfig, step: float, overlap_fraction: float, surface: np.ndarray) -> Laws:
    """Coefficients of every pair of species and of every species against each surface by its law.

    overlap_fraction: bound on any overlap over the ball's radius [-]; surface: that of every feature of the walls
    (walls.Walls.surface). A wall has R* = R and m* = m. Nothing sticks to a wall without friction.
    """

    def reduced(a: float, b: float) -> float:
        return a * b / (a + b)

    def pull(pair: str, radius: float) -> float:
        return contact.cohesion.pull_N(pair, radius) if contact.cohesion else 0.0

    tables = speed_tables(contact)
    contact = at_reference(contact)
    # Species that differ in their friction only have one row.
    radius, first, row_of = np.unique(balls.radius, return_index=True, return_inverse=True)
    mass, inertia, species = balls.mass[first], balls.inertia[first], range(len(radius))

    def of_pair(a: int, b: int) -> np.ndarray:
        effective, own_mass, own_inertia = (reduced(own[a], own[b]) for own in (radius, mass, inertia))
        smaller = min(radius[a], radius[b])
        sticks, both = pull("ball_ball", effective), radius[a] + radius[b]
        return law_row(contact, effective, own_mass, own_inertia, both, overlap_fraction * smaller, step, sticks)

    def at_wall(a: int, own: ContactConfig, sticks: float) -> np.ndarray:
        return law_row(own, radius[a], mass[a], inertia[a], radius[a], overlap_fraction * radius[a], step, sticks)

    pair = [[of_pair(a, b) for b in species] for a in species]
    rough = [at_wall(a, contact.at_wall, pull("ball_wall", radius[a])) for a in species]
    smooth = [at_wall(a, contact.without_friction, 0.0) for a in species]
    wall = [rough, smooth]  # in the order of walls.Surfaces
    # Rows of a mixture in the order of memory that one species has, or the kernels would be compiled for it again.
    return Laws(np.array(pair)[row_of[:, None], row_of], np.array(wall).take(row_of, axis=1), surface, tables)


def _of_all(sizes: np.ndarray, species: np.ndarray) -> np.ndarray:
    """A number for each component of each ball, by its size; one for all where there is one size."""
    return sizes if len(sizes) == 1 else on_cache_lines(np.repeat(sizes[species], 3))


def make_clock(
    balls: Balls, motions: list[Motion], step: float, skin: float, gravity: float | np.ndarray = GRAVITY
) -> Clock:
    """A clock for the motions of the bodies, the vessel first; gravity [m/s2] as a vector, or downwards."""
    down = np.array(gravity, dtype=float) if np.ndim(gravity) else np.array([0.0, 0.0, -gravity])
    return Clock(
        step=float(step),
        gravity=down,
        motions=stack_motions(motions),
        gain=_of_all(step / balls.mass, balls.species),
        turn=_of_all(step / balls.inertia, balls.species),
        fall=on_cache_lines(np.tile(step * down, len(balls.species))),
        load=np.zeros((len(motions), LOAD_WIDTH)),
        skin=float(skin),
    )
