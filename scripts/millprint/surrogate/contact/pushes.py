"""What a local problem begins with, and what the rest of the world does to it meanwhile."""

import math

import numpy as np

from millprint.dem import lanes
from millprint.dem.lanes import HISTORY, LANES
from millprint.dem.law import REACH
from millprint.dem.touching import FAR, wall_away
from millprint.kernel import inlined, inner
from millprint.mill.vectors import add, add_scaled, cross, dot, row, scale, subtract
from millprint.mill.walls import body_of, direction_to_laboratory, wall_velocity
from millprint.surrogate.contact import pair


@inlined()
def put3(array, block, quantity, m, vector):
    """Set a vector of a lane."""
    lanes.put_vector(array, block, quantity, m, vector)


@inner()
def gather(balls, candidates, contacts, walls, clock, coarse, lane):
    """Put what the local problem begins with into a lane; returns whether it touches, or will soon."""
    block, m = lane // LANES, lane % LANES
    work, motions = coarse.work, clock.motions
    i, j = contacts.ball[lane], contacts.partner[lane]
    position, a = row(balls.position, i), balls.species[i]
    velocity = row(balls.rate, i)
    other_spin = (0.0, 0.0, 0.0)
    fixed, is_plane = (0.0, 0.0, 0.0), 0.0
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    inverse_mass, other_inverse = 1.0 / balls.mass[a], 0.0
    if j >= 0:
        other = np.uint32(j)
        away = subtract(position, row(balls.position, other))
        velocity = subtract(velocity, row(balls.rate, other))
        other_spin = (balls.rate[other, 3], balls.rate[other, 4], balls.rate[other, 5])
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
        other_spin = (motions.pose[body, 6], motions.pose[body, 7], motions.pose[body, 8])
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
    put3(work, block, pair.AWAY, m, away)
    put3(work, block, pair.VELOCITY, m, velocity)
    put3(work, block, pair.SPIN, m, (balls.rate[i, 3], balls.rate[i, 4], balls.rate[i, 5]))
    put3(work, block, pair.OTHER_SPIN, m, other_spin)
    put3(work, block, pair.FIXED, m, fixed)
    lanes.put(work, block, pair.IS_PLANE, m, is_plane)
    lanes.put(work, block, pair.INVERSE_MASS, m, inverse_mass)
    lanes.put(work, block, pair.INVERSE_INERTIA, m, 1.0 / balls.inertia[a])
    lanes.put(work, block, pair.OTHER_INVERSE_INERTIA, m, other_inverse)
    # What the contact did at the end of the last step is a first guess of what it does now.
    force = lanes.get_vector(contacts.lanes, block, HISTORY + lanes.LAST_SLIP, m)
    put3(work, block, pair.FORCE, m, force)
    put3(work, block, pair.EXPECTED, m, force)
    put3(work, block, pair.TILT, m, (0.0, 0.0, 0.0))
    return True


@inlined()
def arms(contacts, block, m, distance):
    """Distances of both centres from the contact point [m]."""
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    is_wall = lanes.get(contacts.lanes, block, lanes.IS_WALL, m)
    difference = lanes.get(contacts.lanes, block, lanes.DIFFERENCE, m)
    arm = 0.5 * (distance + difference * reach / distance + is_wall * distance)
    return arm, distance - arm


@inlined()
def torques_of(contacts, work, block, m, force):
    """Torques of a force at the contact point on both bodies [N m]."""
    away = lanes.get_vector(work, block, pair.AWAY, m)
    distance = math.sqrt(dot(away, away))
    arm, other = arms(contacts, block, m, distance)
    lever = scale(1.0 / distance, cross(force, away))
    return scale(arm, lever), scale(other, lever)


@inner()
def expect(contacts, coarse, lane):
    """Add what a contact is expected to exert, mean and tilt, forces and torques, to its balls."""
    block, m = lane // LANES, lane % LANES
    work, push = coarse.work, coarse.push
    i, j = contacts.ball[lane], contacts.partner[lane]
    for part in range(2):
        force = lanes.get_vector(work, block, pair.EXPECTED + 3 * part, m)
        torque, back = torques_of(contacts, work, block, m, force)
        for c in range(3):
            push[i, 6 * part + c] += force[c]
            push[i, 6 * part + 3 + c] += torque[c]
            if j >= 0:
                push[j, 6 * part + c] -= force[c]
                push[j, 6 * part + 3 + c] += back[c]


@inlined()
def sums(push, i, part):
    """Force and torque of one part that push ball i."""
    at = 6 * part
    return (push[i, at], push[i, at + 1], push[i, at + 2]), (push[i, at + 3], push[i, at + 4], push[i, at + 5])


