"""Inputs of the local problem of a contact: its state at the start of the step, and the external accelerations.

External accelerations are those by everything but the contact itself: the other contacts of both balls, gravity, and
the motion of a wall.
"""

import math

import numpy as np

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


@inlined()
def expect_part(contacts, coarse, lane, expected, into):
    """Add an expected force and its torques to the columns `into` of the loads on the balls of a contact."""
    block, m = lane // LANES, lane % LANES
    load = coarse.load
    i, j = contacts.ball[lane], contacts.partner[lane]
    force = get_vector(coarse.work, block, expected, m)
    torque, back = torques_of(contacts, coarse.work, block, m, force)
    for c in range(3):
        load[i, into.force.x + c] += force[c]
        load[i, into.torque.x + c] += torque[c]
        if j >= 0:
            load[j, into.force.x + c] -= force[c]
            load[j, into.torque.x + c] += back[c]


@inner()
def expect(contacts, coarse, lane):
    """Add the predicted forces and torques of a contact, mean and tilt, to its balls."""
    expect_part(contacts, coarse, lane, PAIR.expected_force, EXPECTED_LOAD.mean)
    expect_part(contacts, coarse, lane, PAIR.expected_tilt, EXPECTED_LOAD.tilt)


@inlined()
def put_external_part(balls, contacts, coarse, lane, expected, load, into):
    """Accelerations of a contact by the columns `load` of the loads on its balls, less its own expected force."""
    block, m = lane // LANES, lane % LANES
    work = coarse.work
    i, j = contacts.ball[lane], contacts.partner[lane]
    a = balls.species[i]
    force = get_vector(work, block, expected, m)
    torque, back = torques_of(contacts, work, block, m, force)
    external = scale(1.0 / balls.mass[a], subtract(vector(coarse.load, i, load.force), force))
    angular = scale(1.0 / balls.inertia[a], subtract(vector(coarse.load, i, load.torque), torque))
    other_angular = (0.0, 0.0, 0.0)
    if j >= 0:
        other = np.uint32(j)
        b = balls.species[other]
        external = add_scaled(external, -1.0 / balls.mass[b], add(vector(coarse.load, other, load.force), force))
        other_angular = scale(1.0 / balls.inertia[b], subtract(vector(coarse.load, other, load.torque), back))
    put_vector(work, block, into.external, m, external)
    put_vector(work, block, into.angular, m, angular)
    put_vector(work, block, into.other_angular, m, other_angular)


@inner()
def put_external(balls, contacts, walls, clock, coarse, lane):
    """Put the external accelerations of a contact into its lane: mean and tilt."""
    put_external_part(balls, contacts, coarse, lane, PAIR.expected_force, EXPECTED_LOAD.mean, PAIR.mean)
    put_external_part(balls, contacts, coarse, lane, PAIR.expected_tilt, EXPECTED_LOAD.tilt, PAIR.tilt)
    if contacts.partner[lane] >= 0:
        return
    block, m, body = lane // LANES, lane % LANES, body_of(walls, -1 - contacts.partner[lane])
    gravity = clock.gravity[0], clock.gravity[1], clock.gravity[2]
    external = add(get_vector(coarse.work, block, PAIR.mean.external, m), gravity)
    change = subtract(vector(coarse.wall_velocity, body, RATE.velocity), velocity_of(clock.motions, body))
    put_vector(coarse.work, block, PAIR.mean.external, m, add_scaled(external, -1.0 / clock.step, change))


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
