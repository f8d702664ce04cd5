"""One step: the forces of every open contact, then kick and drift.

Velocities live half a step before positions (leapfrog). Forces need them now, so each ball also carries the velocity
expected now, the last one plus half a step of the last acceleration; it differs from the mean of the two half-step
velocities, with which a kick does its work, by the square of the step. Tangential springs grow by the trapezoidal
rule. So the energy balance closes with the square of the step.
"""

import numpy as np

from millprint.dem import lanes, state
from millprint.dem.lanes import LANES, evaluate
from millprint.dem.law import LIMIT, REACH
from millprint.dem.touching import FAR, close_contact, open_contacts, wall_away
from millprint.kernel import inlined
from millprint.mill.vectors import cross, dot, row, scale, subtract
from millprint.mill.walls import body_of, wall_velocity


@inlined()
def accumulate(array, index, vector):
    array[index, 0] += vector[0]
    array[index, 1] += vector[1]
    array[index, 2] += vector[2]


@inlined()
def gather_pair(balls, contacts, lane, block, m):
    """Put the state of two balls into their lane; returns whether they still touch."""
    i, j = contacts.ball[lane], np.uint32(contacts.partner[lane])
    away = subtract(row(balls.position, i), row(balls.position, j))
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    lanes.put_vector(contacts.lanes, block, lanes.AWAY, m, away)
    velocity = subtract(row(balls.velocity_now, i), row(balls.velocity_now, j))
    lanes.put_vector(contacts.lanes, block, lanes.VELOCITY, m, velocity)
    lanes.put_vector(contacts.lanes, block, lanes.SPIN, m, row(balls.spin_now, i))
    lanes.put_vector(contacts.lanes, block, lanes.OTHER_SPIN, m, row(balls.spin_now, j))
    return dot(away, away) < reach * reach


@inlined()
def gather_wall(balls, candidates, contacts, walls, motions, lane, block, m):
    """Put the state of a ball and the wall that it touches into their lane; returns whether they still touch."""
    i, feature = contacts.ball[lane], np.uint32(-1 - contacts.partner[lane])
    reach = lanes.get(contacts.lanes, block, lanes.LAW + REACH, m)
    position = row(balls.position, i)
    away = wall_away(walls, motions, feature, candidates.sure[contacts.slot[lane]], position, reach)
    body = body_of(walls, feature)
    lanes.put_vector(contacts.lanes, block, lanes.AWAY, m, away)
    velocity = subtract(row(balls.velocity_now, i), wall_velocity(motions, body, subtract(position, away)))
    lanes.put_vector(contacts.lanes, block, lanes.VELOCITY, m, velocity)
    lanes.put_vector(contacts.lanes, block, lanes.SPIN, m, row(balls.spin_now, i))
    turning = (motions.pose[body, 6], motions.pose[body, 7], motions.pose[body, 8])
    lanes.put_vector(contacts.lanes, block, lanes.OTHER_SPIN, m, turning)
    return away[0] < FAR


@inlined()
def load_body(walls, motions, load, position, away, feature, force, back):
    """Book what a body exerts on a ball: force [N], and torque about the body's origin [N m]."""
    body = body_of(walls, feature)
    arm = subtract(subtract(position, away), row(motions.pose, body))
    torque = subtract(cross(arm, force), back)
    for c in range(3):
        load[body, c] += force[c]
        load[body, 3 + c] += torque[c]


@inlined()
def scatter(balls, contacts, walls, clock, lane, block, m, counters):
    """Hand what came out of a lane to its partners."""
    i, j = contacts.ball[lane], contacts.partner[lane]
    force = lanes.get_vector(contacts.lanes, block, lanes.FORCE, m)
    back = lanes.get_vector(contacts.lanes, block, lanes.BACK, m)
    accumulate(balls.force, i, force)
    accumulate(balls.torque, i, lanes.get_vector(contacts.lanes, block, lanes.TORQUE, m))
    if j >= 0:
        accumulate(balls.force, np.uint32(j), scale(-1.0, force))
        accumulate(balls.torque, np.uint32(j), back)
    else:
        away = lanes.get_vector(contacts.lanes, block, lanes.AWAY, m)
        load_body(walls, clock.motions, clock.load, row(balls.position, i), away, -1 - j, force, back)
    overlap = lanes.get(contacts.lanes, block, lanes.OVERLAP, m)
    if overlap > lanes.get(contacts.lanes, block, lanes.LAW + LIMIT, m):
        counters[state.STATUS] = state.OVERLAP
        counters[state.BALL] = i
        counters[state.PARTNER] = j


@inlined()
def resolve_block(balls, candidates, contacts, laws, walls, clock, block, time, totals, counters, table):
    """The contacts of one block of lanes: those that have parted are closed, the others act on their partners."""
    first = block * LANES
    width = min(LANES, counters[state.USED] - first)
    for m in range(width):
        lane = first + m
        if contacts.slot[lane] < 0:
            continue
        if contacts.partner[lane] >= 0:
            touches = gather_pair(balls, contacts, lane, block, m)
        else:
            touches = gather_wall(balls, candidates, contacts, walls, clock.motions, lane, block, m)
        if not touches:
            close_contact(balls, candidates, contacts, laws, lane, time, totals, counters, table)
    evaluate(contacts.lanes, block, clock.step)
    for m in range(width):
        if contacts.slot[first + m] >= 0:
            scatter(balls, contacts, walls, clock, first + m, block, m, counters)


@inlined()
def book_wall_work(clock, totals):
    """Add the work of every body in this step, force . V + torque . omega, and clear the loads."""
    pose, load = clock.motions.pose, clock.load
    for body in range(load.shape[0]):
        for c in range(6):
            totals[state.WALL_WORK] += clock.step * load[body, c] * pose[body, 3 + c]
            load[body, c] = 0.0


@inlined()
def apply_forces(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table):
    """Contact forces and torques on every ball at the present positions; energies go to `totals` and the histories."""
    open_contacts(balls, candidates, contacts, laws, walls, clock.motions, counters, time)
    for block in range((counters[state.USED] + LANES - 1) // LANES):
        resolve_block(balls, candidates, contacts, laws, walls, clock, block, time, totals, counters, table)
    book_wall_work(clock, totals)


@inlined()
def kick(velocity, velocity_now, force, gain):
    """Velocities half a step on, and those expected at the next positions; the forces are cleared. Flat arrays."""
    for c in range(velocity.size):
        change = force[c] * gain[c]
        faster = velocity[c] + change
        velocity[c] = faster
        velocity_now[c] = faster + 0.5 * change
    for c in range(force.size):
        force[c] = 0.0


@inlined()
def fall_and_kick(velocity, velocity_now, force, gain, fall):
    """As `kick`, with the change by gravity in a step, `fall`."""
    for c in range(velocity.size):
        change = force[c] * gain[c] + fall[c]
        faster = velocity[c] + change
        velocity[c] = faster
        velocity_now[c] = faster + 0.5 * change
    for c in range(force.size):
        force[c] = 0.0


@inlined()
def drift(position, velocity, step):
    """Positions a step on."""
    for c in range(position.size):
        position[c] += step * velocity[c]