@inner()
def push_lane(balls, contacts, walls, clock, coarse, lane):
    """Accelerations of a contact by everything but itself: mean and tilt."""
    block, m = lane // LANES, lane % LANES
    work, step, motions = coarse.work, clock.step, clock.motions
    i, j = contacts.ball[lane], contacts.partner[lane]
    a = balls.species[i]
    for part in range(2):
        force = lanes.get_vector(work, block, pair.EXPECTED + 3 * part, m)
        torque, back = torques_of(contacts, work, block, m, force)
        load, twist = sums(coarse.push, i, part)
        push = scale(1.0 / balls.mass[a], subtract(load, force))
        turn = scale(1.0 / balls.inertia[a], subtract(twist, torque))
        other_turn = (0.0, 0.0, 0.0)
        if j >= 0:
            other = np.uint32(j)
            b = balls.species[other]
            load, twist = sums(coarse.push, other, part)
            push = add_scaled(push, -1.0 / balls.mass[b], add(load, force))
            other_turn = scale(1.0 / balls.inertia[b], subtract(twist, back))
        elif part == 0:
            body = body_of(walls, -1 - j)
            push = add(push, (clock.gravity[0], clock.gravity[1], clock.gravity[2]))
            now = (motions.pose[body, 3], motions.pose[body, 4], motions.pose[body, 5])
            push = add_scaled(push, -1.0 / step, subtract(row(coarse.wall_velocity, body), now))
        put3(work, block, pair.PUSH + (pair.PUSH_TILT - pair.PUSH) * part, m, push)
        put3(work, block, pair.TURN + (pair.TURN_TILT - pair.TURN) * part, m, turn)
        put3(work, block, pair.OTHER_TURN + (pair.OTHER_TURN_TILT - pair.OTHER_TURN) * part, m, other_turn)


@inlined()
def touch_time(gap, speed, push, step):
    """First time in 0 to `step` at which gap + speed t + push t^2 / 2 is nothing; `step` if there is none."""
    root = speed * speed - 2.0 * push * gap
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
    away = lanes.get_vector(work, block, pair.AWAY, m)
    velocity = lanes.get_vector(work, block, pair.VELOCITY, m)
    spin = lanes.get_vector(work, block, pair.SPIN, m)
    other_spin = lanes.get_vector(work, block, pair.OTHER_SPIN, m)
    distance = math.sqrt(dot(away, away))
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    begin = 0.0
    if distance > reach:
        # One that has come apart and will touch again is two collisions.
        if lanes.get(contacts.lanes, block, HISTORY + lanes.PEAK_OVERLAP, m) > 0.0:
            coarse.ended[0] += 1.0
            lanes.put(contacts.lanes, block, HISTORY + lanes.PEAK_OVERLAP, m, 0.0)
        push = lanes.get_vector(work, block, pair.PUSH, m)
        begin = touch_time(distance - reach, dot(velocity, away) / distance, dot(push, away) / distance, step)
        # Of an acceleration that grows from mean less tilt: its mean up to the touch, and what acts on the position.
        faster, farther = begin / step - 1.0, begin / step * 2.0 / 3.0 - 1.0
        tilt = lanes.get_vector(work, block, pair.PUSH_TILT, m)
        away = add_scaled(add_scaled(away, begin, velocity), 0.5 * begin * begin, add_scaled(push, farther, tilt))
        velocity = add_scaled(velocity, begin, add_scaled(push, faster, tilt))
        spin = add_scaled(spin, begin, pair.tilted(work, block, pair.TURN, pair.TURN_TILT, m, faster))
        other_spin = add_scaled(
            other_spin, begin, pair.tilted(work, block, pair.OTHER_TURN, pair.OTHER_TURN_TILT, m, faster)
        )
        put3(work, block, pair.AWAY, m, away)
        put3(work, block, pair.VELOCITY, m, velocity)
        put3(work, block, pair.SPIN, m, spin)
        put3(work, block, pair.OTHER_SPIN, m, other_spin)
        # Nothing acts before the touch.
        put3(work, block, pair.FORCE, m, (0.0, 0.0, 0.0))
        put3(work, block, pair.TORQUE, m, (0.0, 0.0, 0.0))
        put3(work, block, pair.BACK, m, (0.0, 0.0, 0.0))
        put3(work, block, pair.SLIP, m, (0.0, 0.0, 0.0))
        put3(contacts.lanes, block, HISTORY + lanes.SPRING, m, (0.0, 0.0, 0.0))
    else:
        arm, other_arm = arms(contacts, block, m, distance)
        normal = scale(1.0 / distance, away)
        torque, back = torques_of(contacts, work, block, m, lanes.get_vector(work, block, pair.FORCE, m))
        put3(work, block, pair.TORQUE, m, torque)
        put3(work, block, pair.BACK, m, back)
        sliding = subtract(velocity, cross(add_scaled(scale(arm, spin), other_arm, other_spin), normal))
        put3(work, block, pair.SLIP, m, add_scaled(sliding, -dot(sliding, normal), normal))
    lanes.put(work, block, pair.BEGIN, m, begin)
    lanes.put(work, block, pair.TAU, m, (step - begin) / coarse.substeps)
    for c in range(12):
        lanes.put(work, block, pair.IMPULSE + c, m, 0.0)
