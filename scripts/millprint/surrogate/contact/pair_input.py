"""Inputs of the local problem of a contact: its state at the start of the step, and the external accelerations.

External accelerations are those by everything but the contact itself: the other contacts of both balls, gravity, and
the motion of a wall.
"""

import math

import numpy as np

from millprint.columns import Vector
from millprint.dem.contact import arms_of
from millprint.dem.lanes import get, get_vector, put, put_vector
from millprint.dem.layout import LANE, LANES, RATE
from millprint.dem.touching import FAR, wall_away
from millprint.kernel import inlined, inner
from millprint.mill.pose import angular_velocity_of, velocity_of
from millprint.mill.vectors import add, add_scaled, cross, dot, row, scale, subtract, vector
from millprint.mill.walls import body_of, direction_to_laboratory, wall_velocity
from millprint.surrogate.contact.pair import LANE_LAST_FORCE, PAIR, tilted
from millprint.surrogate.contact.scratch import EXPECTED_LOAD


@inlined()
def shifted(columns, by):
    """The columns of a vector that lies `by` columns farther on."""
    return Vector(columns.x + by, columns.y + by, columns.z + by)


@inner()
def gather(balls, candidates, contacts, walls, clock, coarse, lane):
    """Write the initial state of the local problem to a lane; returns whether the contact touches, or will soon."""
    block, m = lane // LANES, lane % LANES
    work, motions = coarse.work, clock.motions
    i, j = contacts.ball[lane], contacts.partner[lane]
    position, a = row(balls.position, i), balls.species[i]
    velocity = row(balls.rate, i)
    other_omega = (0.0, 0.0, 0.0)
    fixed, is_plane = (0.0, 0.0, 0.0), 0.0
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    inverse_mass, other_inverse = 1.0 / balls.mass[a], 0.0
    if j >= 0:
        other = np.uint32(j)
        away = subtract(position, row(balls.position, other))
        velocity = subtract(velocity, row(balls.rate, other))
        other_omega = vector(balls.rate, other, RATE.angular_velocity)
        b = balls.species[other]
        inverse_mass += 1.0 / balls.mass[b]
        other_inverse = 1.0 / balls.inertia[b]
    else:
        feature = -1 - j
        body = body_of(walls, feature)
        seen = subtract(velocity, wall_velocity(motions, body, position))
        limit = reach + coarse.margin + clock.step * math.sqrt(dot(seen, seen))
        away = wall_away(walls, candidates, motions, np.uint32(contacts.slot[lane]), body, position, limit)
        if away[0] >= FAR:
            return False
        velocity = subtract(velocity, wall_velocity(motions, body, subtract(position, away)))
        other_omega = angular_velocity_of(motions, body)
        facets = walls.plane.shape[0]
        if feature < facets:
            is_plane = 1.0
            fixed = direction_to_laboratory(motions, body, row(walls.plane, feature))
        elif feature < facets + walls.edge.shape[0]:
            fixed = direction_to_laboratory(motions, body, row(walls.edge[feature - facets], 1))
    distance = math.sqrt(dot(away, away))
    approach = -dot(velocity, away) / distance
    if distance - reach - approach * clock.step >= coarse.margin and distance >= reach:
        return False
    put_vector(work, block, PAIR.away, m, away)
    put_vector(work, block, PAIR.velocity, m, velocity)
    put_vector(work, block, PAIR.angular_velocity, m, vector(balls.rate, i, RATE.angular_velocity))
    put_vector(work, block, PAIR.other_angular_velocity, m, other_omega)
    put_vector(work, block, PAIR.fixed, m, fixed)
    put(work, block, PAIR.is_plane, m, is_plane)
    put(work, block, PAIR.inverse_mass, m, inverse_mass)
    put(work, block, PAIR.inverse_inertia, m, 1.0 / balls.inertia[a])
    put(work, block, PAIR.other_inverse_inertia, m, other_inverse)
    # The force at the end of the last step is the first guess for this step.
    force = get_vector(contacts.lanes, block, LANE_LAST_FORCE, m)
    put_vector(work, block, PAIR.force, m, force)
    put_vector(work, block, PAIR.expected_force, m, force)
    put_vector(work, block, PAIR.expected_tilt, m, (0.0, 0.0, 0.0))
    return True


