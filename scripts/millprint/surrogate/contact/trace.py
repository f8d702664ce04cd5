"""The impulses and works of every contact in a coarse step of our DEM: the labels of the training data."""

from typing import NamedTuple

import numpy as np

from millprint.dem import lanes, state
from millprint.dem.advance import can_step, count_step
from millprint.dem.lanes import HISTORY, LANES
from millprint.dem.steps import apply_forces, drift, kick
from millprint.kernel import inlined, inner

# Columns of a trace: impulse [N s], first moment int (h - s) F ds [N s2], works (normal, damping, tangential,
# rolling) at the end of the step and at its start [J].
IMPULSE, MOMENT, WORKS, WORKS_BEFORE = 0, 3, 6, 10
COLUMNS = 14


class Trace(NamedTuple):
    """The recorded contacts."""

    place: np.ndarray  # (n, n + features) row of a pair of balls, or of a ball and a feature of the wall; -1 for none
    value: np.ndarray  # (rows, COLUMNS)


@inlined()
def place_of(trace, i, partner):
    """The row of a contact; -1 if it is not recorded."""
    return trace.place[i, partner if partner >= 0 else trace.place.shape[0] - 1 - partner]


@inner()
def begin_trace(contacts, counters, trace):
    """Store the works of open contacts so far."""
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] >= 0:
            at = place_of(trace, contacts.ball[lane], contacts.partner[lane])
            if at >= 0:
                for c in range(4):
                    work = lanes.get(contacts.lanes, lane // LANES, HISTORY + lanes.NORMAL + c, lane % LANES)
                    trace.value[at, WORKS + c] = trace.value[at, WORKS_BEFORE + c] = work


@inner()
def follow(contacts, counters, trace, step, left):
    """Add the forces of a fine step that ends `left` [s] before the coarse one does."""
    for lane in range(counters[state.USED]):
        if contacts.slot[lane] < 0:
            continue
        at = place_of(trace, contacts.ball[lane], contacts.partner[lane])
        if at < 0:
            continue
        block, m = lane // LANES, lane % LANES
        for c in range(3):
            force = lanes.get(contacts.lanes, block, lanes.FORCE + c, m)
            trace.value[at, IMPULSE + c] += step * force
            trace.value[at, MOMENT + c] += step * (left + 0.5 * step) * force
        for c in range(4):
            trace.value[at, WORKS + c] = lanes.get(contacts.lanes, block, HISTORY + lanes.NORMAL + c, m)


@inner()
def advance_traced(balls, candidates, contacts, laws, walls, clock, totals, counters, table, recorder, steps, trace):
    """Take `steps` fine steps of the DEM and follow the contacts of `trace`; stops early if something is wrong."""
    rate, rate_now, load = balls.rate.reshape(-1), balls.rate_now.reshape(-1), balls.load.reshape(-1)
    begin_trace(contacts, counters, trace)
    for s in range(steps):
        time = counters[state.STEP] * clock.step
        if not can_step(balls, candidates, contacts, laws, walls, clock, time, counters, table, recorder):
            return
        apply_forces(balls, candidates, contacts, laws, walls, clock, time, totals, counters, table)
        follow(contacts, counters, trace, clock.step, (steps - 1 - s) * clock.step)
        kick(rate, rate_now, load, clock.gain, clock.fall)
        drift(balls.position, balls.rate, clock.step)
        count_step(counters)
