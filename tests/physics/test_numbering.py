"""Balls whose rows are sorted in space while they mix (dem.neighbours) keep their numbers, and move as before."""

import numpy as np
import pytest

from millprint.config.charge import BallMixture
from millprint.config.errors import SimulationError
from millprint.dem import neighbours as numbering
from millprint.dem import simulation as simulations
from millprint.dem.recording import Recording
from millprint.dem.state import MOVING
from tests.physics.test_restart import Killed, content, kill_after, make_small_chunks, run
from tests.physics.test_threads import lively, table

pytestmark = pytest.mark.slow

MIXTURE = BallMixture(name="two", sizes_mm=(6, 4), numbers=(1, 2))
CHANGE = {"mixture": MIXTURE, "ball_diameter_m": MIXTURE.mean_diameter_mm / 1e3}


@pytest.fixture
def sorted_often(monkeypatch):
    """Sorts a charge of any size after every third rebuild; counts the contacts that were open each time."""
    aside, sort = [], numbering._sort_aside

    def counted(contacts, open_now, row):
        aside.append(open_now)
        sort(contacts, open_now, row)

    monkeypatch.setattr(numbering, "SORTED_FROM", 0)
    monkeypatch.setattr(numbering, "SORT_EVERY", 3)
    monkeypatch.setattr(numbering, "_sort_aside", counted)
    return aside


@pytest.fixture(scope="module")
def unsorted(mills, contacts):
    """A simulation of two sizes of balls whose rows stay, and its recording."""
    simulation = lively(mills, contacts, 1, **CHANGE)
    return simulation, simulation.run()


def joined(recording: Recording, name: str) -> np.ndarray:
    """The pieces of a recording as one array."""
    return np.concatenate(getattr(recording, name))


def test_sorted_rows_change_a_run_only_by_rounding(unsorted, mills, contacts, sorted_often, monkeypatch):
    still, expected = unsorted
    monkeypatch.setattr(simulations, "CHUNK_S", 5e-4)
    simulation = lively(mills, contacts, 1, **CHANGE)
    recording = simulation.run()
    assert max(sorted_often) > 10
    for name in (*MOVING, "species"):
        np.testing.assert_allclose(getattr(simulation.balls, name), getattr(still.balls, name), rtol=0, atol=1e-8)
    for a, b in zip(table(expected), table(recording), strict=True):
        np.testing.assert_allclose(b, a, rtol=1e-6, atol=1e-9)
    for name, scale in {"samples": 1.0, "snapshots": 1.0, "snapshot_contacts": 0.0}.items():
        first, second = joined(expected, name), joined(recording, name)
        if not scale:
            first, second = np.unique(first, axis=0), np.unique(second, axis=0)
        np.testing.assert_allclose(second, first, rtol=1e-6, atol=1e-6 * scale)


def test_a_stopped_run_of_sorted_rows_goes_on_bit_for_bit(mills, contacts, tmp_path, sorted_often, monkeypatch):
    make_small_chunks(monkeypatch)
    whole = run(tmp_path / "whole", mills, contacts)
    sorts = len(sorted_often)
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 60)
        run(tmp_path / "parts", mills, contacts)
    assert run(tmp_path / "parts", mills, contacts)["ledger_J"] == whole["ledger_J"]
    assert len(sorted_often) == 2 * sorts > 10
    first, second = (content(tmp_path / name / "run.h5") for name in ("whole", "parts"))
    for name, values in first.items():
        assert np.array_equal(values, second[name], equal_nan=values.dtype.kind == "f"), name


def test_a_message_names_a_ball_by_its_number(mills, contacts, sorted_often, monkeypatch):
    """The ball that is thrown out has another row by then."""
    monkeypatch.setattr(simulations, "CHUNK_S", 5e-4)
    simulation, rows = lively(mills, contacts, 1), []
    thrown = 100

    def throw(*arguments):
        if len(sorted_often) == 3 and not rows:
            rows.append(int(np.flatnonzero(simulation.numbers == thrown)[0]))
            simulation.balls.position[rows[0], 2] += 1.0

    monkeypatch.setattr(simulation, "_write_restart_if_due", throw)
    with pytest.raises(SimulationError, match=rf"^ball {thrown} has left the vessel"):
        simulation.run()
    assert rows[0] != thrown
