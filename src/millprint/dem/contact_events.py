"""Contacts begin, pass on and end.

A candidate that comes within reach opens a contact in a free lane; one that parts closes. On a wall, a contact passes
from feature to feature of a patch (mill.wall_features) with its whole history: where a ball touches a feature anew, and
is already in contact with a neighbouring one that it leaves or that is now farther away, the contact goes on there.
"""

import math

import numpy as np

from millprint.dem.law import CROWD, FEW, choose_by_speed, get_of, get_vector, put_of, put_vector
from millprint.dem.layout import (
    COLLISION,
    COUNTER,
    ENDED,
    HISTORY_WIDTH,
    LANE,
    LANE_HISTORY,
    LANE_LAW,
    LANES,
    LAW,
    LAW_WIDTH,
    STATUS,
    TOTAL,
)
from millprint.mill.borders import SMOOTH_TURN
from millprint.mill.vectors import add_scaled, cross, dot, row, scale, subtract
from millprint.mill.wall_features import JOINT
from millprint.mill.walls import (
    PLANE,
    SURFACE,
    body_of,
    direction_to_body,
    direction_to_laboratory,
    joint_of,
    to_body,
    touch,
    wall_velocity,
)
from millprint.run.kernel import inlined, inner, merged

# Farther than any contact [m].
FAR = 1e300

# Two features of a patch that meet in a vertex are one wall where their directions differ by less.
COS_SMOOTH_TURN = math.cos(SMOOTH_TURN)

# The trigger of a candidate that is open, and of one that is open and not among the near ones (dem.neighbours).
OPEN, UNLISTED = -1.0, -2.0


@inlined()
def listed(candidates):
    """The number of candidates."""
    return candidates.first_wall[candidates.first_wall.shape[0] - 1, candidates.first_wall.shape[1] - 1]


@inlined()
def take_lane(contacts, counters):
    """A free lane, the last one freed first; there is one for every candidate."""
    if counters[COUNTER.free] > 0:
        counters[COUNTER.free] -= 1
        return contacts.free[counters[COUNTER.free]]
    counters[COUNTER.used] += 1
    return counters[COUNTER.used] - 1


@inner()
def occupy(balls, candidates, contacts, laws, counters, k):
    """Give candidate k a lane with the law of its kind; returns the lane."""
    lane = take_lane(contacts, counters)
    settle(balls, candidates, contacts, laws, k, lane)
    return lane


@inner()
def settle(balls, candidates, contacts, laws, k, lane):
    """Let a lane hold the contact of candidate k, with the law of its kind."""
    i, j = candidates.ball[k], candidates.partner[k]
    contacts.ball[lane], contacts.partner[lane], contacts.slot[lane] = i, j, k
    candidates.lane[k] = lane
    candidates.trigger[k] = OPEN
    a = balls.species[i]
    b = balls.species[max(j, 0)]
    difference = balls.radius[a] - balls.radius[b] if j >= 0 else 0.0
    surface = laws.surface[-1 - j] if j < 0 else SURFACE.rough
    put_of(contacts, lane, LANE.is_wall, 1.0 if j < 0 else 0.0)
    put_of(contacts, lane, LANE.radius_difference, difference)
    for c in range(LAW_WIDTH):
        put_of(contacts, lane, LANE_LAW + c, laws.pair[a, b, c] if j >= 0 else laws.wall[surface, a, c])


@inner()
def open_contact(balls, candidates, contacts, laws, counters, k, time, approach, slip):
    """Begin a contact at `time` [s], its partners nearing each other at `approach`, and slipping at `slip` [m/s]."""
    lane = occupy(balls, candidates, contacts, laws, counters, k)
    for c in range(HISTORY_WIDTH):
        put_of(contacts, lane, LANE_HISTORY + c, 0.0)
    put_of(contacts, lane, LANE.history.resistance, 1.0)
    put_of(contacts, lane, LANE.history.start, time)
    put_of(contacts, lane, LANE.history.approach_speed, approach)
    put_of(contacts, lane, LANE.history.slip_speed, slip)
    put_of(contacts, lane, LANE.history.number, counters[COUNTER.opened])
    counters[COUNTER.opened] += 1
    choose_by_speed(laws.by_speed, contacts, laws, lane)


