"""The step loop with threads gives the result of the serial one, up to rounding, and the same in every run.

All with coefficients over speed and with cohesion: compiled for one contact set, the two loops take half a minute less.
"""

import itertools
import os
import subprocess
import sys
from typing import ClassVar

import numpy as np
import pytest

from millprint.config.contact_set import CohesionConfig, RestitutionTable
from millprint.config.sweep import Case, DemConfig, threads_of
from millprint.dem.advance import advance, chunk, make_shares
from millprint.dem.layout import COUNTER
from millprint.dem.ledger import ledger_series, ledger_summary
from millprint.dem.recording import make_table, silent_recorder
from millprint.dem.simulation import Simulation
from millprint.dem.state import MOVING
from tests.physics.setups import crowd

pytestmark = pytest.mark.slow


class FineDem(DemConfig):
    """A short run with many samples of the ledger."""

    ledger_samples_per_revolution: ClassVar[int] = 500


DEM = FineDem(time_step_s=2e-6, settle_s=1e-6, window_s=2e-3, closure_max=0.05)
CASE = Case(
    mill="emax", contact="calibrated", ball_diameter_m=0.005, fill_ratio=0.16, speed_hz=20.0, seed=0,
    settle_s=1e-6, discard_s=0.0, window_s=2e-3, snapshot_interval_s=1e-3,
)  # fmt: skip

SET = {
    "restitution": RestitutionTable(speeds_m_s=(0.1, 2.0), values=(0.1, 0.6)),
    "cohesion": CohesionConfig(ball_ball_J_m2=0.3, ball_wall_J_m2=0.3),
}


def lively(mills, contacts, threads: int, **change) -> Simulation:
    """Balls that fly at random at 2 m/s [rms], so that contacts begin and end in almost every step."""
    case = CASE.model_copy(update={"threads": threads, **change})
    simulation = Simulation(case, mills[case.mill], contacts["calibrated"].model_copy(update=SET), DEM)
    simulation.balls.velocity[:] = np.random.default_rng(1).normal(0, 2 / np.sqrt(3), (simulation.count, 3))
    simulation.balls.velocity_now[:] = simulation.balls.velocity
    return simulation


@pytest.fixture(scope="module")
def runs(mills, contacts):
    """Simulations after 2 ms and their recordings, by number of threads; 3 has been run twice."""
    found = {}
    for name, threads in {"1": 1, "3": 3, "3 again": 3}.items():
        simulation = lively(mills, contacts, threads)
        found[name] = simulation, simulation.run(f"{threads} threads")
    return found


def table(recording) -> list[np.ndarray]:
    """The table of collisions, sorted by start and partners, without the column that it does not have."""
    columns = [np.concatenate(column) for column in zip(*recording.contacts, strict=True)]
    columns = [column for column in columns if len(column)]
    order = np.lexsort((columns[1], columns[0]))
    return [column[order] for column in columns]


