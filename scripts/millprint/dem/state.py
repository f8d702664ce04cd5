"""The state of a simulation as groups of flat arrays, which kernels take and change in place."""

import math
from typing import NamedTuple

import numpy as np

from millprint.config.contact import ContactConfig
from millprint.dem.law import law_row
from millprint.mill.motion import POSE

# Columns of a contact's record while it is open.
START, APPROACH, PEAK_FORCE, PEAK_OVERLAP, NORMAL, DAMPING, TANGENTIAL, ROLLING = range(8)
RECORD = 8

# Columns of a contact's tangential state: spring [m] and slip velocity a step ago [m/s].
TANGENT = 6

# Running totals: wall work, works of the contacts that have closed [J]; of the present step: elastic energies [J].
WALL_WORK, TOTAL_NORMAL, TOTAL_DAMPING, TOTAL_TANGENTIAL, TOTAL_ROLLING, ELASTIC_NORMAL, ELASTIC_TANGENTIAL = range(7)
TOTALS = 7

# Counters of a run.
STEP, CHECK_IN, STATUS, BALL, PARTNER, RECORDS, SAMPLES, SNAPSHOTS, SNAPSHOT_CONTACTS, REBUILDS = range(10)
COUNTERS = 10

# Status of a run.
RUNNING, OVERLAP, ESCAPED, NOT_FINITE, SLOTS_FULL, CONTACT_LOST = range(6)


class Balls(NamedTuple):
    """State of the balls; velocities are those of half a step ago, `_now` those expected at the present position."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    velocity_now: np.ndarray
    spin: np.ndarray  # (n, 3) [rad/s]
    spin_now: np.ndarray
    force: np.ndarray  # (n, 3) contact force [N]
    torque: np.ndarray  # (n, 3) [N m]
    species: np.ndarray  # (n,) row of the tables below
    radius: np.ndarray  # (species,) [m]
    mass: np.ndarray  # (species,) [kg]
    inertia: np.ndarray  # (species,) [kg m2]


class Slots(NamedTuple):
    """Candidate contacts, ball by ball: first with balls of a higher number, then with features of the wall."""

    first: np.ndarray  # (n + 1,) slots of ball i are first[i] to first[i + 1]
    first_wall: np.ndarray  # (n,) where its wall features begin
    partner: np.ndarray  # (s,) a ball, or -1 - feature
    sure: np.ndarray  # (s,) 1 where the foot is surely on the facet
    is_open: np.ndarray  # (s,) 1 while in contact
    tangent: np.ndarray  # (s, 6) tangential displacement [m], slip velocity a step ago [m/s]
    record: np.ndarray  # (s, 8) what the contact has done so far
    anchor: np.ndarray  # (n, 3) body-frame positions at the last rebuild [m]
    kept_ball: np.ndarray  # open contacts, put aside during a rebuild
    kept_partner: np.ndarray
    kept_tangent: np.ndarray
    kept_record: np.ndarray
    cell_place: np.ndarray  # (n, 4) a ball's cell along each axis, and its number
    cell_first: np.ndarray  # (cells + 1,) where a cell's members begin
    cell_member: np.ndarray  # (n,)


class Laws(NamedTuple):
    """Contact coefficients (law.law_row) by species."""

    pair: np.ndarray  # (species, species, columns)
    wall: np.ndarray  # (species, columns)
    overlap_max: np.ndarray  # (species,) bound on any overlap [m]


class Clock(NamedTuple):
    """Time and motion of the vessel."""

    step: float  # [s]
    gravity: np.ndarray  # (3,) [m/s2]
    kind: int
    harmonics: np.ndarray
    pose: np.ndarray  # see mill.motion
    skin: float  # a candidate is listed up to this far from contact [m]


def make_balls(position: np.ndarray, species: np.ndarray, radii: np.ndarray, density: float) -> Balls:
    """Balls at rest at `position` (n, 3) [m]; species (n,) are rows of `radii` [m]; density [kg/m3]."""
    position = np.ascontiguousarray(position, dtype=float)
    zero = [np.zeros_like(position) for _ in range(6)]
    radii = np.asarray(radii, dtype=float)
    mass = density * 4 / 3 * math.pi * radii**3
    return Balls(position.copy(), *zero, np.asarray(species, dtype=np.int64), radii, mass, 0.4 * mass * radii**2)


def make_slots(balls: int, per_ball: int = 24) -> Slots:
    """Empty candidate lists with room for `per_ball` candidates a ball."""
    room = balls * per_ball + 16
    return Slots(
        first=np.zeros(balls + 1, dtype=np.int64),
        first_wall=np.zeros(balls, dtype=np.int64),
        partner=np.zeros(room, dtype=np.int64),
        sure=np.zeros(room, dtype=np.uint8),
        is_open=np.zeros(room, dtype=np.uint8),
        tangent=np.zeros((room, TANGENT)),
        record=np.zeros((room, RECORD)),
        anchor=np.zeros((balls, 3)),
        kept_ball=np.zeros(room, dtype=np.int64),
        kept_partner=np.zeros(room, dtype=np.int64),
        kept_tangent=np.zeros((room, TANGENT)),
        kept_record=np.zeros((room, RECORD)),
        cell_place=np.zeros((balls, 4), dtype=np.int64),
        cell_first=np.zeros(4 * balls + 1024, dtype=np.int64),
        cell_member=np.zeros(balls, dtype=np.int64),
    )


def make_laws(balls: Balls, contact: ContactConfig, step: float, overlap_fraction: float) -> Laws:
    """Coefficients of every pair of species and of every species against the wall (Eqs 3.11 to 3.14).

    overlap_fraction: bound on any overlap over the ball's radius [-]. A wall has R* = R and m* = m.
    """

    def reduced(a: float, b: float) -> float:
        return a * b / (a + b)

    species = range(len(balls.radius))
    radius, mass, inertia = balls.radius, balls.mass, balls.inertia
    pair = [
        [
            law_row(
                contact,
                reduced(radius[a], radius[b]),
                reduced(mass[a], mass[b]),
                reduced(inertia[a], inertia[b]),
                radius[a] + radius[b],
                step,
            )
            for b in species
        ]
        for a in species
    ]
    wall = [law_row(contact, radius[a], mass[a], inertia[a], radius[a], step) for a in species]
    return Laws(np.array(pair), np.array(wall), overlap_fraction * radius)


def make_clock(motion, step: float, skin: float, gravity: float = 9.81) -> Clock:
    """A clock for a motion (mill.motion.Motion) of the vessel, with gravity downwards [m/s2]."""
    return Clock(
        float(step), np.array([0.0, 0.0, -gravity]), motion.kind, motion.harmonics, np.zeros(POSE), float(skin)
    )
