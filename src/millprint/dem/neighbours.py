"""Candidate lists: which balls and walls a ball may touch before it has moved far, and rows of balls in space.

A candidate is listed up to a skin from contact, and most are nowhere near it. So the list is searched only every
few steps, and the steps between check only the near ones: closer than both partners can come in that time. The
others would not have opened, so the shorter list changes no number of a run. Nor does an open candidate: it joins the
near ones when it closes.

As in neighbours.needs_rebuild, no ball is taken to become faster, relative to a body, than twice the fastest one
between two checks of the lists.

A packing begins so (packing.cell_order), and loses it as the balls mix: then the state of a contact's partners is far
from the processor. So the rows of the state are sorted again from time to time. A ball keeps its number, by which
records, messages and results name it; `numbers` holds that of each row. Sums of forces then have another order, so
that a run differs by rounding from one without; a smaller charge stays as it is.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from millprint.dem import state
from millprint.dem.contact_events import UNLISTED, check_overlaps, listed, occupy, pairs_listed
from millprint.dem.law import choose_by_speed, get_of, put_of
from millprint.dem.layout import CELL, COUNTER, HISTORY, HISTORY_WIDTH, LANE_HISTORY, LAW, STATUS
from millprint.dem.packing import cell_order
from millprint.mill.motion import POSE
from millprint.mill.vectors import cross, dot, row, subtract, vector
from millprint.mill.walls import (
    PLANE,
    body_of,
    bounding_plane,
    cell_of,
    closeness_of,
    direction_to_body,
    plane_distance,
    to_body,
)
from millprint.run.kernel import inlined, inner, kernel, merged

if TYPE_CHECKING:
    from millprint.dem.simulation import Simulation

# How far two balls may come nearer to each other between two searches, over the skin. With less, searches are frequent;
# with more, more candidates are near.
NEAR_SHARE = 0.12
# Added to that, over the skin, for balls and walls that start from rest.
SLACK_SHARE = 0.02
# The most steps between two searches.
LOOK_EVERY = 50.0


@merged()
def speed2_seen(balls, motions, body, i):
    """Squared speed of a ball as seen from a body [m2/s2]."""
    pose = motions.pose
    speed = subtract(row(balls.velocity, i), vector(pose, body, POSE.velocity))
    if motions.turns[body]:
        arm = subtract(row(balls.position, i), vector(pose, body, POSE.position))
        speed = subtract(speed, cross(vector(pose, body, POSE.angular_velocity), arm))
    return dot(speed, speed)


@inner()
def measure_strides(balls, candidates, clock):
    """Write how far a ball may go in a step, as seen from each body [m]: twice as far as the fastest one does now."""
    for body in range(candidates.stride.size):
        fastest2 = 0.0
        for i in range(balls.species.size):
            fastest2 = max(fastest2, speed2_seen(balls, clock.motions, body, i))
        candidates.stride[body] = 2 * clock.step * math.sqrt(fastest2) + 1e-12


@merged()
def near_walls(balls, candidates, motions, body, nearer):
    """List the features of a body that are closed and less than `nearer` [m] from contact; open ones are marked."""
    origin, turns = row(motions.pose, body), motions.turns[body]
    begin, end = candidates.first_wall[body, 0], candidates.first_wall[body, candidates.first_wall.shape[1] - 1]
    count = begin
    for k in range(begin, end):
        point = subtract(row(balls.position, candidates.ball[k]), origin)
        if turns:
            point = direction_to_body(motions, body, point)
        distance = dot(row(candidates.plane, k), point) - candidates.plane[k, PLANE.offset]
        trigger = candidates.trigger[k]
        # Always written but kept only if the count advances, so that there is no branch.
        candidates.near[count] = k
        count += np.uint64((trigger >= 0.0) & (distance < trigger + nearer))
        candidates.trigger[k] = UNLISTED if trigger < 0.0 else trigger
    candidates.near_end[body] = count


@inlined()
def squares_apart(balls, nearer):
    """What (reach + nearer)^2 is more than reach^2 [m2], with the reach of the largest balls for all."""
    largest = 0.0
    for radius in balls.radius:
        largest = max(largest, radius)
    return nearer * (4.0 * largest + nearer)


@inlined()
def is_near(balls, candidates, k, more):
    """1 if pair k is closed and near, else 0; an open one is marked: it joins the list when it closes."""
    i, j = candidates.ball[k], np.uint32(candidates.partner[k])
    away = subtract(row(balls.position, i), row(balls.position, j))
    trigger = candidates.trigger[k]
    candidates.trigger[k] = UNLISTED if trigger < 0.0 else trigger
    return np.uint64((trigger >= 0.0) & (dot(away, away) < trigger + more))


@merged()
def near_pairs(balls, candidates, nearer):
    """The same for pairs."""
    more, count = squares_apart(balls, nearer), np.uint64(0)
    for k in range(pairs_listed(candidates)):
        near = is_near(balls, candidates, k, more)
        candidates.near[count] = k
        count += near
    candidates.near_end[candidates.near_end.size - 1] = count


@merged()
def list_near_walls(balls, candidates, clock, counters):
    """List the features that are near, and plan the next search; returns how near a pair must be to be listed [m]."""
    longest = 0.0
    for stride in candidates.stride:
        longest = max(longest, stride)
    steps = max(1, int(min(LOOK_EVERY, NEAR_SHARE * clock.skin / (2 * longest))))
    slack = SLACK_SHARE * clock.skin
    for body in range(candidates.stride.size):
        near_walls(balls, candidates, clock.motions, body, steps * candidates.stride[body] + slack)
    counters[COUNTER.look_in] = steps
    return 2 * steps * longest + slack


@inner()
def list_near(balls, candidates, clock, counters):
    """List the candidates that are near, and plan the next search."""
    near_pairs(balls, candidates, list_near_walls(balls, candidates, clock, counters))


# Up to this number of balls all pairs are checked; above it a grid of cells is used.
ALL_PAIRS = 160

# The most steps between two checks of the lists and of the overlaps.
CHECK_EVERY = 100.0


@kernel()
def put_aside(candidates, contacts, counters):
    """Copy the open contacts to the side, in the order of the lists, and free all lanes; counts them."""
    kept = 0
    for k in range(listed(candidates)):
        lane = candidates.lane[k]
        if lane < 0:
            continue
        contacts.kept_ball[kept] = candidates.ball[k]
        contacts.kept_partner[kept] = candidates.partner[k]
        for c in range(HISTORY_WIDTH):
            contacts.kept_history[kept, c] = get_of(contacts, lane, LANE_HISTORY + c)
        contacts.slot[lane] = -1
        kept += 1
    counters[COUNTER.used] = 0
    counters[COUNTER.free] = 0
    counters[COUNTER.aside] = kept


@merged()
def find_candidate(walls, candidates, i, partner):
    """The candidate of ball i with a partner; -1 if it is not listed."""
    begin, end = candidates.first[i], candidates.first[i + 1]
    if partner < 0:
        body = body_of(walls, -1 - partner)
        begin, end = candidates.first_wall[body, i], candidates.first_wall[body, i + 1]
    for k in range(begin, end):
        if candidates.partner[k] == partner:
            return np.int64(k)
    return -1


@merged()
def put_back(balls, candidates, contacts, laws, counters, kept, k):
    """Open the contact of candidate k with the history of the contact set aside as number `kept`."""
    lane = occupy(balls, candidates, contacts, laws, counters, np.uint32(k))
    for c in range(HISTORY_WIDTH):
        put_of(contacts, lane, LANE_HISTORY + c, contacts.kept_history[kept, c])
    choose_by_speed(laws.by_speed, contacts, laws, lane)


@merged()
def put_all_back(balls, candidates, contacts, laws, walls, counters):
    """Open all contacts set aside, with their exact histories; sets the status if one has lost its candidate."""
    for kept in range(counters[COUNTER.aside]):
        i = contacts.kept_ball[kept]
        k = find_candidate(walls, candidates, i, contacts.kept_partner[kept])
        if k < 0:
            counters[COUNTER.status] = STATUS.contact_lost
            counters[COUNTER.ball] = i
            return
        put_back(balls, candidates, contacts, laws, counters, kept, k)
    counters[COUNTER.aside] = -1


@inlined()
def add_candidate(candidates, k, i, partner, sure, trigger):
    """Write candidate k, if there is room for it; returns the number of the next one."""
    if k < candidates.partner.size:
        candidates.ball[k] = i
        candidates.partner[k] = partner
        candidates.sure[k] = sure
        candidates.lane[k] = -1
        candidates.trigger[k] = trigger
    return k + 1


@inlined()
def add_pair(balls, candidates, laws, i, j, skin, k):
    """Append the pair if it is within reach; `candidates.anchor` holds the positions."""
    away = subtract(row(candidates.anchor[0], i), row(candidates.anchor[0], j))
    reach = laws.pair[balls.species[i], balls.species[j], LAW.reach]
    if dot(away, away) < (reach + skin) * (reach + skin):
        return add_candidate(candidates, k, i, j, np.int64(0), reach * reach)
    return k


# Inlined, since a call hands over some hundred numbers, the arrays' addresses and sizes.
@merged()
def add_walls(balls, candidates, walls, body, i, skin, k):
    """Append the features of a body near ball i; returns -1 if the ball is outside the vessel's bounding box."""
    radius = balls.radius[balls.species[i]]
    # Walls stand still in their body's frame: only the ball moves, by half the skin at most.
    margin = 0.5 * skin
    point = row(candidates.anchor[body], i)
    cell = cell_of(walls, body, point)
    if cell < 0:
        return k if body > 0 else -1
    for m in range(walls.cell_first[cell], walls.cell_first[cell + 1]):
        feature = walls.cell_feature[m]
        if walls.cell_sure[m]:
            closeness = 2 if plane_distance(walls, feature, point) <= radius + margin else 0
        else:
            closeness = closeness_of(walls, feature, point, radius, margin)
        if closeness and k < candidates.partner.size:
            normal, candidates.plane[k, PLANE.offset] = bounding_plane(walls, feature, point, margin)
            for c in range(3):
                candidates.plane[k, c] = normal[c]
        if closeness:
            k = add_candidate(candidates, k, i, -1 - feature, closeness - 1, radius)
    return k


