"""The local problem of one contact over a coarse step: two bodies with their contact law, all other forces given.

Bodies i and j (or a wall), with relative position r = x_i - x_j, relative velocity u, and angular velocities w_i and
w_j, obey

    u' = F (1 / m_i + 1 / m_j) + a,   w_i' = T_i / I_i + alpha_i,   w_j' = T_j / I_j + alpha_j

with F, T_i, T_j from the law of millprint.dem.law at the present overlap, and a, alpha_i, alpha_j the accelerations by
everything else, linear in time over the step h. The problem is solved in a few position-Verlet substeps that begin at
the moment of touch, so that nothing depends on where in the step a contact begins. What comes out are the impulse
int F ds, its first moment int (h - s) F ds (by which positions feel a force late in the step less), the impulses of
the torques, and the works of each channel. Equal and opposite by construction, nothing without overlap, and
dissipation never negative but for rounding, whatever `a` is.

Eight contacts go through one instruction, as in millprint.dem.lanes.
"""

import math
from typing import NamedTuple

from millprint.columns import Vector, number_columns, width_of
from millprint.dem.contact import arms_of, book_step, mean_arm_of
from millprint.dem.lanes import get, get_vector, put, put_vector
from millprint.dem.law import contact_law
from millprint.dem.layout import HISTORY, LANE, LANES, LaneColumns
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add, add_scaled, cross, dot, scale, subtract


class AccelerationColumns(NamedTuple):
    """Accelerations of a contact's partners by everything but the contact."""

    external: Vector  # of the relative position [m/s2]
    angular: Vector  # of the first [rad/s2]
    other_angular: Vector  # of the second [rad/s2]


class InputColumns(NamedTuple):
    """Inputs of the network, dimensionless (see predictor.describe)."""

    overlap: int
    approach_speed: int
    normal_force: int
    external: int
    friction: int
    slip: int
    sideways: int
    friction_with_slip: int
    friction_with_sideways: int
    slip_with_sideways: int
    cap_share: int
    is_wall: int
    next_overlap: int


class OutputColumns(NamedTuple):
    """Outputs of the network, dimensionless (see predictor.combine)."""

    normal: int
    normal_tilt: int
    friction: int
    slip: int
    sideways: int
    friction_tilt: int
    slip_tilt: int
    sideways_tilt: int


class PairColumns(NamedTuple):
    """Quantities of a local problem. The law and the history are copied into `lane`: a substep reads one row alone."""

    lane: LaneColumns
    away: Vector  # from the second centre, or the wall's foot, to the first centre [m]
    velocity: Vector  # of the first centre relative to the second one, or the foot [m/s]
    angular_velocity: Vector  # of the first [rad/s]
    other_angular_velocity: Vector  # of the second [rad/s]
    mean: AccelerationColumns  # over the step
    tilt: AccelerationColumns  # by how much they are more at the end of the step, and less at its start
    fixed: Vector  # normal of a plane wall, or direction in which the foot slides freely on an edge
    inverse_mass: int  # sum of both [1/kg]
    inverse_inertia: int  # [1/(kg m2)]
    other_inverse_inertia: int  # [1/(kg m2)]
    is_plane: int  # 1 for a plane wall, else 0
    begin: int  # of the substeps [s]
    substep_length: int  # [s]
    expected_force: Vector  # mean over the step [N]
    expected_tilt: Vector  # of that force [N]
    impulse: Vector  # on the first [N s]
    moment: Vector  # of the impulse [N s2]
    twist: Vector  # impulse of the torque on the first [N m s]
    other_twist: Vector  # and on the second [N m s]
    force: Vector  # on the first at the end of the last substep [N]
    torque: Vector  # on the first then [N m]
    other_torque: Vector  # on the second then [N m]
    slip: Vector  # then [m/s]
    inputs: InputColumns
    outputs: OutputColumns


PAIR = number_columns(PairColumns)
# Of a network's output alone.
OUTPUT = number_columns(OutputColumns)
PAIR_WIDTH, INPUTS, OUTPUTS = width_of(PAIR), width_of(PAIR.inputs), width_of(PAIR.outputs)

# Between coarse steps a contact keeps the force at the end of the last one [N] where the DEM keeps the slip velocity:
# the column in a lane, and in a history.
LANE_LAST_FORCE, LAST_FORCE = LANE.history.last_slip, HISTORY.last_slip


@inlined()
def tilted(work, block, mean, tilt, m, when):
    """An acceleration at a time from -1 at the start of the step to 1 at its end."""
    return add_scaled(get_vector(work, block, mean, m), when, get_vector(work, block, tilt, m))


@inlined()
def middle(work, block, m, half):
    """The relative position in the middle of a substep; at a wall it stays on the plane or edge."""
    away = add_scaled(get_vector(work, block, PAIR.away, m), half, get_vector(work, block, PAIR.velocity, m))
    fixed, plane = get_vector(work, block, PAIR.fixed, m), get(work, block, PAIR.is_plane, m)
    along = scale(dot(away, fixed), fixed)
    return add_scaled(scale(1.0 - plane, subtract(away, along)), plane, along)


@inlined()
def overlap_of(work, block, m, distance):
    """Of a contact: 1 if it touches, else 0, and the overlap [m]; distance: of the centres, or centre and foot [m]."""
    gap = get(work, block, LANE.law.reach, m) - distance
    return 1.0 if gap > 0.0 else 0.0, gap if gap > 1e-30 else 1e-30


