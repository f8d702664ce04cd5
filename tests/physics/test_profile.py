"""The clock that tells the parts of a step apart changes none of them."""

import numpy as np
import pytest

from millprint.dem.profile import PARTS, make_profile
from tests.physics.test_threads import lively


@pytest.fixture(scope="module")
def run(mills, contacts):
    """A simulation of 2 ms with the clock."""
    simulation = lively(mills, contacts, 1)
    simulation.profile = make_profile()
    simulation.run()
    return simulation


def test_every_part_takes_time_and_none_takes_it_all(run):
    ticks = run.profile[: len(PARTS)]
    assert (ticks > 0).all()
    assert ticks.max() < 0.9 * ticks.sum()


def test_the_results_are_those_without_the_clock(run, mills, contacts):
    plain = lively(mills, contacts, 1)
    plain.run()
    assert plain.profile is None
    for name in ("position", "rate", "load"):
        assert np.array_equal(getattr(plain.balls, name), getattr(run.balls, name))
    assert np.array_equal(plain.totals, run.totals)
