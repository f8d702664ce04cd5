"""The contacts of a coarse step: listed, opened in advance, closed."""

import math

import numpy as np

from millprint.dem import lanes, state
from millprint.dem.lanes import HISTORY, LANES
from millprint.dem.law import REACH
from millprint.dem.neighbours import farthest_and_fastest, find_candidate, list_candidates, put_aside
from millprint.dem.touching import (
    FAR,
    book_works,
    check_overlaps,
    occupy,
    open_contact,
    pairs_listed,
    wall_away,
    write_collision,
)
from millprint.kernel import inlined, inner
from millprint.mill.vectors import dot, row, subtract
from millprint.mill.walls import to_body, wall_velocity


@inner()
def foresee(balls, candidates, contacts, laws, walls, clock, coarse, counters, time):
    """Open every contact that touches, or will by the end of the step at the present velocities."""
    step, margin = clock.step, coarse.margin
    for k in range(pairs_listed(candidates)):
        if candidates.lane[k] >= 0:
            continue
        i, j = candidates.ball[k], np.uint32(candidates.partner[k])
        away = subtract(row(balls.position, i), row(balls.position, j))
        closing = subtract(row(balls.rate, j), row(balls.rate, i))
        reach = laws.pair[balls.species[i], balls.species[j], REACH]
        distance = math.sqrt(dot(away, away))
        approach = dot(closing, away) / distance
        if distance - reach - approach * step < margin:
            open_contact(balls, candidates, contacts, laws, counters, k, time, approach)
    last = candidates.first_wall.shape[1] - 1
    for body in range(candidates.first_wall.shape[0]):
        for k in range(candidates.first_wall[body, 0], candidates.first_wall[body, last]):
            if candidates.lane[k] >= 0:
                continue
            i = candidates.ball[k]
            position = row(balls.position, i)
            seen = subtract(row(balls.rate, i), wall_velocity(clock.motions, body, position))
            reach = laws.wall[balls.species[i], REACH]
            limit = reach + margin + step * math.sqrt(dot(seen, seen))
            point = to_body(clock.motions, body, position)
            if dot(row(candidates.plane, k), point) - candidates.plane[k, 3] >= limit:
                continue
            away = wall_away(walls, candidates, clock.motions, k, body, position, limit)
            if away[0] >= FAR:
                continue
            distance = math.sqrt(dot(away, away))
            approach = -dot(seen, away) / distance
            if distance - reach - approach * step < margin:
                open_contact(balls, candidates, contacts, laws, counters, k, time, approach)


@inlined()
def close_lane(candidates, contacts, coarse, lane, time, totals, counters, table):
    """End a contact; one that was opened in advance and never touched is not counted."""
    block, m = lane // LANES, lane % LANES
    book_works(contacts, lane, totals)
    if lanes.get(contacts.lanes, block, HISTORY + lanes.PEAK_OVERLAP, m) > 0.0:
        coarse.ended[0] += 1.0
        write_collision(contacts, lane, time, 1, counters, table)
    candidates.lane[contacts.slot[lane]] = -1
    contacts.slot[lane] = -1
    contacts.free[counters[state.FREE]] = lane
    counters[state.FREE] += 1


@inner()
def relist(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters):
    """List the candidates anew if a ball may leave its skin within the step; open contacts stay."""
    check_overlaps(contacts, counters)
    stale = False
    for body in range(candidates.anchor.shape[0]):
        travelled2, fastest2, total = farthest_and_fastest(balls, candidates, clock.motions, body)
        room = 0.5 * clock.skin - math.sqrt(travelled2)
        if room <= 1.5 * clock.step * math.sqrt(fastest2) or not math.isfinite(total):
            stale = True
    if not stale and counters[state.REBUILDS] > 0:
        return
    if counters[state.ASIDE] < 0:
        put_aside(candidates, contacts, counters)
    for body in range(candidates.anchor.shape[0]):
        for i in range(balls.species.size):
            point = to_body(clock.motions, body, row(balls.position, i))
            if not math.isfinite(point[0] + point[1] + point[2]):
                counters[state.STATUS] = state.NOT_FINITE
                counters[state.BALL] = i
                return
            for axis in range(3):
                candidates.anchor[body, i, axis] = point[axis]
    list_candidates(balls, candidates, laws, walls, clock, counters)
    if counters[state.STATUS] != state.RUNNING:
        return
    for kept in range(counters[state.ASIDE]):
        k = find_candidate(walls, candidates, contacts.kept_ball[kept], contacts.kept_partner[kept])
        if k < 0:
            coarse.ended[0] += 1.0 if contacts.kept_history[kept, lanes.PEAK_OVERLAP] > 0.0 else 0.0
            # It has separated in the meantime, or its ball has moved off an edge.
            totals[state.TOTAL_NORMAL] += contacts.kept_history[kept, lanes.NORMAL]
            totals[state.TOTAL_DAMPING] += contacts.kept_history[kept, lanes.DAMPING]
            totals[state.TOTAL_TANGENTIAL] += contacts.kept_history[kept, lanes.TANGENTIAL]
            totals[state.TOTAL_ROLLING] += contacts.kept_history[kept, lanes.ROLLING]
            continue
        lane = occupy(balls, candidates, contacts, laws, counters, k)
        for c in range(lanes.HISTORY_COLUMNS):
            lanes.put(contacts.lanes, lane // LANES, HISTORY + c, lane % LANES, contacts.kept_history[kept, c])
    counters[state.ASIDE] = -1
    counters[state.REBUILDS] += 1