@inner()
def sort_into_cells(candidates, pitch):
    """Sort the balls into cells of at least `pitch` (cell_place, cell_first, cell_member); returns the shape.

    Where the grid would have more cells than there is room for, the cells grow.
    """
    n = candidates.anchor.shape[1]
    low = row(candidates.anchor[0], 0)
    high = low
    for i in range(1, n):
        point = row(candidates.anchor[0], i)
        low = (min(low[0], point[0]), min(low[1], point[1]), min(low[2], point[2]))
        high = (max(high[0], point[0]), max(high[1], point[1]), max(high[2], point[2]))
    width = subtract(high, low)
    shape = (int(width[0] / pitch) + 1, int(width[1] / pitch) + 1, int(width[2] / pitch) + 1)
    while shape[0] * shape[1] * shape[2] >= candidates.cell_first.size:
        pitch *= 1.25
        shape = (int(width[0] / pitch) + 1, int(width[1] / pitch) + 1, int(width[2] / pitch) + 1)
    cells = shape[0] * shape[1] * shape[2]
    for c in range(cells + 1):
        candidates.cell_first[c] = 0
    for i in range(n):
        for axis in range(3):
            along = int((candidates.anchor[0, i, axis] - low[axis]) / pitch)
            candidates.cell_place[i, CELL.place.x + axis] = along
        place = vector(candidates.cell_place, i, CELL.place)
        cell = (place[0] * shape[1] + place[1]) * shape[2] + place[2]
        candidates.cell_place[i, CELL.number] = cell
        candidates.cell_first[cell] += 1
    # Counts become ends; filling from the back turns ends into beginnings.
    for c in range(1, cells + 1):
        candidates.cell_first[c] += candidates.cell_first[c - 1]
    for i in range(n - 1, -1, -1):
        cell = candidates.cell_place[i, CELL.number]
        candidates.cell_first[cell] -= 1
        candidates.cell_member[candidates.cell_first[cell]] = i
    return shape