@inlined()
def book_works(contacts, lane, totals):
    """Add the works of a contact to the running totals."""
    works = LANE.history.works
    totals[TOTAL.normal_damping_J] += get_of(contacts, lane, works.normal)
    totals[TOTAL.tangential_damping_J] += get_of(contacts, lane, works.damping)
    totals[TOTAL.tangential_work_J] += get_of(contacts, lane, works.tangential)
    totals[TOTAL.rolling_J] += get_of(contacts, lane, works.rolling)


@inlined()
def write_collision(contacts, walls, lane, time, ended, counters, table):
    """Append a contact to the table of collisions, if that has rows; ended: of layout.RowEnds."""
    if table.value.shape[0] == 0:
        return
    at = counters[COUNTER.records]
    counters[COUNTER.records] += 1
    partner = contacts.partner[lane]
    table.first[at] = contacts.ball[lane]
    table.second[at] = partner if partner >= 0 else -1 - walls.patch[-1 - partner]
    if table.facet.size > 0:
        table.facet[at] = max(-1 - partner, -1)
    table.contact[at] = int(get_of(contacts, lane, LANE.history.number))
    table.ended[at] = ended
    value, history = table.value[at], LANE.history
    start = get_of(contacts, lane, history.start)
    value[COLLISION.start_s] = start
    value[COLLISION.duration_s] = time - start
    value[COLLISION.approach_speed_m_s] = get_of(contacts, lane, history.approach_speed)
    value[COLLISION.slip_speed_m_s] = get_of(contacts, lane, history.slip_speed)
    value[COLLISION.peak_force_N] = get_of(contacts, lane, history.peak_force)
    value[COLLISION.peak_overlap_m] = get_of(contacts, lane, history.peak_overlap)
    value[COLLISION.normal_J] = get_of(contacts, lane, history.works.normal)
    value[COLLISION.damping_J] = get_of(contacts, lane, history.works.damping)
    value[COLLISION.tangential_J] = get_of(contacts, lane, history.works.tangential)
    value[COLLISION.rolling_J] = get_of(contacts, lane, history.works.rolling)


@inlined()
def check_overlap(contacts, lane, counters):
    """Set the status if a contact has overlapped too much at any time."""
    if get_of(contacts, lane, LANE.history.peak_overlap) > get_of(contacts, lane, LANE.law.largest_overlap):
        counters[COUNTER.status] = STATUS.overlap
        counters[COUNTER.ball] = contacts.ball[lane]
        counters[COUNTER.partner] = contacts.partner[lane]


@inner()
def check_overlaps(contacts, counters):
    """Set the status if any open contact has overlapped too much."""
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            check_overlap(contacts, lane, counters)


@inner()
def share_resistance(balls, contacts, counters):
    """Share what rolling friction may take of a ball's turning in a step among its contacts (law.STOP_SHARE).

    Of two balls, the one with more contacts decides. Every SHARE_EVERY steps; a contact begins with the least.
    """
    touching = balls.touching
    touching[:] = 0
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            touching[contacts.ball[lane]] += 1
            if contacts.partner[lane] >= 0:
                touching[contacts.partner[lane]] += 1
    for lane in range(counters[COUNTER.used]):
        if contacts.slot[lane] >= 0:
            i, j = contacts.ball[lane], contacts.partner[lane]
            most = max(touching[i], touching[max(j, 0)]) if j >= 0 else touching[i]
            put_of(contacts, lane, LANE.history.resistance, CROWD / min(max(most, FEW), CROWD))