@inlined()
def torques_of(contacts, work, block, m, force):
    """Torques of a force at the contact point on both bodies [N m]."""
    away = get_vector(work, block, PAIR.away, m)
    distance = math.sqrt(dot(away, away))
    arm, other = arms_of(contacts.lanes, block, m, distance)
    lever = scale(1.0 / distance, cross(force, away))
    return scale(arm, lever), scale(other, lever)


# Columns from what belongs to the mean of a prediction to what belongs to its tilt.
TO_EXPECTED_TILT = PAIR.expected_tilt.x - PAIR.expected_force.x
TO_LOAD_TILT = EXPECTED_LOAD.tilt.force.x - EXPECTED_LOAD.mean.force.x
TO_TILT = PAIR.tilt.external.x - PAIR.mean.external.x


@inner()
def expect(contacts, coarse, lane):
    """Add the predicted forces and torques of a contact, mean and tilt, to its balls."""
    block, m = lane // LANES, lane % LANES
    work, load = coarse.work, coarse.load
    i, j = contacts.ball[lane], contacts.partner[lane]
    for part in range(2):
        force = get_vector(work, block, shifted(PAIR.expected_force, TO_EXPECTED_TILT * part), m)
        torque, back = torques_of(contacts, work, block, m, force)
        at = TO_LOAD_TILT * part
        for c in range(3):
            load[i, at + EXPECTED_LOAD.mean.force.x + c] += force[c]
            load[i, at + EXPECTED_LOAD.mean.torque.x + c] += torque[c]
            if j >= 0:
                load[j, at + EXPECTED_LOAD.mean.force.x + c] -= force[c]
                load[j, at + EXPECTED_LOAD.mean.torque.x + c] += back[c]


@inlined()
def load_on(load, i, part):
    """Force [N] and torque [N m] on ball i of one part: the mean (0) or its tilt (1)."""
    at = TO_LOAD_TILT * part
    mean = EXPECTED_LOAD.mean
    return vector(load, i, shifted(mean.force, at)), vector(load, i, shifted(mean.torque, at))


@inner()
def put_external(balls, contacts, walls, clock, coarse, lane):
    """Put the external accelerations of a contact into its lane: mean and tilt."""
    block, m = lane // LANES, lane % LANES
    work, step, motions = coarse.work, clock.step, clock.motions
    i, j = contacts.ball[lane], contacts.partner[lane]
    a = balls.species[i]
    for part in range(2):
        force = get_vector(work, block, shifted(PAIR.expected_force, TO_EXPECTED_TILT * part), m)
        torque, back = torques_of(contacts, work, block, m, force)
        load, twist = load_on(coarse.load, i, part)
        external = scale(1.0 / balls.mass[a], subtract(load, force))
        angular = scale(1.0 / balls.inertia[a], subtract(twist, torque))
        other_angular = (0.0, 0.0, 0.0)
        if j >= 0:
            other = np.uint32(j)
            b = balls.species[other]
            load, twist = load_on(coarse.load, other, part)
            external = add_scaled(external, -1.0 / balls.mass[b], add(load, force))
            other_angular = scale(1.0 / balls.inertia[b], subtract(twist, back))
        elif part == 0:
            body = body_of(walls, -1 - j)
            external = add(external, (clock.gravity[0], clock.gravity[1], clock.gravity[2]))
            now = velocity_of(motions, body)
            external = add_scaled(external, -1.0 / step, subtract(row(coarse.wall_velocity, body), now))
        put_vector(work, block, shifted(PAIR.mean.external, TO_TILT * part), m, external)
        put_vector(work, block, shifted(PAIR.mean.angular, TO_TILT * part), m, angular)
        put_vector(work, block, shifted(PAIR.mean.other_angular, TO_TILT * part), m, other_angular)


