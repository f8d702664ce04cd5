"""The list of the candidates that are near leaves out none that would have opened."""

import numpy as np
import pytest

from millprint.dem.advance import advance
from millprint.dem.laws.registry import mark_of
from millprint.dem.layout import COUNTER
from millprint.dem.recording import make_table, silent_recorder
from tests.physics.test_threads import lively

STEPS = 800


def state_after(simulation, steps_a_call: int) -> tuple[list[np.ndarray], list[float]]:
    """The state after STEPS steps, and the share of candidates that were near at the end of each call."""
    table, recorder, shares, mark = make_table(20_000), silent_recorder(), [], mark_of(simulation.contact)
    for last in range(steps_a_call - 1, STEPS, steps_a_call):
        advance(
            simulation.balls, simulation.candidates, simulation.contacts, simulation.laws, mark,
            simulation.walls, simulation.clock, simulation.totals, simulation.counters, table, recorder, last, None,
        )  # fmt: skip
        shares.append(simulation.candidates.near_first[-1] / simulation.candidates.first_wall[-1, -1])
    assert simulation.counters[COUNTER.step] == STEPS
    ended = int(simulation.counters[COUNTER.records])
    assert ended > 50
    values = [table.first[:ended], table.second[:ended], table.value[:ended]]
    return [simulation.balls.position, simulation.balls.rate, simulation.totals, *values], shares


@pytest.mark.slow
@pytest.mark.parametrize(("mill", "speed_rpm"), [("emax", 1200), ("attritor", 350)])
def test_a_look_in_every_step_gives_the_same_bits(mills, contacts, mill, speed_rpm):
    """Each call begins with a look, so that calls of one step check every candidate that is near at that moment."""
    alone, _ = state_after(lively(mills, contacts, 1, mill=mill, speed_hz=speed_rpm / 60), 1)
    together, shares = state_after(lively(mills, contacts, 1, mill=mill, speed_hz=speed_rpm / 60), STEPS // 4)
    for each, other in zip(alone, together, strict=True):
        assert np.array_equal(each, other)
    assert max(shares) < 0.8
