"""States of our DEM at coarse steps, and what every contact does next: the training data of the network."""

import math

from millprint.dem.advance import advance
from millprint.dem.contact import arms_of
from millprint.dem.lanes import get, get_of, get_vector, put
from millprint.dem.layout import COUNTER, HISTORY, HISTORY_WIDTH, LANE, LANES, RATE, RATE_WIDTH, STATUS, TRACE
from millprint.dem.touching import listed
from millprint.dem.trace import begin_trace, place_of
from millprint.kernel import inlined, inner, kernel
from millprint.mill.pose import POSE
from millprint.mill.vectors import dot
from millprint.surrogate.contact.pair import LAST_FORCE, PAIR
from millprint.surrogate.contact.step import gather_all

# Columns of a sample: balls (the second -1 for a wall); relative position and velocity, angular velocities, force at
# the start [N], accelerations by gravity and the wall's own [m/s2]; arms and reach [m], stiffness, friction, inverse
# masses and moments of inertia of both, 1 for a wall; step [s]. Then the labels: impulse, moment, works.
FIRST, SECOND, AWAY, VELOCITY, ANGULAR_VELOCITY, OTHER_ANGULAR_VELOCITY, FORCE, BASE = 0, 1, 2, 5, 8, 11, 14, 17
ARM, OTHER_ARM, GAP, STIFFNESS, FRICTION, INVERSE_MASS, OTHER_INVERSE_MASS, INVERSE_INERTIA, OTHER_INVERSE_INERTIA = (
    20, 21, 22, 23, 24, 25, 26, 27, 28,
)  # fmt: skip
IS_WALL, STEP, IMPULSE, MOMENT, WORKS = 29, 30, 31, 34, 37
SAMPLE_COLUMNS = 41


@kernel()
def put_contacts_aside(contacts, counters, to_contacts, to_counters):
    """Set the DEM's open contacts aside in a coarse state, with springs and present forces, works at nothing."""
    kept = 0
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] < 0:
            continue
        to_contacts.kept_ball[kept] = contacts.ball[lane]
        to_contacts.kept_partner[kept] = contacts.partner[lane]
        for c in range(HISTORY_WIDTH):
            to_contacts.kept_history[kept, c] = 0.0
        for c in range(3):
            spring = get_of(contacts, lane, LANE.history.spring.x + c)
            to_contacts.kept_history[kept, HISTORY.spring.x + c] = spring
            to_contacts.kept_history[kept, LAST_FORCE.x + c] = get_of(contacts, lane, LANE.force.x + c)
        kept += 1
    to_counters[COUNTER.aside] = kept


@kernel()
def forget(candidates, contacts, counters):
    """Drop all lists and open contacts; they are made again from the contacts that are set aside."""
    for k in range(listed(candidates)):
        candidates.lane[k] = -1
    for lane in range(contacts.slot.size):
        contacts.slot[lane] = -1
    counters[COUNTER.used] = counters[COUNTER.free] = counters[COUNTER.rebuilds] = 0


@inlined()
def put_three(rows, at, column, array, block, quantity, m):
    """Copy a vector of a lane into three columns of a row."""
    for c in range(3):
        rows[at, column + c] = get(array, block, quantity.x + c, m)


@inner()
def write_sample(balls, contacts, clock, coarse, lane, rows, at):
    """Write the inputs of the network for a contact."""
    block, m = lane // LANES, lane % LANES
    work = coarse.work
    i, j = contacts.ball[lane], contacts.partner[lane]
    rows[at, FIRST], rows[at, SECOND] = i, max(j, -1)
    for column, quantity in (
        (AWAY, PAIR.away), (VELOCITY, PAIR.velocity), (ANGULAR_VELOCITY, PAIR.angular_velocity),
        (OTHER_ANGULAR_VELOCITY, PAIR.other_angular_velocity), (FORCE, PAIR.force),
    ):  # fmt: skip
        put_three(rows, at, column, work, block, quantity, m)
    away, law = get_vector(work, block, PAIR.away, m), contacts.lanes
    arm, other = arms_of(law, block, m, math.sqrt(dot(away, away)))
    rows[at, ARM], rows[at, OTHER_ARM] = arm, other
    rows[at, GAP] = math.sqrt(dot(away, away)) - get(law, block, LANE.law.reach, m)
    rows[at, STIFFNESS] = get(law, block, LANE.law.normal_stiffness, m)
    rows[at, FRICTION] = get(law, block, LANE.law.friction, m)
    rows[at, INVERSE_MASS] = 1.0 / balls.mass[balls.species[i]]
    rows[at, OTHER_INVERSE_MASS] = get(work, block, PAIR.inverse_mass, m) - rows[at, INVERSE_MASS]
    rows[at, INVERSE_INERTIA] = get(work, block, PAIR.inverse_inertia, m)
    rows[at, OTHER_INVERSE_INERTIA] = get(work, block, PAIR.other_inverse_inertia, m)
    rows[at, IS_WALL] = get(law, block, LANE.is_wall, m)
    rows[at, STEP] = clock.step
    # No contact force is predicted here, so that this is the acceleration without contacts.
    put_three(rows, at, BASE, work, block, PAIR.mean.external, m)