@inlined()
def free_lane(candidates, contacts, lane, counters):
    """Take a contact out of its lane; the next one that opens gets the lane."""
    candidates.lane[contacts.slot[lane]] = -1
    contacts.slot[lane] = -1
    contacts.free[counters[COUNTER.free]] = lane
    counters[COUNTER.free] += 1


@inlined()
def put_closed(candidates, walls, k, trigger):
    """Set the trigger of a candidate that is no longer open; if it is not on the list of near ones, it joins it."""
    if candidates.trigger[k] == UNLISTED:
        partner, region = candidates.partner[k], candidates.near_end.size - 1
        if partner < 0:
            region = np.int64(body_of(walls, -1 - partner))
        candidates.near[candidates.near_end[region]] = k
        candidates.near_end[region] += np.uint64(1)
    candidates.trigger[k] = trigger


@inner()
def close_contact(balls, candidates, contacts, laws, walls, lane, time, totals, counters, table):
    """End a contact: book its works, record it, free its lane."""
    check_overlap(contacts, lane, counters)
    book_works(contacts, lane, totals)
    write_collision(contacts, walls, lane, time, ENDED.parted, counters, table)
    k, j, a = contacts.slot[lane], contacts.partner[lane], balls.species[contacts.ball[lane]]
    reach = laws.pair[a, balls.species[max(j, 0)], LAW.reach] if j >= 0 else laws.wall[SURFACE.rough, a, LAW.reach]
    put_closed(candidates, walls, k, reach * reach if j >= 0 else reach)
    free_lane(candidates, contacts, lane, counters)


@merged()
def wall_away(walls, candidates, motions, k, body, position, limit):
    """From the foot on candidate k's feature of the wall to the centre of a ball, in the laboratory frame.

    (FAR, 0, 0) if a ball of radius `limit` there does not touch it.
    """
    feature = -1 - candidates.partner[k]
    distance, direction = touch(walls, feature, candidates.sure[k], to_body(motions, body, position), limit)
    if distance < 0.0:
        return FAR, 0.0, 0.0
    return scale(distance, direction_to_laboratory(motions, body, direction))


@inlined()
def pairs_listed(candidates):
    """The number of candidates that are pairs of balls."""
    return candidates.first[candidates.first.size - 1]


@inlined()
def near_pairs_listed(candidates):
    """The number of near pairs."""
    return candidates.near_end[candidates.near_end.size - 1]


@merged()
def find_pairs(balls, candidates, begin, end, found):
    """Write those of the near pairs begin to end that have come within reach to `found`; returns how many."""
    count = np.uint64(0)
    for at in range(begin, end):
        k = candidates.near[at]
        i, j = candidates.ball[k], np.uint32(candidates.partner[k])
        away = subtract(row(balls.position, i), row(balls.position, j))
        # Always written but kept only if the count advances, so that there is no branch.
        found[count] = k
        count += np.uint64(dot(away, away) < candidates.trigger[k])
    return count


@merged()
def find_walls(balls, candidates, motions):
    """The same for balls and features of the walls, to candidates.found; of edges and corners, all that are near."""
    count = np.uint64(0)
    for body in range(candidates.first_wall.shape[0]):
        origin, turns = row(motions.pose, body), motions.turns[body]
        for at in range(candidates.first_wall[body, 0], candidates.near_end[body]):
            k = candidates.near[at]
            point = subtract(row(balls.position, candidates.ball[k]), origin)
            if turns:
                point = direction_to_body(motions, body, point)
            distance = dot(row(candidates.plane, k), point) - candidates.plane[k, PLANE.offset]
            candidates.found[count] = k
            count += np.uint64(distance < candidates.trigger[k])
    return count