def test_threads_change_a_run_only_by_rounding(runs):
    (serial, alone), (shared, together) = runs["1"], runs["3"]
    assert serial.count > 300
    assert np.abs(shared.balls.position - serial.balls.position).max() < 1e-9
    first, second = table(alone), table(together)
    # Enough contacts have ended for blocks that wait to matter, and each is the same one with the same works.
    assert np.count_nonzero(first[2]) > 50
    for a, b in zip(first[:3], second[:3], strict=True):
        assert np.array_equal(a, b)
    np.testing.assert_allclose(second[3], first[3], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(shared.totals, serial.totals, rtol=1e-9)
    assert shared.counters[COUNTER.rebuilds] == serial.counters[COUNTER.rebuilds]


def test_a_crowd_moves_in_threads_as_without(contacts):
    """A few steps, in which contacts with coefficients over speed begin and end, in blocks of three threads."""
    worlds = [crowd(contacts["calibrated"].model_copy(update=SET), 4e-6, 2e-4) for _ in range(2)]
    tables = [make_table(1000), make_table(1000)]
    for world, made, threads in zip(worlds, tables, (0, 3), strict=True):
        shares = make_shares(threads, 240, 1, world.candidates, world.open_contacts) if threads else None
        advance(world.balls, world.candidates, world.open_contacts, world.laws, world.mark, world.walls, world.clock,
                world.totals, world.counters, made, silent_recorder(), 11, shares)  # fmt: skip
    (one, other), (first, second) = worlds, tables
    ended = one.counters[COUNTER.records]
    assert np.array_equal(one.counters, other.counters) and ended > 10 and one.counters[COUNTER.rebuilds] > 1
    assert sorted(zip(first.first[:ended], first.second[:ended], strict=True)) == sorted(
        zip(second.first[:ended], second.second[:ended], strict=True)
    )
    for name in MOVING:
        scale = np.abs(getattr(one.balls, name)).max()
        np.testing.assert_allclose(getattr(other.balls, name), getattr(one.balls, name), rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(other.totals, one.totals, rtol=1e-9)


def test_the_same_number_of_threads_gives_the_same_bits(runs):
    (first, one), (second, other) = runs["3"], runs["3 again"]
    assert np.array_equal(first.balls.position, second.balls.position)
    assert np.array_equal(first.totals, second.totals)
    for a, b in zip(table(one), table(other), strict=True):
        assert np.array_equal(a, b)


def test_the_ledger_closes_with_threads(runs):
    serial, shared = (ledger_summary(ledger_series(np.concatenate(runs[key][1].samples))) for key in ("1", "3"))
    # The walls do little work in 2 ms, so the balance is compared with what the collisions dissipate.
    dissipated = sum(shared[channel] for channel in ("normal_damping", "tangential_damping", "sliding", "rolling"))
    assert dissipated > 0
    assert abs(shared["imbalance"]) < 0.002 * dissipated
    for channel, energy in serial.items():
        assert shared[channel] == pytest.approx(energy, rel=1e-7, abs=1e-9 * dissipated), channel


def test_lists_that_are_too_short_are_made_longer_with_threads(mills, contacts, runs):
    scarce = lively(mills, contacts, 3)
    names = ("ball", "partner", "plane", "sure", "lane", "trigger")
    cut = {name: getattr(scarce.candidates, name)[:100] for name in names}
    scarce.candidates = scarce.candidates._replace(**cut, found=scarce.candidates.found[:101])
    scarce.shares = scarce._make_shares()
    scarce.run("scarce")
    assert scarce.candidates.partner.size > 100
    assert np.array_equal(scarce.balls.position, runs["3"][0].balls.position)


@pytest.mark.parametrize("whole", [0, 1, 7, 20_000])
@pytest.mark.parametrize("threads", [1, 2, 3, 16])
def test_chunks_follow_each_other_and_cover_everything(whole, threads):
    bounds = [chunk.py_func(whole, t, threads) for t in range(threads)]
    assert bounds[0][0] == 0 and bounds[-1][1] == whole
    assert all(before[1] == after[0] for before, after in itertools.pairwise(bounds))
    assert max(end - begin for begin, end in bounds) - min(end - begin for begin, end in bounds) <= 1


def test_a_case_may_have_threads_of_its_own():
    dem = DEM.model_copy(update={"threads": 2})
    assert threads_of(CASE, DEM) == 1
    assert threads_of(CASE, dem) == 2
    assert threads_of(CASE.model_copy(update={"threads": 4}), dem) == 4


def test_threads_of_a_job_wait_awake(tmp_path):
    """The library of the threads, GNU's OpenMP, says how they wait: it reads that when it starts them."""
    code = "import os, millprint.dem.advance as t\nwith t.use_threads(2): print(os.environ['OMP_WAIT_POLICY'])"
    given = {"OMP_WAIT_POLICY": "PASSIVE", "OMP_DISPLAY_ENV": "VERBOSE", "NUMBA_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | given, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    # What is set for libraries that are loaded later stays.
    assert done.stdout == "PASSIVE\n"
    assert "GOMP_SPINCOUNT" in done.stderr
    assert "GOMP_SPINCOUNT = '0'" not in done.stderr
