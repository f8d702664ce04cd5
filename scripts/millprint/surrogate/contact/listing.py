"""The contacts of a coarse step: listed, opened in advance, closed."""

import math

import numpy as np

from millprint.dem.lanes import get_of
from millprint.dem.layout import COUNTER, HISTORY, LANE, LAW, STATUS, TOTAL
from millprint.dem.neighbours import farthest_and_fastest, find_candidate, put_back, relist
from millprint.dem.touching import (
    FAR,
    book_works,
    check_overlaps,
    free_lane,
    open_contact,
    pairs_listed,
    wall_away,
    write_collision,
)
from millprint.kernel import inlined, inner
from millprint.mill.vectors import dot, row, subtract
from millprint.mill.walls import PLANE, SURFACE, to_body, wall_velocity


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
        reach = laws.pair[balls.species[i], balls.species[j], LAW.reach]
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
            reach = laws.wall[SURFACE.rough, balls.species[i], LAW.reach]
            limit = reach + margin + step * math.sqrt(dot(seen, seen))
            point = to_body(clock.motions, body, position)
            if dot(row(candidates.plane, k), point) - candidates.plane[k, PLANE.offset] >= limit:
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
    book_works(contacts, lane, totals)
    if get_of(contacts, lane, LANE.history.peak_overlap) > 0.0:
        coarse.ended[0] += 1.0
        write_collision(contacts, lane, time, 1, counters, table)
    free_lane(candidates, contacts, lane, counters)


@inner()
def update_lists(balls, candidates, contacts, laws, walls, clock, coarse, totals, counters):
    """Rebuild the lists if a ball may leave its skin within the step; open contacts stay."""
    check_overlaps(contacts, counters)
    stale = False
    for body in range(candidates.anchor.shape[0]):
        travelled2, fastest2, total = farthest_and_fastest(balls, candidates, clock.motions, body)
        room = 0.5 * clock.skin - math.sqrt(travelled2)
        if room <= 1.5 * clock.step * math.sqrt(fastest2) or not math.isfinite(total):
            stale = True
    if not stale and counters[COUNTER.rebuilds] > 0:
        return
    relist(balls, candidates, contacts, laws, walls, clock, counters)
    if counters[COUNTER.status] != STATUS.running:
        return
    for kept in range(counters[COUNTER.aside]):
        k = find_candidate(walls, candidates, contacts.kept_ball[kept], contacts.kept_partner[kept])
        if k < 0:
            coarse.ended[0] += 1.0 if contacts.kept_history[kept, HISTORY.peak_overlap] > 0.0 else 0.0
            # It has separated in the meantime, or its ball has moved off an edge.
            totals[TOTAL.normal_damping_J] += contacts.kept_history[kept, HISTORY.works.normal]
            totals[TOTAL.tangential_damping_J] += contacts.kept_history[kept, HISTORY.works.damping]
            totals[TOTAL.tangential_work_J] += contacts.kept_history[kept, HISTORY.works.tangential]
            totals[TOTAL.rolling_J] += contacts.kept_history[kept, HISTORY.works.rolling]
            continue
        put_back(balls, candidates, contacts, laws, counters, kept, k)
    counters[COUNTER.aside] = -1
    counters[COUNTER.rebuilds] += 1
