"""Coefficients that depend on the speed of a hit: chosen when a contact begins, kept in its lane until it ends.

What is kept is the speed of approach, in the contact's history: where the lists are made again, or the contact goes on
at another feature of the wall, the same speed gives the same coefficients.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.core.types import NoneType
from numba.extending import overload

from millprint.config.contact_set import ContactConfig
from millprint.dem.lanes import get_of, put_of
from millprint.dem.laws.record import damping_ratio
from millprint.dem.layout import LANE
from millprint.mill.kernel_columns import number_columns, width_of
from millprint.mill.walls import SURFACE
from millprint.run.kernel import INLINED, inlined, inner

# Rows of the laws (law.law_row) have the damping of this restitution where the restitution depends on the speed.
REFERENCE = 0.5
REFERENCE_RATIO = damping_ratio(REFERENCE)
# The slowest approach [m/s]: a contact may begin while its partners part.
SLOWEST = 1e-9

ratio_of = inlined()(damping_ratio)


class ChosenColumns(NamedTuple):
    """Coefficients at a speed."""

    restitution: int
    friction: int


CHOSEN = number_columns(ChosenColumns)


class SpeedTables(NamedTuple):
    """Coefficients at the speeds of all tables of a contact set, so that each stays linear in between."""

    log_speeds: np.ndarray  # (s,) logarithms of speeds [m/s]
    values: np.ndarray  # (1 + surfaces, s, width) ChosenColumns of balls, then of each surface (walls.SURFACE)


def at_reference(contact: ContactConfig) -> ContactConfig:
    """The set that rows of the laws are made of: with the restitution REFERENCE if a coefficient is over speed."""
    if not contact.speed_tables:
        return contact
    if contact.restitution is None:
        return contact
    return contact.model_copy(update={"restitution": REFERENCE, "wall_restitution": None})


def speed_tables(contact: ContactConfig) -> SpeedTables | None:
    """The tables of a contact set; None if no coefficient depends on the speed of the hit."""
    if not contact.speed_tables:
        return None
    sets = [contact, *(getattr(contact, name) for name in ("at_wall", "without_friction"))]
    speeds = sorted({speed for each in sets for table in each.speed_tables.values() for speed in table.speeds_m_s})
    values = np.empty((1 + len(SURFACE), len(speeds), width_of(CHOSEN)))
    for k, each in enumerate(sets):
        for s, speed in enumerate(speeds):
            # A law without a restitution keeps its own damping.
            damped = contact.restitution is not None
            values[k, s, CHOSEN.restitution] = each.value_of("restitution", speed) if damped else REFERENCE
            values[k, s, CHOSEN.friction] = each.value_of("static_friction", speed)
    return SpeedTables(np.log(speeds), values)


@inlined()
def place_among(sorted_values, value):
    """The interval in which a value lies, and where in it: 0 to 1, at an end for a value outside."""
    last = sorted_values.size - 1
    if value <= sorted_values[0]:
        return 0, 0.0
    if value >= sorted_values[last]:
        return last - 1, 1.0
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if sorted_values[middle] <= value:
            low = middle
        else:
            high = middle
    return low, (value - sorted_values[low]) / (sorted_values[high] - sorted_values[low])


def choose_by_speed(by_speed, contacts, laws, lane):
    """Give a lane, whose row of the law is in place, the damping and friction of its speed of approach, if by_speed
    (state.Laws) has tables; only for kernels.
    """
    raise NotImplementedError


@overload(choose_by_speed, jit_options=INLINED)
def _choose_by_speed(by_speed, contacts, laws, lane):
    if isinstance(by_speed, NoneType):
        return lambda by_speed, contacts, laws, lane: None
    own = set_by_speed
    return lambda by_speed, contacts, laws, lane: own(by_speed, contacts, laws, lane)


@inner()
def set_by_speed(by_speed, contacts, laws, lane):
    """Set damping and friction of a lane by its speed of approach."""
    speed = max(get_of(contacts, lane, LANE.history.approach_speed), SLOWEST)
    at, share = place_among(by_speed.log_speeds, math.log(speed))
    partner = contacts.partner[lane]
    kind = 0 if partner >= 0 else 1 + laws.surface[-1 - partner]
    below, above = by_speed.values[kind, at], by_speed.values[kind, at + 1]
    restitution = below[CHOSEN.restitution] + share * (above[CHOSEN.restitution] - below[CHOSEN.restitution])
    damped = ratio_of(restitution) / REFERENCE_RATIO
    for column in (LANE.law.normal_damping, LANE.law.tangential_damping):
        put_of(contacts, lane, column, damped * get_of(contacts, lane, column))
    friction = below[CHOSEN.friction] + share * (above[CHOSEN.friction] - below[CHOSEN.friction])
    put_of(contacts, lane, LANE.law.friction, friction)