@inlined()
def soon(work, block, m, half, externals):
    """Relative velocity and both angular velocities in the middle of a substep, by the forces of the last one."""
    external, angular, other_angular = externals
    pull = scale(get(work, block, PAIR.inverse_mass, m), get_vector(work, block, PAIR.force, m))
    twist = scale(get(work, block, PAIR.inverse_inertia, m), get_vector(work, block, PAIR.torque, m))
    other_twist = scale(get(work, block, PAIR.other_inverse_inertia, m), get_vector(work, block, PAIR.other_torque, m))
    return (
        add_scaled(get_vector(work, block, PAIR.velocity, m), half, add(external, pull)),
        add_scaled(get_vector(work, block, PAIR.angular_velocity, m), half, add(angular, twist)),
        add_scaled(get_vector(work, block, PAIR.other_angular_velocity, m), half, add(other_angular, other_twist)),
    )


@inlined()
def book(work, block, m, touches, tau, normal_force, overlap, spring, slip, powers, stored):
    """Spring, peaks and works of a substep; zero for a contact that does not touch."""
    put_vector(work, block, LANE.history.spring, m, scale(touches, spring))
    put_vector(work, block, PAIR.slip, m, scale(touches, slip))
    book_step(work, block, m, touches * tau, touches * normal_force, touches * overlap, powers)
    elastic_normal, elastic_tangential = stored
    put(work, block, LANE.elastic_normal, m, touches * elastic_normal)
    put(work, block, LANE.elastic_tangential, m, touches * elastic_tangential)


@inlined()
def add_vector(work, block, quantity, m, factor, vector):
    """Add a multiple of a vector to a vector of a lane."""
    sum_ = add_scaled(get_vector(work, block, quantity, m), factor, vector)
    put_vector(work, block, quantity, m, sum_)


@inlined()
def kick(work, block, m, tau, left, away, externals, force, torque, back):
    """Velocities after the substep, second half of the drift, and impulses on the balls; left: to the end [s]."""
    external, angular, other_angular = externals
    pull = scale(get(work, block, PAIR.inverse_mass, m), force)
    twist = scale(get(work, block, PAIR.inverse_inertia, m), torque)
    other_twist = scale(get(work, block, PAIR.other_inverse_inertia, m), back)
    velocity = add_scaled(get_vector(work, block, PAIR.velocity, m), tau, add(external, pull))
    put_vector(work, block, PAIR.velocity, m, velocity)
    put_vector(work, block, PAIR.away, m, add_scaled(away, 0.5 * tau, velocity))
    add_vector(work, block, PAIR.angular_velocity, m, tau, add(angular, twist))
    add_vector(work, block, PAIR.other_angular_velocity, m, tau, add(other_angular, other_twist))
    put_vector(work, block, PAIR.force, m, force)
    put_vector(work, block, PAIR.torque, m, torque)
    put_vector(work, block, PAIR.other_torque, m, back)
    add_vector(work, block, PAIR.impulse, m, tau, force)
    add_vector(work, block, PAIR.moment, m, tau * left, force)
    add_vector(work, block, PAIR.twist, m, tau, torque)
    add_vector(work, block, PAIR.other_twist, m, tau, back)


@inner()
def substep(work, block, number, last, step):
    """Substep `number` of every contact in a block; `last` more follow; step: the coarse one [s].

    work: (blocks, PAIR_WIDTH * LANES).
    """
    for m in range(LANES):
        tau = get(work, block, PAIR.substep_length, m)
        away = middle(work, block, m, 0.5 * tau)
        distance = math.sqrt(dot(away, away))
        normal = scale(1.0 / distance, away)
        touches, overlap = overlap_of(work, block, m, distance)
        arm, other = arms_of(work, block, m, distance)
        # From -1 at the start of the step to 1 at its end.
        when = 2.0 * (get(work, block, PAIR.begin, m) + (number + 0.5) * tau) / step - 1.0
        externals = (
            tilted(work, block, PAIR.mean.external, PAIR.tilt.external, m, when),
            tilted(work, block, PAIR.mean.angular, PAIR.tilt.angular, m, when),
            tilted(work, block, PAIR.mean.other_angular, PAIR.tilt.other_angular, m, when),
        )
        seen, omega, other_omega = soon(work, block, m, 0.5 * tau, externals)
        turning = add_scaled(scale(arm, omega), other, other_omega)
        normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
            work, block, m, overlap, normal, mean_arm_of(work, block, m, distance, arm, other),
            subtract(seen, cross(turning, normal)),
            subtract(omega, other_omega), get_vector(work, block, LANE.history.spring, m),
            get_vector(work, block, PAIR.slip, m), tau,
        )  # fmt: skip
        book(work, block, m, touches, tau, normal_force, overlap, spring, slip, powers, stored)
        force = scale(touches, add_scaled(tangential, normal_force, normal))
        rolling, lever = scale(touches, rolling), cross(force, normal)
        torque, back = add_scaled(rolling, arm, lever), subtract(scale(other, lever), rolling)
        kick(work, block, m, tau, (last + 0.5) * tau, away, externals, force, torque, back)