@inner()
def add_cell_pairs(balls, candidates, laws, i, skin, shape, k):
    """Append the pairs of ball i with higher numbers in the 27 cells around it."""
    x, y, z = vector(candidates.cell_place, i, CELL.place)
    for a in range(max(x - 1, 0), min(x + 2, shape[0])):
        for b in range(max(y - 1, 0), min(y + 2, shape[1])):
            # Cells along the last axis follow each other in the list of members.
            start = (a * shape[1] + b) * shape[2]
            begin, end = start + max(z - 1, 0), start + min(z + 2, shape[2])
            for m in range(candidates.cell_first[begin], candidates.cell_first[end]):
                if candidates.cell_member[m] > i:
                    k = add_pair(balls, candidates, laws, i, candidates.cell_member[m], skin, k)
    return k


@merged()
def list_candidates(balls, candidates, laws, walls, clock, counters):
    """Fill the lists from the anchors; sets the status if a ball has left or there is no room."""
    n = balls.species.size
    crowded = n > ALL_PAIRS
    shape = (1, 1, 1)
    if crowded:
        largest = 0.0
        for radius in balls.radius:
            largest = max(largest, radius)
        shape = sort_into_cells(candidates, 2 * largest + clock.skin)
    k = np.int64(0)
    for i in range(n):
        candidates.first[i] = k
        if crowded:
            k = add_cell_pairs(balls, candidates, laws, i, clock.skin, shape, k)
        else:
            for j in range(i + 1, n):
                k = add_pair(balls, candidates, laws, i, j, clock.skin, k)
    candidates.first[n] = k
    for body in range(candidates.anchor.shape[0]):
        for i in range(n):
            candidates.first_wall[body, i] = k
            k = add_walls(balls, candidates, walls, body, i, clock.skin, k)
            if k < 0:
                counters[COUNTER.status] = STATUS.escaped
                counters[COUNTER.ball] = i
                return
        candidates.first_wall[body, n] = k
    if k > candidates.partner.size:
        counters[COUNTER.status] = STATUS.candidates_full


