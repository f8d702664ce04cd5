"""Impulses and works of single contacts over some steps: the training data of the contact surrogate."""

from typing import NamedTuple

import numpy as np

from millprint.columns import width_of
from millprint.dem.lanes import get_of
from millprint.dem.layout import COUNTER, LANE, TRACE
from millprint.kernel import inlined, inner


class Trace(NamedTuple):
    """The recorded contacts."""

    place: np.ndarray  # (n, n + features) row of a pair of balls, or of a ball and a feature of the wall; -1 for none
    value: np.ndarray  # (rows, width) layout.TraceColumns


def make_trace(balls: int, features: int, rows: int) -> Trace:
    """Room for `rows` contacts of `balls` with each other and with `features` of the walls; none is followed yet."""
    place = np.full((balls, balls + features), -1, dtype=np.int64)
    return Trace(place, np.zeros((rows, width_of(TRACE))))


@inlined()
def place_of(trace, partner):
    """The column of trace.place for a partner: a ball, or -1 - feature of the wall."""
    return partner if partner >= 0 else trace.place.shape[0] - 1 - partner


@inlined()
def row_of(contacts, lane, trace):
    """The row of the contact in a lane; -1 where there is none, or where it is not followed."""
    if contacts.slot[lane] < 0:
        return -1
    return trace.place[contacts.ball[lane], place_of(trace, contacts.partner[lane])]


@inner()
def begin_trace(contacts, counters, trace):
    """Note what the followed contacts that are open have done so far."""
    for lane in range(counters[COUNTER.used]):
        at = row_of(contacts, lane, trace)
        if at >= 0:
            for c in range(len(TRACE.works)):
                work = get_of(contacts, lane, LANE.history.works.normal + c)
                trace.value[at, TRACE.works.normal + c] = trace.value[at, TRACE.works_before.normal + c] = work


@inner()
def follow(contacts, counters, trace, step, left):
    """Add the forces of a step [s] that ends `left` [s] before the last one does."""
    for lane in range(counters[COUNTER.used]):
        at = row_of(contacts, lane, trace)
        if at < 0:
            continue
        for c in range(3):
            force = get_of(contacts, lane, LANE.force.x + c)
            trace.value[at, TRACE.impulse.x + c] += step * force
            trace.value[at, TRACE.moment.x + c] += step * (left + 0.5 * step) * force
        for c in range(len(TRACE.works)):
            trace.value[at, TRACE.works.normal + c] = get_of(contacts, lane, LANE.history.works.normal + c)
