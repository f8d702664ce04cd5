"""The heat balance: one body, steady state, coupled bodies by the matrix exponential, closed balance, pauses."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from millprint.dose.heat_balance import (
    BALLS,
    JAR,
    Balance,
    cycle_peak,
    pause_needed,
    programme_phases,
    solve,
    time_to_limit,
)


def balances(samples: int = 20, seed: int = 0) -> Balance:
    """Balances with numbers over wide ranges; powder of few grams makes them stiff."""
    random = np.random.default_rng(seed)
    rise = np.array([0.05, 0.001, 0.5])
    return Balance(
        capacity_J_K=1000 * rise * random.uniform(0.5, 2, (samples, 3)),
        between_W_K=np.exp(random.uniform(np.log(0.2), np.log(20), (samples, 3))),
        running_W_K=random.uniform(0.5, 3, samples),
        resting_W_K=random.uniform(0.2, 1, samples),
        source_W=random.uniform(1, 30, (samples, 3)),
        surroundings_degC=random.uniform(15, 25, samples),
    )


def one_lump(capacity: float = 400.0, loss: float = 0.8, source: float = 40.0) -> Balance:
    """Bodies that are coupled so strongly that they are one."""
    return Balance(
        capacity_J_K=capacity * np.array([[0.3, 0.1, 0.6]]),
        between_W_K=np.full((1, 3), 1e6),
        running_W_K=np.array([loss]),
        resting_W_K=np.array([loss / 2]),
        source_W=source * np.array([[0.5, 0.2, 0.3]]),
        surroundings_degC=np.array([20.0]),
    )


def test_one_body_follows_newtons_law_of_cooling():
    times = np.linspace(0, 3000, 31)
    course = solve(one_lump(), programme_phases(3000, 1500, 1500), times)
    rise = 50 * (1 - np.exp(-0.8 / 400 * np.minimum(times, 1500)))
    expected = 20 + np.where(times <= 1500, rise, rise[-1] * np.exp(-0.4 / 400 * (times - 1500)))
    np.testing.assert_allclose(course.temperature_degC[:, 0], np.tile(expected[:, None], 3), rtol=1e-5)


def test_time_to_a_limit_of_one_body_is_a_logarithm():
    found = time_to_limit(one_lump(), BALLS, 60.0)
    np.testing.assert_allclose(found, -400 / 0.8 * np.log(1 - 40 / 50), rtol=1e-4)
    assert np.isinf(time_to_limit(one_lump(), BALLS, 71.0)).all()


def test_at_the_end_the_jar_gives_away_what_is_set_free():
    balance = balances()
    over = balance.steady_degC() - balance.surroundings_degC[:, None]
    np.testing.assert_allclose(balance.running_W_K * over[:, JAR], balance.source_W.sum(axis=1), rtol=1e-10)
    course = solve(balance, programme_phases(1e5, 1e5, 0.0), np.array([0.0, 1e5]))
    np.testing.assert_allclose(course.temperature_degC[-1], balance.steady_degC(), rtol=1e-6)


def test_coupled_bodies_follow_the_matrix_exponential():
    balance = balances()
    times = np.array([0.0, 3.0, 60.0, 700.0, 1000.0, 1200.0, 2000.0])
    course = solve(balance, programme_phases(2000, 1000, 1000), times)
    for sample in range(len(balance)):
        # The sources as a fourth, constant state.
        on, off = np.zeros((4, 4)), np.zeros((4, 4))
        on[:3, :3] = -balance.conductance(True)[sample] / balance.capacity_J_K[sample, :, None]
        on[:3, 3] = balance.source_W[sample] / balance.capacity_J_K[sample]
        off[:3, :3] = -balance.conductance(False)[sample] / balance.capacity_J_K[sample, :, None]
        start = np.array([0.0, 0.0, 0.0, 1.0])
        for time, found in zip(times, course.temperature_degC[:, sample], strict=True):
            state = expm(off * max(time - 1000, 0)) @ expm(on * min(time, 1000)) @ start
            np.testing.assert_allclose(found, state[:3] + balance.surroundings_degC[sample], rtol=1e-6)


def test_the_energy_balance_closes():
    course = solve(balances(60), programme_phases(7200, 900, 300), np.linspace(0, 7200, 13))
    assert course.balance_error < 1e-10


def test_an_integrator_finds_the_same_temperatures():
    balance, times = balances(4), np.linspace(0, 5400, 28)
    phases = programme_phases(5400, 1500, 600)
    course = solve(balance, phases, times)
    for sample in range(4):
        state, found = np.zeros(3), [np.zeros(3)]
        for start, end, running in phases:
            matrix = balance.conductance(running)[sample]
            source, capacity = running * balance.source_W[sample], balance.capacity_J_K[sample]
            inside = times[(times > start) & (times <= end)]
            own = solve_ivp(
                lambda _, each, matrix=matrix, source=source, capacity=capacity: (source - matrix @ each) / capacity,
                (start, end), state, method="LSODA", t_eval=np.union1d(inside, end), rtol=1e-11, atol=1e-10,
            )  # fmt: skip
            found += list(own.y.T[: len(inside)])
            state = own.y[:, -1]
        degC = np.array(found) + balance.surroundings_degC[sample]
        np.testing.assert_allclose(course.temperature_degC[:, sample], degC, atol=1e-6)


def test_a_jar_that_gives_nothing_away_in_a_pause_keeps_its_heat():
    balance = dataclasses.replace(balances(5), resting_W_K=np.zeros(5))
    course = solve(balance, programme_phases(3000, 1000, 2000), np.array([0.0, 1000.0, 3000.0]))
    stored = (balance.capacity_J_K * (course.temperature_degC - balance.surroundings_degC[:, None])).sum(axis=2)
    np.testing.assert_allclose(stored[2], stored[1], rtol=1e-10)
    assert course.balance_error < 1e-10


def test_without_a_source_nothing_warms_up():
    still = balances(3)
    still = Balance(**{**still.__dict__, "source_W": np.zeros((3, 3))})
    course = solve(still, programme_phases(1000, 1000, 0.0), np.array([0.0, 500.0, 1000.0]))
    np.testing.assert_allclose(course.temperature_degC, np.broadcast_to(still.surroundings_degC[:, None], (3, 3, 3)))


def test_heat_does_not_depend_on_how_bodies_are_named():
    """Balls and powder exchanged in every number give exchanged temperatures."""
    one = balances(5)
    swap = [1, 0, 2]
    other = Balance(
        capacity_J_K=one.capacity_J_K[:, swap],
        between_W_K=one.between_W_K[:, [0, 2, 1]],
        running_W_K=one.running_W_K,
        resting_W_K=one.resting_W_K,
        source_W=one.source_W[:, swap],
        surroundings_degC=one.surroundings_degC,
    )
    np.testing.assert_allclose(other.steady_degC(), one.steady_degC()[:, swap], rtol=1e-10)


def test_time_to_a_limit_is_that_of_the_course():
    balance = balances()
    limit = float(balance.steady_degC()[:, BALLS].min()) - 1
    found = time_to_limit(balance, BALLS, limit)
    for sample, time in enumerate(found):
        course = solve(balance, programme_phases(time, time, 0.0), np.array([0.0, time]))
        assert course.temperature_degC[-1, sample, BALLS] == pytest.approx(limit, abs=1e-5)


def test_a_programme_that_goes_on_ends_in_the_cycle_that_repeats_itself():
    balance = balances(4)
    course = solve(
        balance, programme_phases(40 * 1200.0, 900, 300), np.append(0.0, np.linspace(39 * 1200.0, 40 * 1200.0, 600))
    )
    for sample in range(len(balance)):
        for body in range(3):
            expected = cycle_peak(balance, sample, body, 900, 300)
            assert course.peak_degC[sample, body] == pytest.approx(expected, abs=0.02)


def test_the_pause_found_keeps_the_limit_and_no_shorter_one_does():
    balance = balances()
    limit = float(np.median(balance.steady_degC()[:, BALLS]))
    found = pause_needed(balance, BALLS, limit, 600.0)
    assert (found == 0).any() and (found > 0).any()
    for sample, pause in enumerate(found):
        if pause == 0:
            assert balance.steady_degC()[sample, BALLS] <= limit
        elif np.isfinite(pause):
            assert cycle_peak(balance, sample, BALLS, 600.0, pause) == pytest.approx(limit, abs=1e-3)
            assert cycle_peak(balance, sample, BALLS, 600.0, 0.9 * pause) > limit


def test_a_pause_of_one_body_in_closed_form():
    """Peak of a repeated cycle: S (1 - p) / (1 - p r), with the decays p over milling and r over the pause."""
    milling, limit = 200.0, 45.0
    mill = np.exp(-0.8 / 400 * milling)
    rest = (1 - 50 * (1 - mill) / (limit - 20)) / mill
    expected = -400 / 0.4 * np.log(rest)
    assert pause_needed(one_lump(), BALLS, limit, milling) == pytest.approx(expected, rel=1e-3)


def test_no_pause_helps_where_one_interval_is_too_hot():
    assert np.isinf(pause_needed(one_lump(), BALLS, 40.0, 3600.0)).all()


@pytest.mark.parametrize(("milling", "pause", "count"), [(600, 0, 6), (600, 300, 8), (5000, 10, 1)])
def test_a_programme_is_cut_off_at_its_end(milling, pause, count):
    phases = programme_phases(3600, milling, pause)
    assert len(phases) == count
    assert phases[0][0] == 0 and phases[-1][1] == 3600
    assert all(one[1] == other[0] for one, other in pairwise(phases))
