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

from millprint.dem import lanes
from millprint.dem.lanes import HISTORY, LANES, law_of
from millprint.dem.law import REACH, contact_law
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add, add_scaled, cross, dot, scale, subtract

# Quantities of a lane: those of millprint.dem.lanes, of which law and history are copied here, so that all that a
# substep touches lies in one row, and then these. In: relative position [m] and velocity [m/s] of the centres (or of
# centre and foot), angular velocities [rad/s]; mean external accelerations and angular accelerations [m/s2, rad/s2],
# and by how much they are more at the end of the step (and less at its start); normal of a plane wall, or direction in
# which the foot slides freely on an edge; sum of inverse masses [1/kg], inverse moments of inertia [1/(kg m2)]; 1 for a
# plane wall; start of the substeps and their length [s].
(
    AWAY, VELOCITY, ANGULAR_VELOCITY, OTHER_ANGULAR_VELOCITY, EXTERNAL, ANGULAR, OTHER_ANGULAR,
    EXTERNAL_TILT, ANGULAR_TILT, OTHER_ANGULAR_TILT, FIXED,
) = range(lanes.QUANTITIES, lanes.QUANTITIES + 33, 3)  # fmt: skip
INVERSE_MASS, INVERSE_INERTIA, OTHER_INVERSE_INERTIA, IS_PLANE, BEGIN, TAU = range(FIXED + 3, FIXED + 9)
# Prediction for the contact: its mean force in the step and the tilt of the force [N].
EXPECTED, TILT = TAU + 1, TAU + 4
# Out: impulse on i [N s], its first moment [N s2], impulses of the torques on i and j [N m s].
IMPULSE, MOMENT, TWIST, OTHER_TWIST = range(TILT + 3, TILT + 15, 3)
# At the end of the last substep: force [N], torques [N m], slip [m/s].
FORCE, TORQUE, BACK, SLIP = range(OTHER_TWIST + 3, OTHER_TWIST + 15, 3)
# Inputs of the network and its outputs, and how many of them there are.
INPUTS, OUTPUTS = 13, 8
FEATURES = SLIP + 3
OUTPUTS_AT = FEATURES + INPUTS
LOCAL_QUANTITIES = OUTPUTS_AT + OUTPUTS


@inlined()
def tilted(work, block, mean, tilt, m, when):
    """An acceleration at a time from -1 at the start of the step to 1 at its end."""
    return add_scaled(lanes.get_vector(work, block, mean, m), when, lanes.get_vector(work, block, tilt, m))


@inlined()
def middle(work, block, m, half):
    """The relative position in the middle of a substep; at a wall it stays on the plane or edge."""
    away = add_scaled(lanes.get_vector(work, block, AWAY, m), half, lanes.get_vector(work, block, VELOCITY, m))
    fixed, plane = lanes.get_vector(work, block, FIXED, m), lanes.get(work, block, IS_PLANE, m)
    along = scale(dot(away, fixed), fixed)
    return add_scaled(scale(1.0 - plane, subtract(away, along)), plane, along)


@inlined()
def arms(rows, block, m, distance):
    """Distances of both centres from the contact point [m]; for a wall, the whole distance and zero.

    rows: the lanes of contacts or of local problems, which share these quantities.
    """
    reach, is_wall = lanes.get(rows, block, lanes.LAW + REACH, m), lanes.get(rows, block, lanes.IS_WALL, m)
    arm = 0.5 * (distance + lanes.get(rows, block, lanes.DIFFERENCE, m) * reach / distance + is_wall * distance)
    return arm, distance - arm


@inlined()
def shape_of(work, block, m, distance):
    """Of a contact: 1 if it touches, overlap, both arms and their mean [m]; see millprint.dem.lanes.evaluate."""
    reach, is_wall = lanes.get(work, block, lanes.LAW + REACH, m), lanes.get(work, block, lanes.IS_WALL, m)
    gap = reach - distance
    touches = 1.0 if gap > 0.0 else 0.0
    overlap = gap if gap > 1e-30 else 1e-30
    arm, other = arms(work, block, m, distance)
    return touches, overlap, arm, other, 2.0 * arm * other / distance + is_wall * distance


@inlined()
def soon(work, block, m, half, externals):
    """Relative velocity and both angular velocities in the middle of a substep, by the forces of the last one."""
    external, angular, other_angular = externals
    pull = scale(lanes.get(work, block, INVERSE_MASS, m), lanes.get_vector(work, block, FORCE, m))
    twist = scale(lanes.get(work, block, INVERSE_INERTIA, m), lanes.get_vector(work, block, TORQUE, m))
    other_twist = scale(lanes.get(work, block, OTHER_INVERSE_INERTIA, m), lanes.get_vector(work, block, BACK, m))
    return (
        add_scaled(lanes.get_vector(work, block, VELOCITY, m), half, add(external, pull)),
        add_scaled(lanes.get_vector(work, block, ANGULAR_VELOCITY, m), half, add(angular, twist)),
        add_scaled(lanes.get_vector(work, block, OTHER_ANGULAR_VELOCITY, m), half, add(other_angular, other_twist)),
    )