@inlined()
def slip_of(balls, i, turning, closing, normal):
    """The speed at which the surface of ball i slips along that of its partner where they touch [m/s].

    turning: radius times angular velocity of the partner, 0 for a wall; closing: velocity of the partner, there or of
    its centre, relative to the centre of ball i; normal: unit vector from the partner to it.
    """
    radius = balls.radius[balls.species[i]]
    rolling = add_scaled(turning, radius, row(balls.angular_velocity_now, i))
    relative = add_scaled(scale(-1.0, closing), -1.0, cross(rolling, normal))
    along = add_scaled(relative, -dot(relative, normal), normal)
    return math.sqrt(dot(along, along))


@inner()
def open_pair(balls, candidates, contacts, laws, counters, k, time):
    """Open the contact of candidate k, two balls."""
    i, j = candidates.ball[k], candidates.partner[k]
    away = subtract(row(balls.position, i), row(balls.position, j))
    closing = subtract(row(balls.velocity_now, j), row(balls.velocity_now, i))
    distance = math.sqrt(dot(away, away))
    approach = dot(closing, away) / distance
    turning = scale(balls.radius[balls.species[j]], row(balls.angular_velocity_now, j))
    slip = slip_of(balls, i, turning, closing, scale(1.0 / distance, away))
    open_contact(balls, candidates, contacts, laws, counters, k, time, approach, slip)


@inlined()
def turn_into(vector, normal):
    """A vector turned into the plane across a unit normal, its length kept; a vector along the normal is lost."""
    flat = add_scaled(vector, -dot(vector, normal), normal)
    length2 = dot(flat, flat)
    return scale(math.sqrt(dot(vector, vector) / length2) if length2 > 0.0 else 0.0, flat)


@inner()
def pass_on(balls, candidates, contacts, laws, walls, old, k, normal, time, totals, counters, table):
    """Let the contact of candidate `old` go on at candidate k, another feature of its patch; normal: of the new one.

    Where the table counts by facet, the contact gets a row for each, and begins to count anew.
    """
    lane = np.int64(candidates.lane[old])
    if table.facet.size > 0:
        check_overlap(contacts, lane, counters)
        book_works(contacts, lane, totals)
        write_collision(contacts, walls, lane, time, ENDED.passed, counters, table)
        for work in LANE.history.works:
            put_of(contacts, lane, work, 0.0)
        put_of(contacts, lane, LANE.history.peak_force, 0.0)
        put_of(contacts, lane, LANE.history.peak_overlap, 0.0)
        put_of(contacts, lane, LANE.history.start, time)
    candidates.lane[old] = -1
    put_closed(candidates, walls, old, laws.wall[SURFACE.rough, balls.species[candidates.ball[old]], LAW.reach])
    settle(balls, candidates, contacts, laws, k, lane)
    choose_by_speed(laws.by_speed, contacts, laws, lane)
    block, m = lane // LANES, lane % LANES
    for carried in (LANE.history.spring, LANE.history.last_slip):
        turned = turn_into(get_vector(contacts.lanes, block, carried, m), normal)
        put_vector(contacts.lanes, block, carried, m, turned)