@inlined()
def touch_time(gap, speed, acceleration, step):
    """First time in 0 to `step` at which gap + speed t + acceleration t^2 / 2 is zero; `step` if there is none."""
    root = speed * speed - 2.0 * acceleration * gap
    if root < 0.0:
        return step
    below = -speed + math.sqrt(root)
    if below <= 0.0:
        return step
    return min(2.0 * gap / below, step)


@inner()
def touch_lane(contacts, clock, coarse, lane):
    """The moment of touch of a contact, and its state then."""
    block, m = lane // LANES, lane % LANES
    work, step = coarse.work, clock.step
    away = get_vector(work, block, PAIR.away, m)
    velocity = get_vector(work, block, PAIR.velocity, m)
    omega = get_vector(work, block, PAIR.angular_velocity, m)
    other_omega = get_vector(work, block, PAIR.other_angular_velocity, m)
    distance = math.sqrt(dot(away, away))
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    begin = 0.0
    if distance > reach:
        # A contact that has separated and will touch again is two collisions.
        if get(contacts.lanes, block, LANE.history.peak_overlap, m) > 0.0:
            coarse.ended[0] += 1.0
            put(contacts.lanes, block, LANE.history.peak_overlap, m, 0.0)
        external = get_vector(work, block, PAIR.mean.external, m)
        begin = touch_time(distance - reach, dot(velocity, away) / distance, dot(external, away) / distance, step)
        # Of an acceleration that grows from mean less tilt: its mean up to the touch, and what acts on the position.
        faster, farther = begin / step - 1.0, begin / step * 2.0 / 3.0 - 1.0
        tilt = get_vector(work, block, PAIR.tilt.external, m)
        away = add_scaled(add_scaled(away, begin, velocity), 0.5 * begin * begin, add_scaled(external, farther, tilt))
        velocity = add_scaled(velocity, begin, add_scaled(external, faster, tilt))
        omega = add_scaled(omega, begin, tilted(work, block, PAIR.mean.angular, PAIR.tilt.angular, m, faster))
        other_omega = add_scaled(
            other_omega,
            begin,
            tilted(work, block, PAIR.mean.other_angular, PAIR.tilt.other_angular, m, faster),
        )
        put_vector(work, block, PAIR.away, m, away)
        put_vector(work, block, PAIR.velocity, m, velocity)
        put_vector(work, block, PAIR.angular_velocity, m, omega)
        put_vector(work, block, PAIR.other_angular_velocity, m, other_omega)
        # Nothing acts before the touch.
        put_vector(work, block, PAIR.force, m, (0.0, 0.0, 0.0))
        put_vector(work, block, PAIR.torque, m, (0.0, 0.0, 0.0))
        put_vector(work, block, PAIR.other_torque, m, (0.0, 0.0, 0.0))
        put_vector(work, block, PAIR.slip, m, (0.0, 0.0, 0.0))
        put_vector(contacts.lanes, block, LANE.history.spring, m, (0.0, 0.0, 0.0))
    else:
        arm, other_arm = arms_of(contacts.lanes, block, m, distance)
        normal = scale(1.0 / distance, away)
        torque, back = torques_of(contacts, work, block, m, get_vector(work, block, PAIR.force, m))
        put_vector(work, block, PAIR.torque, m, torque)
        put_vector(work, block, PAIR.other_torque, m, back)
        sliding = subtract(velocity, cross(add_scaled(scale(arm, omega), other_arm, other_omega), normal))
        put_vector(work, block, PAIR.slip, m, add_scaled(sliding, -dot(sliding, normal), normal))
    put(work, block, PAIR.begin, m, begin)
    put(work, block, PAIR.substep_length, m, (step - begin) / coarse.substeps)
    for impulse in (PAIR.impulse, PAIR.moment, PAIR.twist, PAIR.other_twist):
        put_vector(work, block, impulse, m, (0.0, 0.0, 0.0))
