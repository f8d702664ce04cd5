"""Eight contacts at a time: gathered from the balls into lanes, evaluated together, scattered back.

A block of lanes is one row of numbers, LANES for each quantity, so that the compiler knows that quantities never
overlap and makes vector instructions of the loop over the lanes. A lane that is free keeps the numbers of an earlier
contact, or IDLE ones: they cost nothing, and their results are not read.

Quantities of one step only are in separate rows (layout.PresentColumns), GROUP of them, which all blocks use in
turn: so they stay in the processor's nearest memory, however many contacts there are.
"""

import numpy as np

from millprint.dem.lane_access import load_lane, load_present, store_lane, store_present
from millprint.dem.layout import LANE, LANES, PRESENT
from millprint.mill.kernel_columns import span_of, width_of
from millprint.run.kernel import inlined

# Content of a free lane: two steel balls of 10 mm in contact.
IDLE = np.zeros(width_of(LANE))
IDLE[span_of(LANE.law)] = 1.0
IDLE[LANE.law.reach] = 10e-3
IDLE_PRESENT = np.zeros(width_of(PRESENT))
IDLE_PRESENT[PRESENT.away.x] = 9.99e-3


@inlined()
def get(lanes, block, quantity, m):
    """A quantity of a lane."""
    return load_lane(lanes, block, quantity * LANES + m)


@inlined()
def put(lanes, block, quantity, m, value):
    """Set a quantity of a lane."""
    store_lane(lanes, block, quantity * LANES + m, value)


@inlined()
def get_vector(lanes, block, quantity, m):
    """A vector of a lane, of which `quantity` names the three columns: they follow each other."""
    at = quantity.x * LANES + m
    return load_lane(lanes, block, at), load_lane(lanes, block, at + LANES), load_lane(lanes, block, at + 2 * LANES)


@inlined()
def put_vector(lanes, block, quantity, m, vector):
    """Set a vector of a lane."""
    at = quantity.x * LANES + m
    store_lane(lanes, block, at, vector[0])
    store_lane(lanes, block, at + LANES, vector[1])
    store_lane(lanes, block, at + 2 * LANES, vector[2])


@inlined()
def get_present(present, at, quantity, m):
    """A vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    return load_present(present, at, c), load_present(present, at, c + LANES), load_present(present, at, c + 2 * LANES)


@inlined()
def put_present(present, at, quantity, m, vector):
    """Set a vector of lane m in row `at` of the present rows."""
    c = quantity.x * LANES + m
    store_present(present, at, c, vector[0])
    store_present(present, at, c + LANES, vector[1])
    store_present(present, at, c + 2 * LANES, vector[2])


@inlined()
def add_to(lanes, block, quantity, m, value):
    """Add to a quantity of a lane."""
    put(lanes, block, quantity, m, get(lanes, block, quantity, m) + value)


@inlined()
def raise_to(lanes, block, quantity, m, value):
    """Set a quantity of a lane to a value that is larger."""
    old = get(lanes, block, quantity, m)
    put(lanes, block, quantity, m, value if value > old else old)


@inlined()
def get_of(contacts, lane, quantity):
    """A quantity of the contact in a lane, by the number of the lane among all."""
    return get(contacts.lanes, lane // LANES, quantity, lane % LANES)


@inlined()
def put_of(contacts, lane, quantity, value):
    """Set a quantity of the contact in a lane, by the number of the lane among all."""
    put(contacts.lanes, lane // LANES, quantity, lane % LANES, value)