@inner()
def predecessor(candidates, walls, body, k, point, distance, direction, radius, was_touched):
    """The open candidate whose contact goes on at candidate k, which a ball at `point` (body frame) touches.

    Returns -1 where there is none, and k itself where k is not a contact, since a neighbouring feature is nearer.
    distance [m] and direction: those of k, see walls.touch.

    Of several open neighbours the contact goes on of the one that the ball leaves, or else of the nearest one: that is
    as far as k now, so that the stored energy does not jump. was_touched: whether k was touched a step ago. It was
    then denied as a neighbour was nearer, whose contact may meanwhile have gone on to a feature that does not meet
    k: it is still that contact which goes on at k, once k is nearer. A new one would begin with an energy from nowhere.
    But where an open neighbour's contact goes on at k, a feature that does not meet k has a contact of its own.
    """
    feature = -1 - candidates.partner[k]
    found, found_at, is_denied = -1, FAR, False
    i = candidates.ball[k]
    for other in range(candidates.first_wall[body, i], candidates.first_wall[body, i + 1]):
        neighbour = -1 - candidates.partner[other]
        if neighbour == feature or walls.patch[neighbour] != walls.patch[feature]:
            continue
        beyond, towards = touch(walls, neighbour, candidates.sure[other], point, radius)
        is_open = candidates.lane[other] >= 0
        if not (is_open or beyond >= 0.0):
            continue
        joint = joint_of(walls, feature, neighbour)
        if joint < 0:
            if not (is_open and was_touched and beyond >= 0.0):
                continue
            is_denied = is_denied or beyond < distance
            # A neighbour's contact goes first; nothing is as large as a kilometre.
            beyond += 1e3
        elif beyond >= 0.0:
            if joint == JOINT.sharp or (joint == JOINT.by_direction and dot(direction, towards) < COS_SMOOTH_TURN):
                continue
            if beyond < distance or (beyond == distance and neighbour < feature):
                return np.int64(k)
        if is_open and beyond < found_at:
            found, found_at = np.int64(other), beyond
    return np.int64(k) if is_denied and found_at >= 1e3 else found


@inner()
def open_wall(balls, candidates, contacts, laws, walls, clock, k, time, totals, counters, table):
    """Begin a contact of candidate k, a ball and a wall, or let one go on there, if the feature is within reach."""
    i, feature, motions = candidates.ball[k], -1 - candidates.partner[k], clock.motions
    body = body_of(walls, feature)
    position = row(balls.position, i)
    point = to_body(motions, body, position)
    radius = candidates.trigger[k]
    distance, direction = touch(walls, feature, candidates.sure[k], point, radius)
    if distance < 0.0:
        return
    normal = direction_to_laboratory(motions, body, direction)
    foot = wall_velocity(motions, body, add_scaled(position, -distance, normal))
    approach = dot(subtract(foot, row(balls.velocity_now, i)), normal)
    # Twice the way of a step, since the speed may be a little less now. A ball at rest has been put here.
    was_touched = approach != 0.0 and distance + 2.0 * clock.step * max(approach, 0.0) < radius * (1.0 - 1e-12)
    old = predecessor(candidates, walls, body, k, point, distance, direction, radius, was_touched)
    if old == k:
        return
    if old >= 0:
        pass_on(balls, candidates, contacts, laws, walls, old, k, normal, time, totals, counters, table)
        return
    slip = slip_of(balls, i, (0.0, 0.0, 0.0), subtract(foot, row(balls.velocity_now, i)), normal)
    open_contact(balls, candidates, contacts, laws, counters, k, time, approach, slip)


@inlined()
def sort_found(found, count):
    """Put the first `count` numbers into their order: a few, and mostly there already."""
    for at in range(1, count):
        number = found[at]
        before = at
        while before > 0 and found[before - 1] > number:
            found[before] = found[before - 1]
            before -= 1
        found[before] = number


@inner()
def open_pairs(balls, candidates, contacts, laws, counters, count, time):
    """Open the contacts of the first `count` pairs of balls in candidates.found, in the order of the lists."""
    sort_found(candidates.found, count)
    for at in range(count):
        open_pair(balls, candidates, contacts, laws, counters, candidates.found[at], time)


@merged()
def open_walls(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table):
    """Open the contacts with walls of all balls that have come within reach, in the order of the lists."""
    count = np.int64(find_walls(balls, candidates, clock.motions))
    sort_found(candidates.found, count)
    for at in range(count):
        k = candidates.found[at]
        open_wall(balls, candidates, contacts, laws, walls, clock, k, time, totals, counters, table)


@merged()
def open_contacts(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table):
    """Open the contacts of all that have come within reach."""
    count = np.int64(find_pairs(balls, candidates, np.uint64(0), near_pairs_listed(candidates), candidates.found))
    if count > 0:
        open_pairs(balls, candidates, contacts, laws, counters, count, time)
    open_walls(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)
