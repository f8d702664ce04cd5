"""Eight contacts at a time: gathered from the balls into lanes, put through the law in one go, scattered back.

A block of lanes is one row of numbers, LANES for each quantity, so that the compiler knows that quantities never
overlap and makes vector instructions of the loop over the lanes. A lane that is free keeps the numbers of an earlier
contact, or IDLE ones: they cost nothing and nobody reads what comes out.
"""

import math

import numpy as np

from millprint.dem.law import CN, COLUMNS, CT, KN, KT, MU, MU_ROLLING, REACH, STOP, contact_law
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add_scaled, cross, dot, scale, subtract

LANES = 8

# The history of a contact: tangential spring [m], slip velocity a step ago [m/s], what it has done so far (peaks of
# force [N] and overlap [m], works by channel [J]), and how it began [s, m/s]. The law changes all but the beginning.
SPRING, LAST_SLIP, PEAK_FORCE, PEAK_OVERLAP, NORMAL, DAMPING, TANGENTIAL, ROLLING, START, APPROACH = (
    0, 3, 6, 7, 8, 9, 10, 11, 12, 13,
)  # fmt: skip
HISTORY_COLUMNS = 14

# Quantities of a lane. In: from the second centre, or the wall's foot, to the first [m]; relative velocity of the
# centres [m/s]; angular velocities [rad/s]; 1 for a wall; radius of the first less that of the second [m]; the law.
AWAY, VELOCITY, SPIN, OTHER_SPIN, IS_WALL, DIFFERENCE, LAW = 0, 3, 6, 9, 12, 13, 14
HISTORY = LAW + COLUMNS
# Out: force on the first [N], torque on both about their centres or the foot [N m], elastic energies [J].
FORCE = HISTORY + HISTORY_COLUMNS
TORQUE, BACK, STORED = FORCE + 3, FORCE + 6, FORCE + 9
QUANTITIES = STORED + 2

# Two steel balls of 10 mm that touch.
IDLE = np.zeros(QUANTITIES)
IDLE[AWAY] = 9.99e-3
IDLE[LAW : LAW + COLUMNS] = 1.0
IDLE[LAW + REACH] = 10e-3


@inlined()
def get(lanes, block, quantity, m):
    """A quantity of a lane."""
    return lanes[block, quantity * LANES + m]


@inlined()
def put(lanes, block, quantity, m, value):
    """Set a quantity of a lane."""
    lanes[block, quantity * LANES + m] = value


@inlined()
def get_vector(lanes, block, quantity, m):
    """A vector of a lane: three quantities that follow each other."""
    at = quantity * LANES + m
    return lanes[block, at], lanes[block, at + LANES], lanes[block, at + 2 * LANES]


@inlined()
def put_vector(lanes, block, quantity, m, vector):
    """Set a vector of a lane."""
    at = quantity * LANES + m
    lanes[block, at] = vector[0]
    lanes[block, at + LANES] = vector[1]
    lanes[block, at + 2 * LANES] = vector[2]


@inlined()
def add_to(lanes, block, quantity, m, value):
    """Add to a quantity of a lane."""
    lanes[block, quantity * LANES + m] += value


@inlined()
def raise_to(lanes, block, quantity, m, value):
    """Set a quantity of a lane to a value that is larger."""
    at = quantity * LANES + m
    lanes[block, at] = value if value > lanes[block, at] else lanes[block, at]


@inlined()
def update_history(lanes, block, m, step, normal_force, overlap, spring, slip, powers):
    """Keep what a contact carries from step to step, and add the works of this step [s]: powers are in W."""
    put_vector(lanes, block, HISTORY + SPRING, m, spring)
    put_vector(lanes, block, HISTORY + LAST_SLIP, m, slip)
    raise_to(lanes, block, HISTORY + PEAK_FORCE, m, normal_force)
    raise_to(lanes, block, HISTORY + PEAK_OVERLAP, m, overlap)
    add_to(lanes, block, HISTORY + NORMAL, m, step * powers[0])
    add_to(lanes, block, HISTORY + DAMPING, m, step * powers[1])
    add_to(lanes, block, HISTORY + TANGENTIAL, m, step * powers[2])
    add_to(lanes, block, HISTORY + ROLLING, m, step * powers[3])


@inlined()
def law_of(lanes, block, m):
    """The coefficients of the law in a lane, as contact_law takes them."""
    return (
        get(lanes, block, LAW + KN, m), get(lanes, block, LAW + KT, m), get(lanes, block, LAW + CN, m),
        get(lanes, block, LAW + CT, m), get(lanes, block, LAW + MU, m), get(lanes, block, LAW + MU_ROLLING, m),
        get(lanes, block, LAW + STOP, m),
    )  # fmt: skip


@inner()
def evaluate(lanes, block, step):
    """Forces, torques and new histories of the contacts in a block.

    The plane of contact is where the two spheres cut each other, or the wall. The velocity there is
    v_i + w_i x (-a n) - v_j - w_j x (b n), with a and b the distances of the centres from it. A wall has b = 0.
    """
    for m in range(LANES):
        away = get_vector(lanes, block, AWAY, m)
        distance = math.sqrt(dot(away, away))
        normal = scale(1.0 / distance, away)
        reach, is_wall = get(lanes, block, LAW + REACH, m), get(lanes, block, IS_WALL, m)
        # Rounding may leave nothing of an overlap whose square was still there.
        overlap = reach - distance if reach - distance > 1e-30 else 1e-30
        arm = 0.5 * (distance + get(lanes, block, DIFFERENCE, m) * reach / distance + is_wall * distance)
        other = distance - arm
        mean_arm = 2.0 * arm * other / distance + is_wall * distance
        spin, other_spin = get_vector(lanes, block, SPIN, m), get_vector(lanes, block, OTHER_SPIN, m)
        turning = add_scaled(scale(arm, spin), other, other_spin)
        velocity = subtract(get_vector(lanes, block, VELOCITY, m), cross(turning, normal))
        normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
            law_of(lanes, block, m), overlap, normal, mean_arm, velocity, subtract(spin, other_spin),
            get_vector(lanes, block, HISTORY + SPRING, m), get_vector(lanes, block, HISTORY + LAST_SLIP, m), step,
        )  # fmt: skip
        update_history(lanes, block, m, step, normal_force, overlap, spring, slip, powers)
        force = add_scaled(tangential, normal_force, normal)
        lever = cross(force, normal)
        put_vector(lanes, block, FORCE, m, force)
        put_vector(lanes, block, TORQUE, m, add_scaled(rolling, arm, lever))
        put_vector(lanes, block, BACK, m, subtract(scale(other, lever), rolling))
        put(lanes, block, STORED, m, stored[0])
        put(lanes, block, STORED + 1, m, stored[1])