@merged()
def relist(balls, candidates, contacts, laws, walls, clock, counters):
    """Set the open contacts aside and rebuild the lists; sets the status if a ball is lost or a list full.

    A full list may be made longer and the call repeated: the contacts set aside by the first one stay there.
    """
    if counters[COUNTER.aside] < 0:
        put_aside(candidates, contacts, counters)
    for body in range(candidates.anchor.shape[0]):
        for i in range(balls.species.size):
            point = to_body(clock.motions, body, row(balls.position, i))
            if not math.isfinite(point[0] + point[1] + point[2]):
                counters[COUNTER.status] = STATUS.not_finite
                counters[COUNTER.ball] = i
                return
            for axis in range(3):
                candidates.anchor[body, i, axis] = point[axis]
    list_candidates(balls, candidates, laws, walls, clock, counters)


@merged()
def farthest_and_fastest(balls, candidates, motions, body):
    """Of all balls, in a body's frame: largest squared distance from the anchor [m2] and squared speed [m2/s2].

    A third number is finite only if every position and velocity is.
    """
    pose = motions.pose
    travelled2 = 0.0
    fastest2 = 0.0
    total = 0.0
    for i in range(balls.species.size):
        point = to_body(motions, body, row(balls.position, i))
        moved = subtract(point, row(candidates.anchor[body], i))
        speed = subtract(row(balls.velocity, i), vector(pose, body, POSE.velocity))
        if motions.turns[body]:
            arm = subtract(row(balls.position, i), vector(pose, body, POSE.position))
            speed = subtract(speed, cross(vector(pose, body, POSE.angular_velocity), arm))
        moved2, speed2 = dot(moved, moved), dot(speed, speed)
        travelled2 = max(travelled2, moved2)
        fastest2 = max(fastest2, speed2)
        total += moved2 + speed2
    return travelled2, fastest2, total


@merged()
def needs_rebuild(balls, candidates, clock):
    """Whether a ball may leave its skin within the next step, and the number of steps to the next check [-].

    No ball is taken to become faster, relative to a body, than twice the fastest one between two checks.
    """
    steps = CHECK_EVERY
    stale = False
    for body in range(candidates.anchor.shape[0]):
        travelled2, fastest2, total = farthest_and_fastest(balls, candidates, clock.motions, body)
        stride = 2 * clock.step * math.sqrt(fastest2) + 1e-12
        room = 0.5 * clock.skin - math.sqrt(travelled2)
        # A lost number shows in the sum; the rebuild finds and reports it.
        if room <= stride or not math.isfinite(total):
            stale = True
            room = 0.5 * clock.skin
        steps = min(steps, room / stride)
    return stale, max(1, int(steps))