@inlined()
def book(work, block, m, touches, tau, normal_force, overlap, spring, slip, powers, stored):
    """Spring, peaks and works of a substep; zero for a contact that does not touch."""
    lanes.put_vector(work, block, HISTORY + lanes.SPRING, m, scale(touches, spring))
    lanes.put_vector(work, block, SLIP, m, scale(touches, slip))
    lanes.raise_to(work, block, HISTORY + lanes.PEAK_FORCE, m, touches * normal_force)
    lanes.raise_to(work, block, HISTORY + lanes.PEAK_OVERLAP, m, touches * overlap)
    done = touches * tau
    lanes.add_to(work, block, HISTORY + lanes.NORMAL, m, done * powers[0])
    lanes.add_to(work, block, HISTORY + lanes.DAMPING, m, done * powers[1])
    lanes.add_to(work, block, HISTORY + lanes.TANGENTIAL, m, done * powers[2])
    lanes.add_to(work, block, HISTORY + lanes.ROLLING, m, done * powers[3])
    lanes.put(work, block, lanes.STORED, m, touches * stored[0])
    lanes.put(work, block, lanes.STORED + 1, m, touches * stored[1])


@inlined()
def add_vector(work, block, quantity, m, factor, vector):
    """Add a multiple of a vector to a vector of a lane."""
    sum_ = add_scaled(lanes.get_vector(work, block, quantity, m), factor, vector)
    lanes.put_vector(work, block, quantity, m, sum_)


@inlined()
def kick(work, block, m, tau, left, away, externals, force, torque, back):
    """Velocities after the substep, second half of the drift, and impulses on the balls; left: to the end [s]."""
    external, angular, other_angular = externals
    pull = scale(lanes.get(work, block, INVERSE_MASS, m), force)
    twist = scale(lanes.get(work, block, INVERSE_INERTIA, m), torque)
    other_twist = scale(lanes.get(work, block, OTHER_INVERSE_INERTIA, m), back)
    velocity = add_scaled(lanes.get_vector(work, block, VELOCITY, m), tau, add(external, pull))
    lanes.put_vector(work, block, VELOCITY, m, velocity)
    lanes.put_vector(work, block, AWAY, m, add_scaled(away, 0.5 * tau, velocity))
    add_vector(work, block, ANGULAR_VELOCITY, m, tau, add(angular, twist))
    add_vector(work, block, OTHER_ANGULAR_VELOCITY, m, tau, add(other_angular, other_twist))
    lanes.put_vector(work, block, FORCE, m, force)
    lanes.put_vector(work, block, TORQUE, m, torque)
    lanes.put_vector(work, block, BACK, m, back)
    add_vector(work, block, IMPULSE, m, tau, force)
    add_vector(work, block, MOMENT, m, tau * left, force)
    add_vector(work, block, TWIST, m, tau, torque)
    add_vector(work, block, OTHER_TWIST, m, tau, back)


@inner()
def substep(work, block, number, last, step):
    """Substep `number` of every contact in a block; `last` more follow; step: the coarse one [s].

    work (blocks, LOCAL_QUANTITIES * LANES).
    """
    for m in range(LANES):
        tau = lanes.get(work, block, TAU, m)
        away = middle(work, block, m, 0.5 * tau)
        distance = math.sqrt(dot(away, away))
        normal = scale(1.0 / distance, away)
        touches, overlap, arm, other, mean_arm = shape_of(work, block, m, distance)
        # From -1 at the start of the step to 1 at its end.
        when = 2.0 * (lanes.get(work, block, BEGIN, m) + (number + 0.5) * tau) / step - 1.0
        externals = (
            tilted(work, block, EXTERNAL, EXTERNAL_TILT, m, when),
            tilted(work, block, ANGULAR, ANGULAR_TILT, m, when),
            tilted(work, block, OTHER_ANGULAR, OTHER_ANGULAR_TILT, m, when),
        )
        seen, omega, other_omega = soon(work, block, m, 0.5 * tau, externals)
        turning = add_scaled(scale(arm, omega), other, other_omega)
        normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
            law_of(work, block, m), overlap, normal, mean_arm, subtract(seen, cross(turning, normal)),
            subtract(omega, other_omega), lanes.get_vector(work, block, HISTORY + lanes.SPRING, m),
            lanes.get_vector(work, block, SLIP, m), tau,
        )  # fmt: skip
        book(work, block, m, touches, tau, normal_force, overlap, spring, slip, powers, stored)
        force = scale(touches, add_scaled(tangential, normal_force, normal))
        rolling, lever = scale(touches, rolling), cross(force, normal)
        torque, back = add_scaled(rolling, arm, lever), subtract(scale(other, lever), rolling)
        kick(work, block, m, tau, (last + 0.5) * tau, away, externals, force, torque, back)
