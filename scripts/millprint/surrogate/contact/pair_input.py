"""Inputs of the local problem of a contact: its state at the start of the step, and the external accelerations.

External accelerations are those by everything but the contact itself: the other contacts of both balls, gravity, and
the motion of a wall.
"""

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
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    inverse_mass, other_inverse = 1.0 / balls.mass[a], 0.0
    if j >= 0:
        other = np.uint32(j)
        away = subtract(position, row(balls.position, other))
        velocity = subtract(velocity, row(balls.rate, other))
        other_omega = (balls.rate[other, 3], balls.rate[other, 4], balls.rate[other, 5])
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
        other_omega = (motions.pose[body, 6], motions.pose[body, 7], motions.pose[body, 8])
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
    lanes.put_vector(work, block, pair.AWAY, m, away)
    lanes.put_vector(work, block, pair.VELOCITY, m, velocity)
    lanes.put_vector(work, block, pair.ANGULAR_VELOCITY, m, (balls.rate[i, 3], balls.rate[i, 4], balls.rate[i, 5]))
    lanes.put_vector(work, block, pair.OTHER_ANGULAR_VELOCITY, m, other_omega)
    lanes.put_vector(work, block, pair.FIXED, m, fixed)
    lanes.put(work, block, pair.IS_PLANE, m, is_plane)
    lanes.put(work, block, pair.INVERSE_MASS, m, inverse_mass)
    lanes.put(work, block, pair.INVERSE_INERTIA, m, 1.0 / balls.inertia[a])
    lanes.put(work, block, pair.OTHER_INVERSE_INERTIA, m, other_inverse)
    # The force at the end of the last step is the first guess for this step.
    force = lanes.get_vector(contacts.lanes, block, HISTORY + lanes.LAST_SLIP, m)
    lanes.put_vector(work, block, pair.FORCE, m, force)
    lanes.put_vector(work, block, pair.EXPECTED, m, force)
    lanes.put_vector(work, block, pair.TILT, m, (0.0, 0.0, 0.0))
    return True


@inlined()
def torques_of(contacts, work, block, m, force):
    """Torques of a force at the contact point on both bodies [N m]."""
    away = lanes.get_vector(work, block, pair.AWAY, m)
    distance = math.sqrt(dot(away, away))
    arm, other = pair.arms(contacts.lanes, block, m, distance)
    lever = scale(1.0 / distance, cross(force, away))
    return scale(arm, lever), scale(other, lever)


@inner()
def expect(contacts, coarse, lane):
    """Add the predicted forces and torques of a contact, mean and tilt, to its balls."""
    block, m = lane // LANES, lane % LANES
    work, load = coarse.work, coarse.load
    i, j = contacts.ball[lane], contacts.partner[lane]
    for part in range(2):
        force = lanes.get_vector(work, block, pair.EXPECTED + 3 * part, m)
        torque, back = torques_of(contacts, work, block, m, force)
        for c in range(3):
            load[i, 6 * part + c] += force[c]
            load[i, 6 * part + 3 + c] += torque[c]
            if j >= 0:
                load[j, 6 * part + c] -= force[c]
                load[j, 6 * part + 3 + c] += back[c]


@inlined()
def load_on(load, i, part):
    """Force [N] and torque [N m] on ball i of one part: the mean (0) or its tilt (1)."""
    at = 6 * part
    return (load[i, at], load[i, at + 1], load[i, at + 2]), (load[i, at + 3], load[i, at + 4], load[i, at + 5])


