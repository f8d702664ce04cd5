"""One step: the forces of every open contact, then kick and drift.

Velocities live half a step before positions (leapfrog). Forces need them now, so each ball also carries the velocity
expected now, the last one plus half a step of the last acceleration; it differs from the mean of the two half-step
velocities, with which a kick does its work, by the square of the step. Tangential springs grow by the trapezoidal
rule. So the energy balance closes with the square of the step.
"""

import numpy as np

from millprint.dem.contact import evaluate
from millprint.dem.lanes import get, get_vector, put_vector
from millprint.dem.layout import COUNTER, LANE, LANES, LOAD, LOAD_WIDTH, RATE, TOTAL
from millprint.dem.profile import PROFILE, lap
from millprint.dem.touching import FAR, close_contact, open_contacts, wall_away
from millprint.kernel import inlined
from millprint.mill.pose import POSE
from millprint.mill.vectors import cross, dot, row, scale, subtract, vector
from millprint.mill.walls import body_of, wall_velocity


@inlined()
def add_load(load, i, force, torque):
    """Add a force [N] and a torque [N m] to what acts on ball or body i."""
    for c in range(3):
        load[i, LOAD.force.x + c] += force[c]
        load[i, LOAD.torque.x + c] += torque[c]


@inlined()
def gather_pair(balls, contacts, lane, block, m):
    """Put the state of two balls into their lane; returns whether they still touch."""
    i, j = contacts.ball[lane], np.uint32(contacts.partner[lane])
    away = subtract(row(balls.position, i), row(balls.position, j))
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    put_vector(contacts.lanes, block, LANE.away, m, away)
    velocity = subtract(row(balls.rate_now, i), row(balls.rate_now, j))
    put_vector(contacts.lanes, block, LANE.velocity, m, velocity)
    put_vector(contacts.lanes, block, LANE.angular_velocity, m, vector(balls.rate_now, i, RATE.angular_velocity))
    put_vector(contacts.lanes, block, LANE.other_angular_velocity, m, vector(balls.rate_now, j, RATE.angular_velocity))
    return dot(away, away) < reach * reach


@inlined()
def gather_wall(balls, candidates, contacts, walls, motions, lane, block, m):
    """Put the state of a ball and the wall that it touches into their lane; returns whether they still touch."""
    i, body = contacts.ball[lane], body_of(walls, -1 - contacts.partner[lane])
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    position = row(balls.position, i)
    away = wall_away(walls, candidates, motions, np.uint32(contacts.slot[lane]), body, position, reach)
    put_vector(contacts.lanes, block, LANE.away, m, away)
    velocity = subtract(row(balls.rate_now, i), wall_velocity(motions, body, subtract(position, away)))
    put_vector(contacts.lanes, block, LANE.velocity, m, velocity)
    put_vector(contacts.lanes, block, LANE.angular_velocity, m, vector(balls.rate_now, i, RATE.angular_velocity))
    turning = vector(motions.pose, body, POSE.angular_velocity)
    put_vector(contacts.lanes, block, LANE.other_angular_velocity, m, turning)
    return away[0] < FAR


@inlined()
def gather(balls, candidates, contacts, walls, motions, lane, block, m):
    """Put the state of both partners into their lane; returns whether they still touch."""
    if contacts.partner[lane] >= 0:
        return gather_pair(balls, contacts, lane, block, m)
    return gather_wall(balls, candidates, contacts, walls, motions, lane, block, m)


@inlined()
def load_body(walls, motions, load, position, away, feature, force, back):
    """Add the force [N] of a body on a ball, and its torque about the body's origin [N m], to the body's loads."""
    body = body_of(walls, feature)
    arm = subtract(subtract(position, away), row(motions.pose, body))
    add_load(load, body, force, subtract(cross(arm, force), back))


@inlined()
def scatter(balls, contacts, walls, motions, load, body_load, lane, block, m):
    """Add the forces of a lane to its partners: to the loads of balls (n, 6) and of bodies (bodies, 6)."""
    i, j = contacts.ball[lane], contacts.partner[lane]
    force = get_vector(contacts.lanes, block, LANE.force, m)
    back = get_vector(contacts.lanes, block, LANE.other_torque, m)
    add_load(load, i, force, get_vector(contacts.lanes, block, LANE.torque, m))
    if j >= 0:
        add_load(load, np.uint32(j), scale(-1.0, force), back)
    else:
        away = get_vector(contacts.lanes, block, LANE.away, m)
        load_body(walls, motions, body_load, row(balls.position, i), away, -1 - j, force, back)


@inlined()
def width_in_use(counters, block):
    """Number of lanes of a block that have been in use."""
    return np.uint64(min(LANES, counters[COUNTER.used] - block * LANES))


@inlined()
def blocks_in_use(counters):
    """The number of blocks of lanes that have been in use."""
    return (counters[COUNTER.used] + LANES - 1) // LANES


@inlined()
def resolve_block(balls, candidates, contacts, laws, walls, clock, block, time, totals, counters, table, profile):
    """The contacts of one block of lanes: those that have parted are closed, the others act on their partners."""
    first = np.uint64(block * LANES)
    width = width_in_use(counters, block)
    for m in range(width):
        lane = first + m
        if contacts.slot[lane] < 0:
            continue
        if not gather(balls, candidates, contacts, walls, clock.motions, lane, block, m):
            close_contact(balls, candidates, contacts, laws, lane, time, totals, counters, table)
    lap(profile, PROFILE.gather)
    evaluate(contacts.lanes, block, clock.step)
    lap(profile, PROFILE.law)
    for m in range(width):
        if contacts.slot[first + m] >= 0:
            scatter(balls, contacts, walls, clock.motions, balls.load, clock.load, first + m, block, m)
    lap(profile, PROFILE.scatter)


@inlined()
def book_wall_work(clock, totals):
    """Add the work of every body in this step, force . V + torque . omega, and clear the loads."""
    pose, load = clock.motions.pose, clock.load
    for body in range(load.shape[0]):
        for c in range(3):
            totals[TOTAL.wall_work_J] += clock.step * load[body, LOAD.force.x + c] * pose[body, POSE.velocity.x + c]
        for c in range(3):
            turning = pose[body, POSE.angular_velocity.x + c]
            totals[TOTAL.wall_work_J] += clock.step * load[body, LOAD.torque.x + c] * turning
        for c in range(LOAD_WIDTH):
            load[body, c] = 0.0


@inlined()
def apply_forces(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table, profile):
    """Contact forces and torques on every ball at the present positions; energies go to `totals` and the histories."""
    open_contacts(balls, candidates, contacts, laws, walls, clock.motions, counters, time)
    lap(profile, PROFILE.candidates)
    for block in range(blocks_in_use(counters)):
        resolve_block(balls, candidates, contacts, laws, walls, clock, block, time, totals, counters, table, profile)
    book_wall_work(clock, totals)
    lap(profile, PROFILE.scatter)


@inlined()
def kick(rate, rate_now, load, gain, fall):
    """Rates half a step on, and those expected at the next positions; the loads are cleared. Flat arrays."""
    for c in range(rate.size):
        change = load[c] * gain[c] + fall[c]
        faster = rate[c] + change
        rate[c] = faster
        rate_now[c] = faster + 0.5 * change
    for c in range(load.size):
        load[c] = 0.0


@inlined()
def drift(position, rate, step):
    """Positions a step on."""
    for i in range(position.shape[0]):
        for c in range(3):
            position[i, c] += step * rate[i, c]
