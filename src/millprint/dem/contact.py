"""The contacts of a block of lanes: geometry, contact law, and the works so far."""

import math

from millprint.dem.lanes import add_to, get, get_present, get_vector, put, put_present, put_vector, raise_to
from millprint.dem.law import contact_law
from millprint.dem.layout import LANE, LANES, PRESENT
from millprint.mill.vectors import add_scaled, cross, dot, scale, subtract
from millprint.run.kernel import inlined, inner


@inlined()
def arms_of(lanes, block, m, distance):
    """Distances of both centres from the plane of contact [m]; distance: of the centres, or of centre and foot [m].

    The plane of contact is where the two spheres cut each other, or the wall.
    """
    reach, is_wall = get(lanes, block, LANE.law.reach, m), get(lanes, block, LANE.is_wall, m)
    arm = 0.5 * (distance + get(lanes, block, LANE.radius_difference, m) * reach / distance + is_wall * distance)
    return arm, distance - arm


@inlined()
def mean_arm_of(lanes, block, m, distance, arm, other):
    """The lever of rolling friction [m]: the harmonic mean of both arms, or the arm of a ball at a wall."""
    return 2.0 * arm * other / distance + get(lanes, block, LANE.is_wall, m) * distance


@inlined()
def book_step(lanes, block, m, step, normal_force, overlap, powers):
    """Raise the peaks of a contact [N, m] and add its works in a step [s]; powers: by channel [W]."""
    normal, damping, tangential, rolling = powers
    raise_to(lanes, block, LANE.history.peak_force, m, normal_force)
    raise_to(lanes, block, LANE.history.peak_overlap, m, overlap)
    add_to(lanes, block, LANE.history.works.normal, m, step * normal)
    add_to(lanes, block, LANE.history.works.damping, m, step * damping)
    add_to(lanes, block, LANE.history.works.tangential, m, step * tangential)
    add_to(lanes, block, LANE.history.works.rolling, m, step * rolling)


@inlined()
def evaluate_block(mark, lanes, block, present, at, step):
    """Forces, torques and new histories of the contacts in a block, whose present row is number `at`.

    mark: of their law (laws.registry.mark_of); step [s]. The velocity at the plane of contact is
    v_i + w_i x (-a n) - v_j - w_j x (b n), with a and b the distances of the centres from it. A wall has b = 0.
    """
    for m in range(LANES):
        away = get_present(present, at, PRESENT.away, m)
        distance = math.sqrt(dot(away, away))
        normal = scale(1.0 / distance, away)
        reach = get(lanes, block, LANE.law.reach, m)
        # Rounding may leave nothing of an overlap whose square was still there.
        overlap = reach - distance if reach - distance > 1e-30 else 1e-30
        arm, other = arms_of(lanes, block, m, distance)
        angular = get_present(present, at, PRESENT.angular_velocity, m)
        other_angular = get_present(present, at, PRESENT.other_angular_velocity, m)
        turning = add_scaled(scale(arm, angular), other, other_angular)
        velocity = subtract(get_present(present, at, PRESENT.velocity, m), cross(turning, normal))
        normal_force, tangential, rolling, spring, slip, powers, stored = contact_law(
            mark, lanes, block, m, overlap, normal, mean_arm_of(lanes, block, m, distance, arm, other), velocity,
            subtract(angular, other_angular), get_vector(lanes, block, LANE.history.spring, m),
            get_vector(lanes, block, LANE.history.last_slip, m), step,
        )  # fmt: skip
        put_vector(lanes, block, LANE.history.spring, m, spring)
        put_vector(lanes, block, LANE.history.last_slip, m, slip)
        book_step(lanes, block, m, step, normal_force, overlap, powers)
        force = add_scaled(tangential, normal_force, normal)
        lever = cross(force, normal)
        put_vector(lanes, block, LANE.force, m, force)
        put_present(present, at, PRESENT.torque, m, add_scaled(rolling, arm, lever))
        put_present(present, at, PRESENT.other_torque, m, subtract(scale(other, lever), rolling))
        elastic_normal, elastic_tangential = stored
        put(lanes, block, LANE.elastic_normal, m, elastic_normal)
        put(lanes, block, LANE.elastic_tangential, m, elastic_tangential)


@inner()
def evaluate(mark, lanes, present, begin, end, step):
    """Forces, torques and new histories of the contacts in blocks begin to end.

    Their present rows are the first ones; mark: of their law (laws.registry.mark_of); step [s].
    """
    for block in range(begin, end):
        evaluate_block(mark, lanes, block, present, block - begin, step)
