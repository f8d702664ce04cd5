"""One step: the forces of every open contact, then kick and drift.

Velocities live half a step before positions (leapfrog). Forces need them now, so each ball also carries the velocity
expected now, the last one plus half a step of the last acceleration; it differs from the mean of the two half-step
velocities, with which a kick does its work, by the square of the step. Tangential springs grow by the trapezoidal
rule. So the energy balance closes with the square of the step.
"""

import numpy as np

from millprint.dem.contact import evaluate
from millprint.dem.contact_events import FAR, close_contact, open_contacts, wall_away
from millprint.dem.lanes import get, get_present, get_vector, put_present
from millprint.dem.layout import COUNTER, GROUP, GROUPED_TO, LANE, LANES, LOAD, LOAD_WIDTH, PRESENT, RATE, TOTAL
from millprint.mill.motion import POSE
from millprint.mill.vectors import cross, dot, row, scale, subtract, vector
from millprint.mill.walls import body_of, wall_velocity
from millprint.run.kernel import inlined


@inlined()
def add_load(load, i, force, torque):
    """Add a force [N] and a torque [N m] to what acts on ball or body i."""
    for c in range(3):
        load[i, LOAD.force.x + c] += force[c]
        load[i, LOAD.torque.x + c] += torque[c]


@inlined()
def gather_pair(balls, contacts, present, lane, block, at, m):
    """Put the state of two balls into their lane; returns whether they still touch."""
    i, j = contacts.ball[lane], np.uint32(contacts.partner[lane])
    away = subtract(row(balls.position, i), row(balls.position, j))
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    put_present(present, at, PRESENT.away, m, away)
    velocity = subtract(row(balls.rate_now, i), row(balls.rate_now, j))
    put_present(present, at, PRESENT.velocity, m, velocity)
    put_present(present, at, PRESENT.angular_velocity, m, vector(balls.rate_now, i, RATE.angular_velocity))
    put_present(present, at, PRESENT.other_angular_velocity, m, vector(balls.rate_now, j, RATE.angular_velocity))
    return dot(away, away) < reach * reach


@inlined()
def gather_wall(balls, candidates, contacts, present, walls, motions, lane, block, at, m):
    """Put the state of a ball and the wall that it touches into their lane; returns whether they still touch."""
    i, body = contacts.ball[lane], body_of(walls, -1 - contacts.partner[lane])
    reach = get(contacts.lanes, block, LANE.law.reach, m)
    position = row(balls.position, i)
    away = wall_away(walls, candidates, motions, np.uint32(contacts.slot[lane]), body, position, reach)
    put_present(present, at, PRESENT.away, m, away)
    velocity = subtract(row(balls.rate_now, i), wall_velocity(motions, body, subtract(position, away)))
    put_present(present, at, PRESENT.velocity, m, velocity)
    put_present(present, at, PRESENT.angular_velocity, m, vector(balls.rate_now, i, RATE.angular_velocity))
    turning = vector(motions.pose, body, POSE.angular_velocity)
    put_present(present, at, PRESENT.other_angular_velocity, m, turning)
    return away[0] < FAR


@inlined()
def gather(balls, candidates, contacts, present, walls, motions, lane, block, at, m):
    """Put the state of both partners into their lane of present row `at`; returns whether they still touch."""
    if contacts.partner[lane] >= 0:
        return gather_pair(balls, contacts, present, lane, block, at, m)
    return gather_wall(balls, candidates, contacts, present, walls, motions, lane, block, at, m)


@inlined()
def load_body(walls, motions, load, position, away, feature, force, back):
    """Add the force [N] of a body on a ball, and its torque about the body's origin [N m], to the body's loads."""
    body = body_of(walls, feature)
    arm = subtract(subtract(position, away), row(motions.pose, body))
    add_load(load, body, force, subtract(cross(arm, force), back))


@inlined()
def scatter(balls, contacts, present, walls, motions, load, body_load, lane, block, at, m):
    """Add the forces of a lane to its partners: to the loads of balls (n, 6) and of bodies (bodies, 6)."""
    i, j = contacts.ball[lane], contacts.partner[lane]
    force = get_vector(contacts.lanes, block, LANE.force, m)
    back = get_present(present, at, PRESENT.other_torque, m)
    add_load(load, i, force, get_present(present, at, PRESENT.torque, m))
    if j >= 0:
        add_load(load, np.uint32(j), scale(-1.0, force), back)
    else:
        away = get_present(present, at, PRESENT.away, m)
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
def gather_open(balls, candidates, contacts, laws, walls, clock, block, at, time, totals, counters, table):
    """Gather the contacts of a block that still touch; the others are closed."""
    first = np.uint64(block * LANES)
    for m in range(width_in_use(counters, block)):
        lane = first + m
        if contacts.slot[lane] < 0:
            continue
        if not gather(balls, candidates, contacts, contacts.present, walls, clock.motions, lane, block, at, m):
            close_contact(balls, candidates, contacts, laws, walls, lane, time, totals, counters, table)


@inlined()
def scatter_open(balls, contacts, walls, clock, counters, block, at):
    """Add the forces of the open contacts of a block to their partners."""
    first = np.uint64(block * LANES)
    for m in range(width_in_use(counters, block)):
        if contacts.slot[first + m] >= 0:
            lane, motions, present = first + m, clock.motions, contacts.present
            scatter(balls, contacts, present, walls, motions, balls.load, clock.load, lane, block, at, m)


@inlined()
def resolve_blocks(balls, candidates, contacts, laws, mark, walls, clock, begin, end, time, totals, counters, table):
    """The contacts of blocks begin to end: those that have parted are closed, the others act on their partners."""
    for block in range(begin, end):
        at = block - begin
        gather_open(balls, candidates, contacts, laws, walls, clock, block, at, time, totals, counters, table)
    evaluate(mark, contacts.lanes, contacts.present, begin, end, clock.step)
    for block in range(begin, end):
        scatter_open(balls, contacts, walls, clock, counters, block, block - begin)


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
def apply_forces(balls, candidates, contacts, laws, mark, walls, clock, time, totals, counters, table):
    """Contact forces and torques on every ball at the present positions; energies go to `totals` and the histories."""
    open_contacts(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)
    blocks = blocks_in_use(counters)
    group = GROUP if blocks <= GROUPED_TO else 1
    for begin in range(0, blocks, group):
        end = min(begin + group, blocks)
        resolve_blocks(balls, candidates, contacts, laws, mark, walls, clock, begin, end, time, totals, counters, table)
    book_wall_work(clock, totals)


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
