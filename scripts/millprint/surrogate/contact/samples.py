"""States of our DEM at coarse steps, and what every contact does next: the training data of the network."""

import math

from millprint.dem import lanes, state
from millprint.dem.lanes import HISTORY, LANES
from millprint.dem.law import KN, MU, REACH
from millprint.dem.touching import listed
from millprint.kernel import inlined, inner, kernel
from millprint.mill.vectors import dot
from millprint.surrogate.contact import pair, trace
from millprint.surrogate.contact.step import gather_all
from millprint.surrogate.contact.trace import advance_traced

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
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] < 0:
            continue
        block, m = lane // LANES, lane % LANES
        to_contacts.kept_ball[kept] = contacts.ball[lane]
        to_contacts.kept_partner[kept] = contacts.partner[lane]
        for c in range(lanes.HISTORY_COLUMNS):
            to_contacts.kept_history[kept, c] = 0.0
        for c in range(3):
            spring = lanes.get(contacts.lanes, block, HISTORY + lanes.SPRING + c, m)
            to_contacts.kept_history[kept, lanes.SPRING + c] = spring
            to_contacts.kept_history[kept, lanes.LAST_SLIP + c] = lanes.get(contacts.lanes, block, lanes.FORCE + c, m)
        kept += 1
    to_counters[state.ASIDE] = kept


@kernel()
def forget(candidates, contacts, counters):
    """Drop all lists and open contacts; they are made again from the contacts that are set aside."""
    for k in range(listed(candidates)):
        candidates.lane[k] = -1
    for lane in range(contacts.slot.size):
        contacts.slot[lane] = -1
    counters[state.USED] = counters[state.FREE] = counters[state.REBUILDS] = 0


@inlined()
def put_three(rows, at, column, array, block, quantity, m):
    """Copy a vector of a lane into three columns of a row."""
    for c in range(3):
        rows[at, column + c] = lanes.get(array, block, quantity + c, m)


@inner()
def write_sample(balls, contacts, clock, coarse, lane, rows, at):
    """Write the inputs of the network for a contact."""
    block, m = lane // LANES, lane % LANES
    work = coarse.work
    i, j = contacts.ball[lane], contacts.partner[lane]
    rows[at, FIRST], rows[at, SECOND] = i, max(j, -1)
    for column, quantity in (
        (AWAY, pair.AWAY), (VELOCITY, pair.VELOCITY), (ANGULAR_VELOCITY, pair.ANGULAR_VELOCITY),
        (OTHER_ANGULAR_VELOCITY, pair.OTHER_ANGULAR_VELOCITY), (FORCE, pair.FORCE),
    ):  # fmt: skip
        put_three(rows, at, column, work, block, quantity, m)
    away, law = lanes.get_vector(work, block, pair.AWAY, m), contacts.lanes
    arm, other = pair.arms(law, block, m, math.sqrt(dot(away, away)))
    rows[at, ARM], rows[at, OTHER_ARM] = arm, other
    rows[at, GAP] = math.sqrt(dot(away, away)) - lanes.get(law, block, lanes.LAW + REACH, m)
    rows[at, STIFFNESS] = lanes.get(law, block, lanes.LAW + KN, m)
    rows[at, FRICTION] = lanes.get(law, block, lanes.LAW + MU, m)
    rows[at, INVERSE_MASS] = 1.0 / balls.mass[balls.species[i]]
    rows[at, OTHER_INVERSE_MASS] = lanes.get(work, block, pair.INVERSE_MASS, m) - rows[at, INVERSE_MASS]
    rows[at, INVERSE_INERTIA] = lanes.get(work, block, pair.INVERSE_INERTIA, m)
    rows[at, OTHER_INVERSE_INERTIA] = lanes.get(work, block, pair.OTHER_INVERSE_INERTIA, m)
    rows[at, IS_WALL] = lanes.get(law, block, lanes.IS_WALL, m)
    rows[at, STEP] = clock.step
    # No contact force is predicted here, so that this is the acceleration without contacts.
    put_three(rows, at, BASE, work, block, pair.EXTERNAL, m)


@kernel()
def sample_step(dem, coarse_groups, coarse, followed, rows, at, fine_steps):
    """Write the contacts of the present DEM state to `rows` from `at` on, advance the DEM by a coarse step, and add
    what they did; returns the next free row.

    dem and coarse_groups: (balls, candidates, contacts, laws, walls, clock, totals, counters, table[, recorder]).
    """
    balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder = dem
    copy, to_candidates, to_contacts, to_laws, to_walls, to_clock, to_totals, to_counters, to_table = coarse_groups
    for i in range(balls.species.size):
        for c in range(6):
            copy.rate[i, c] = balls.rate_now[i, c]
        for c in range(3):
            copy.position[i, c] = balls.position[i, c]
    forget(to_candidates, to_contacts, to_counters)
    put_contacts_aside(contacts, counters, to_contacts, to_counters)
    time = counters[state.STEP] * clock.step
    gather_all(
        copy, to_candidates, to_contacts, to_laws, to_walls, to_clock, coarse, to_totals, to_counters, to_table, time
    )
    if to_counters[state.STATUS] != state.RUNNING:
        return at
    put_bare_accelerations(to_contacts, to_walls, to_clock, coarse, to_counters)
    begin = at
    for lane in range(to_counters[state.USED]):
        if to_contacts.slot[lane] >= 0 and at < rows.shape[0]:
            write_sample(copy, to_contacts, to_clock, coarse, lane, rows, at)
            mark(followed, to_contacts, lane, at - begin)
            for c in range(trace.COLUMNS):
                followed.value[at - begin, c] = 0.0
            at += 1
    advance_traced(
        balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder, fine_steps, followed
    )
    for row in range(begin, at):
        for c in range(6):
            rows[row, IMPULSE + c] = followed.value[row - begin, trace.IMPULSE + c]
        for c in range(4):
            works = followed.value[row - begin, trace.WORKS + c] - followed.value[row - begin, trace.WORKS_BEFORE + c]
            rows[row, WORKS + c] = works
    for lane in range(to_counters[state.USED]):
        if to_contacts.slot[lane] >= 0:
            mark(followed, to_contacts, lane, -1)
    return at


@inlined()
def mark(followed, contacts, lane, row):
    """Store the row of a contact's sample."""
    partner = contacts.partner[lane]
    balls = followed.place.shape[0]
    followed.place[contacts.ball[lane], partner if partner >= 0 else balls - 1 - partner] = row


@inner()
def put_bare_accelerations(contacts, walls, clock, coarse, counters):
    """Gravity less the wall's own acceleration, of contacts with walls; nothing of pairs."""
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] < 0:
            continue
        block, m = lane // LANES, lane % LANES
        partner = contacts.partner[lane]
        for c in range(3):
            push = 0.0
            if partner < 0:
                body = walls.body[-1 - partner]
                change = coarse.wall_velocity[body, c] - clock.motions.pose[body, 3 + c]
                push = clock.gravity[c] - change / clock.step
            lanes.put(coarse.work, block, pair.EXTERNAL + c, m, push)