@kernel()
def sample_step(dem, coarse_groups, coarse, followed, rows, at, fine_steps):
    """Write the contacts of the present DEM state to `rows` from `at` on, advance the DEM by a coarse step, and add
    what they did; returns the next free row.

    dem and coarse_groups: (balls, candidates, contacts, laws, walls, clock, totals, counters, table[, recorder]).
    """
    balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder = dem
    copy, to_candidates, to_contacts, to_laws, to_walls, to_clock, to_totals, to_counters, to_table = coarse_groups
    for i in range(balls.species.size):
        for c in range(RATE_WIDTH):
            copy.rate[i, c] = balls.rate_now[i, c]
        for c in range(3):
            copy.position[i, c] = balls.position[i, c]
    forget(to_candidates, to_contacts, to_counters)
    put_contacts_aside(contacts, counters, to_contacts, to_counters)
    time = counters[COUNTER.step] * clock.step
    gather_all(
        copy, to_candidates, to_contacts, to_laws, to_walls, to_clock, coarse, to_totals, to_counters, to_table, time
    )
    if to_counters[COUNTER.status] != STATUS.running:
        return at
    put_bare_accelerations(to_contacts, to_walls, to_clock, coarse, to_counters)
    begin = at
    for lane in range(to_counters[COUNTER.used]):
        if to_contacts.slot[lane] >= 0 and at < rows.shape[0]:
            write_sample(copy, to_contacts, to_clock, coarse, lane, rows, at)
            mark(followed, to_contacts, lane, at - begin)
            for c in range(followed.value.shape[1]):
                followed.value[at - begin, c] = 0.0
            at += 1
    begin_trace(contacts, counters, followed)
    advance(
        balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder,
        counters[COUNTER.step] + fine_steps - 1, None, followed, None,
    )  # fmt: skip
    for row in range(begin, at):
        done = followed.value[row - begin]
        for c in range(3):
            rows[row, IMPULSE + c] = done[TRACE.impulse.x + c]
            rows[row, MOMENT + c] = done[TRACE.moment.x + c]
        for c in range(len(TRACE.works)):
            rows[row, WORKS + c] = done[TRACE.works.normal + c] - done[TRACE.works_before.normal + c]
    for lane in range(to_counters[COUNTER.used]):
        if to_contacts.slot[lane] >= 0:
            mark(followed, to_contacts, lane, -1)
    return at


@inlined()
def mark(followed, contacts, lane, row):
    """Store the row of a contact's sample."""
    followed.place[contacts.ball[lane], place_of(followed, contacts.partner[lane])] = row


@inner()
def put_bare_accelerations(contacts, walls, clock, coarse, counters):
    """Gravity less the wall's own acceleration, of contacts with walls; nothing of pairs."""
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] < 0:
            continue
        block, m = lane // LANES, lane % LANES
        partner = contacts.partner[lane]
        for c in range(3):
            push = 0.0
            if partner < 0:
                body = walls.body[-1 - partner]
                now = clock.motions.pose[body, POSE.velocity.x + c]
                change = coarse.wall_velocity[body, RATE.velocity.x + c] - now
                push = clock.gravity[c] - change / clock.step
            put(coarse.work, block, PAIR.mean.external.x + c, m, push)