@inner()
def put_external(balls, contacts, walls, clock, coarse, lane):
    """Put the external accelerations of a contact into its lane: mean and tilt."""
    block, m = lane // LANES, lane % LANES
    work, step, motions = coarse.work, clock.step, clock.motions
    i, j = contacts.ball[lane], contacts.partner[lane]
    a = balls.species[i]
    for part in range(2):
        force = lanes.get_vector(work, block, pair.EXPECTED + 3 * part, m)
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
            now = (motions.pose[body, 3], motions.pose[body, 4], motions.pose[body, 5])
            external = add_scaled(external, -1.0 / step, subtract(row(coarse.wall_velocity, body), now))
        lanes.put_vector(work, block, pair.EXTERNAL + (pair.EXTERNAL_TILT - pair.EXTERNAL) * part, m, external)
        lanes.put_vector(work, block, pair.ANGULAR + (pair.ANGULAR_TILT - pair.ANGULAR) * part, m, angular)
        lanes.put_vector(
            work, block, pair.OTHER_ANGULAR + (pair.OTHER_ANGULAR_TILT - pair.OTHER_ANGULAR) * part, m, other_angular
        )


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
    away = lanes.get_vector(work, block, pair.AWAY, m)
    velocity = lanes.get_vector(work, block, pair.VELOCITY, m)
    omega = lanes.get_vector(work, block, pair.ANGULAR_VELOCITY, m)
    other_omega = lanes.get_vector(work, block, pair.OTHER_ANGULAR_VELOCITY, m)
    distance = math.sqrt(dot(away, away))
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    begin = 0.0
    if distance > reach:
        # A contact that has separated and will touch again is two collisions.
        if lanes.get(contacts.lanes, block, HISTORY + lanes.PEAK_OVERLAP, m) > 0.0:
            coarse.ended[0] += 1.0
            lanes.put(contacts.lanes, block, HISTORY + lanes.PEAK_OVERLAP, m, 0.0)
        external = lanes.get_vector(work, block, pair.EXTERNAL, m)
        begin = touch_time(distance - reach, dot(velocity, away) / distance, dot(external, away) / distance, step)
        # Of an acceleration that grows from mean less tilt: its mean up to the touch, and what acts on the position.
        faster, farther = begin / step - 1.0, begin / step * 2.0 / 3.0 - 1.0
        tilt = lanes.get_vector(work, block, pair.EXTERNAL_TILT, m)
        away = add_scaled(add_scaled(away, begin, velocity), 0.5 * begin * begin, add_scaled(external, farther, tilt))
        velocity = add_scaled(velocity, begin, add_scaled(external, faster, tilt))
        omega = add_scaled(omega, begin, pair.tilted(work, block, pair.ANGULAR, pair.ANGULAR_TILT, m, faster))
        other_omega = add_scaled(
            other_omega,
            begin,
            pair.tilted(work, block, pair.OTHER_ANGULAR, pair.OTHER_ANGULAR_TILT, m, faster),
        )
        lanes.put_vector(work, block, pair.AWAY, m, away)
        lanes.put_vector(work, block, pair.VELOCITY, m, velocity)
        lanes.put_vector(work, block, pair.ANGULAR_VELOCITY, m, omega)
        lanes.put_vector(work, block, pair.OTHER_ANGULAR_VELOCITY, m, other_omega)
        # Nothing acts before the touch.
        lanes.put_vector(work, block, pair.FORCE, m, (0.0, 0.0, 0.0))
        lanes.put_vector(work, block, pair.TORQUE, m, (0.0, 0.0, 0.0))
        lanes.put_vector(work, block, pair.BACK, m, (0.0, 0.0, 0.0))
        lanes.put_vector(work, block, pair.SLIP, m, (0.0, 0.0, 0.0))
        lanes.put_vector(contacts.lanes, block, HISTORY + lanes.SPRING, m, (0.0, 0.0, 0.0))
    else:
        arm, other_arm = pair.arms(contacts.lanes, block, m, distance)
        normal = scale(1.0 / distance, away)
        torque, back = torques_of(contacts, work, block, m, lanes.get_vector(work, block, pair.FORCE, m))
        lanes.put_vector(work, block, pair.TORQUE, m, torque)
        lanes.put_vector(work, block, pair.BACK, m, back)
        sliding = subtract(velocity, cross(add_scaled(scale(arm, omega), other_arm, other_omega), normal))
        lanes.put_vector(work, block, pair.SLIP, m, add_scaled(sliding, -dot(sliding, normal), normal))
    lanes.put(work, block, pair.BEGIN, m, begin)
    lanes.put(work, block, pair.TAU, m, (step - begin) / coarse.substeps)
    for c in range(12):
        lanes.put(work, block, pair.IMPULSE + c, m, 0.0)
