"""Rows of the balls in space: in a large charge, balls that are near each other have rows near each other.

A packing begins so (packing.by_cell), and loses it as the balls mix: then the state of a contact's partners is far from
the processor. So the rows of the state are sorted again from time to time. A ball keeps its number, by which records,
messages and results name it; `numbers` holds that of each row. Sums of forces then have another order, so that a run
differs by rounding from one without; a smaller charge stays as it is.
"""

from typing import Protocol

import numpy as np

from millprint.dem import state
from millprint.dem.layout import COUNTER, HISTORY
from millprint.dem.neighbours import put_aside
from millprint.dem.packing import cell_order

# The least number of balls whose rows are sorted, and the rebuilds of the lists between two times.
SORTED_FROM = 5_000
SORT_EVERY = 50


class Sortable(Protocol):
    """What is used of a simulation; numbers: (n,) of the ball in each row."""

    balls: state.Balls
    candidates: state.Candidates
    contacts: state.Contacts
    clock: state.Clock
    counters: np.ndarray
    numbers: np.ndarray


def sort_if_due(simulation: Sortable) -> None:
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


def restore_rows(simulation: Sortable) -> None:
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


def _take_rows(simulation: Sortable, order: np.ndarray) -> None:
    """Order the state of the balls, and let the lists be made again."""
    balls, clock = simulation.balls, simulation.clock
    arrays = (balls.position, balls.rate, balls.rate_now, balls.load, balls.species, simulation.numbers)
    for array in (*arrays, clock.gain.reshape(len(order), -1)):
        array[:] = array[order]
    # Far from all balls.
    simulation.candidates.anchor[:] = np.inf
    simulation.counters[COUNTER.check_in] = 0


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
