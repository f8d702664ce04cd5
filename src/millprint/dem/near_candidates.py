"""A second, shorter list: the candidates that can come within reach in the next few steps.

A candidate is listed up to a skin from contact, and most are nowhere near it. So the list is searched only every
few steps, and the steps between check only the near ones: closer than both partners can come in that time. The
others would not have opened, so the shorter list changes no number of a run.

As in neighbours.needs_rebuild, no ball is taken to become faster, relative to a body, than twice the fastest one
between two checks of the lists.
"""

import math

import numpy as np

from millprint.dem.contact_events import UNLISTED, pairs_listed
from millprint.dem.layout import COUNTER, RATE
from millprint.mill.pose import POSE
from millprint.mill.vectors import cross, dot, row, subtract, vector
from millprint.mill.walls import PLANE, direction_to_body
from millprint.run.kernel import inlined, inner

# How far two balls may come nearer to each other between two searches, over the skin. With less, searches are frequent;
# with more, more candidates are near.
NEAR_SHARE = 0.12
# Added to that, over the skin, for balls and walls that start from rest.
SLACK_SHARE = 0.02
# The most steps between two searches.
LOOK_EVERY = 50.0


@inlined()
def speed2_seen(balls, motions, body, i):
    """Squared speed of a ball as seen from a body [m2/s2]."""
    pose = motions.pose
    speed = subtract(vector(balls.rate, i, RATE.velocity), vector(pose, body, POSE.velocity))
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


@inlined()
def near_walls(balls, candidates, motions, body, nearer, count):
    """List the features of a body that are open, or less than `nearer` [m] from contact.

    Their numbers are written from place `count` on; returns where they end.
    """
    origin, turns = row(motions.pose, body), motions.turns[body]
    last = candidates.first_wall.shape[1] - 1
    for k in range(candidates.first_wall[body, 0], candidates.first_wall[body, last]):
        point = subtract(row(balls.position, candidates.ball[k]), origin)
        if turns:
            point = direction_to_body(motions, body, point)
        distance = dot(row(candidates.plane, k), point) - candidates.plane[k, PLANE.offset]
        trigger = candidates.trigger[k]
        # Always written but kept only if the count advances, so that there is no branch.
        candidates.near[count] = k
        count += np.uint64((trigger < 0.0) | (distance < trigger + nearer))
    return count


@inlined()
def squares_apart(balls, nearer):
    """What (reach + nearer)^2 is more than reach^2 [m2], with the reach of the largest balls for all."""
    largest = 0.0
    for radius in balls.radius:
        largest = max(largest, radius)
    return nearer * (4.0 * largest + nearer)


@inlined()
def is_near(balls, candidates, k, more):
    """1 if pair k is closed and near, else 0; an open one is marked: it joins the list when it parts."""
    i, j = candidates.ball[k], np.uint32(candidates.partner[k])
    away = subtract(row(balls.position, i), row(balls.position, j))
    trigger = candidates.trigger[k]
    candidates.trigger[k] = UNLISTED if trigger < 0.0 else trigger
    return np.uint64((trigger >= 0.0) & (dot(away, away) < trigger + more))


@inlined()
def near_pairs(balls, candidates, nearer, count):
    """The same for pairs, but for those that are open (contact_events.close_contact)."""
    more = squares_apart(balls, nearer)
    for k in range(pairs_listed(candidates)):
        near = is_near(balls, candidates, k, more)
        candidates.near[count] = k
        count += near
    return count


@inlined()
def list_near_walls(balls, candidates, clock, counters):
    """List the features that are near, and plan the next search.

    Returns their number, and how near to contact a pair must be to be listed [m].
    """
    longest = 0.0
    for stride in candidates.stride:
        longest = max(longest, stride)
    steps = max(1, int(min(LOOK_EVERY, NEAR_SHARE * clock.skin / (2 * longest))))
    slack = SLACK_SHARE * clock.skin
    count = np.uint64(0)
    for body in range(candidates.stride.size):
        count = near_walls(balls, candidates, clock.motions, body, steps * candidates.stride[body] + slack, count)
        candidates.near_first[body + 1] = count
    counters[COUNTER.look_in] = steps
    return count, 2 * steps * longest + slack


@inner()
def list_near(balls, candidates, clock, counters):
    """List the candidates that are near, and plan the next search."""
    count, nearer = list_near_walls(balls, candidates, clock, counters)
    count = near_pairs(balls, candidates, nearer, count)
    candidates.near_first[candidates.stride.size + 1] = count