@inner()
def check_lists(balls, candidates, contacts, laws, walls, clock, counters):
    """Check the overlaps, rebuild the lists if that is needed, and plan the next check."""
    check_overlaps(contacts, counters)
    stale, counters[COUNTER.check_in] = needs_rebuild(balls, candidates, clock)
    if stale:
        relist(balls, candidates, contacts, laws, walls, clock, counters)
        if counters[COUNTER.status] == STATUS.running:
            put_all_back(balls, candidates, contacts, laws, walls, counters)
            counters[COUNTER.rebuilds] += 1


# The least number of balls whose rows are sorted, and the rebuilds of the lists between two times.
SORTED_FROM = 5_000
SORT_EVERY = 50


def list_again(simulation: "Simulation") -> None:
    """Set the open contacts aside and let the lists be made again before the next step, with contacts as they then are.

    Only between two calls of the step loop.
    """
    put_aside(simulation.candidates, simulation.contacts, simulation.counters)
    _forget_lists(simulation)


def _forget_lists(simulation: "Simulation") -> None:
    # Far from all balls.
    simulation.candidates.anchor[:] = np.inf
    simulation.counters[COUNTER.check_in] = 0


def sort_if_due(simulation: "Simulation") -> None:
    """Sort the rows of a large charge by the cells of a grid; only before a call of the step loop."""
    counters, balls = simulation.counters, simulation.balls
    waited = counters[COUNTER.rebuilds] - counters[COUNTER.sorted_at]
    if len(simulation.numbers) < SORTED_FROM or waited < SORT_EVERY or counters[COUNTER.aside] >= 0:
        return
    # Cells follow each other along the shortest side first, so that the cells around one are near in the list, too.
    sides = np.argsort(-np.ptp(balls.position, axis=0))
    order = cell_order(balls.position[:, sides], 2 * float(balls.radius.max()))
    put_aside(simulation.candidates, simulation.contacts, counters)
    _take_rows(simulation, order)
    _sort_aside(simulation.contacts, int(counters[COUNTER.aside]), np.argsort(order))
    counters[COUNTER.sorted_at] = counters[COUNTER.rebuilds]


def restore_rows(simulation: "Simulation") -> None:
    """Put each ball back into the row of its number, where a run has ended or failed; contacts keep their lanes."""
    numbers, contacts, concerned = simulation.numbers.copy(), simulation.contacts, [COUNTER.ball, COUNTER.partner]
    if (numbers[:-1] < numbers[1:]).all():
        return
    _take_rows(simulation, np.argsort(numbers))
    for partners in (contacts.ball, contacts.partner, contacts.kept_ball, contacts.kept_partner):
        partners[:] = named(numbers, partners)
    simulation.counters[concerned] = named(numbers, simulation.counters[concerned])


def named(numbers: np.ndarray, partners: np.ndarray) -> np.ndarray:
    """Partners of contacts by the numbers of the balls in place of their rows; walls (less than 0) as they are."""
    return np.where(partners < 0, partners, numbers[np.maximum(partners, 0)])


def named_pairs(numbers: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both partners of contacts, as `named`; of two balls the one of the lower number comes first."""
    first, second = named(numbers, first), named(numbers, second)
    turned = (second >= 0) & (second < first)
    return np.where(turned, second, first), np.where(turned, first, second)


def _take_rows(simulation: "Simulation", order: np.ndarray) -> None:
    """Order the state of the balls, and let the lists be made again."""
    balls, clock = simulation.balls, simulation.clock
    of_sizes = [each.reshape(len(order), 3) for each in (clock.gain, clock.turn) if len(each) > 1]
    for array in (*(getattr(balls, name) for name in (*state.MOVING, "species")), simulation.numbers, *of_sizes):
        array[:] = array[order]
    _forget_lists(simulation)


def _sort_aside(contacts: state.Contacts, aside: int, row: np.ndarray) -> None:
    """Give the contacts set aside the new row of each old one, in the order of the lists.

    Of two balls the first has the lower row; where they change places, what points from the second to the first turns.
    """
    ball, history = contacts.kept_ball[:aside], contacts.kept_history[:aside].copy()
    first, second = named_pairs(row, ball, contacts.kept_partner[:aside])
    history[np.ix_(first != row[ball], [*HISTORY.spring, *HISTORY.last_slip])] *= -1
    order = np.lexsort((first, second < 0))
    contacts.kept_ball[:aside], contacts.kept_partner[:aside] = first[order], second[order]
    contacts.kept_history[:aside] = history[order]
