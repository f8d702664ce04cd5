"""Balls settle and begin to move with a longer step than that of the window, where what is recorded sees no change."""

import numpy as np
import pytest
from pydantic import ValidationError

from millprint.config.sweep import Case, DemConfig, SweepConfig, expand_sweep
from millprint.dem.ledger import closure, ledger_series
from millprint.dem.resources import LONGEST_RUN_UP
from millprint.dem.simulation import Simulation

DEM = DemConfig(time_step_s=2e-6)
CASE = Case(
    mill="emax", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.10, speed_hz=10.0, seed=0, settle_s=0.05,
    discard_s=0.05, window_s=0.2,
)  # fmt: skip


def series_of(simulation):
    return ledger_series(np.concatenate(simulation.run().samples))


def simulation_of(mills, contacts, dem=DEM, start=None, **change):
    return Simulation(CASE.model_copy(update=change), mills["emax"], contacts["calibrated"], dem, start)


@pytest.mark.parametrize("discard_s", [0.0, 0.004])
def test_a_ball_that_falls_through_the_change_falls_as_galilei_says(mills, contacts, discard_s):
    """Leapfrog is exact in a fall, so that any fault of the half steps shows: x = -g t^2 / 2 and v = -g t."""
    one = {"fill_ratio": 0.0042, "speed_hz": 0.0, "settle_s": 0.012, "discard_s": discard_s, "window_s": 0.02}
    middle = simulation_of(mills, contacts, **one).vessel.bounds.mean(axis=0)[None]
    falling = simulation_of(mills, contacts, start=middle, **one)
    assert falling.count == 1 and falling.run_up_step == pytest.approx(LONGEST_RUN_UP * falling.step, rel=1e-3)
    series = series_of(falling)
    mass = float(falling.balls.mass[0])
    time = series["time_s"].to_numpy() + falling.settle_steps * falling.run_up_step
    # The first force acts at the first position, half a step before which the ball is at rest.
    assert series["time_s"].iloc[0] == pytest.approx(falling.begin_s)
    speed = np.sqrt(2 * series["kinetic_translation_J"].to_numpy() / mass)
    late = speed / 9.81 - time
    assert np.ptp(late) < 1e-12 and abs(late[0]) < falling.run_up_step
    assert closure(series) < 1e-9


def test_a_pile_at_rest_stays_at_rest(mills, contacts):
    """Its springs hold it: if the change lost their tangential stretch, it would move."""
    pile = simulation_of(mills, contacts, speed_hz=0.0, settle_s=0.6, discard_s=0.1, window_s=0.02)
    series = series_of(pile)
    assert (pile.contacts.slot >= 0).sum() > pile.count
    tangential = series["elastic_tangential_J"].to_numpy()
    assert tangential[0] > 0 and np.ptp(tangential) < 2e-2 * tangential[0]
    assert series["kinetic_J"].max() < 2e-2 * tangential[0]


def test_the_window_has_its_own_step_and_its_balance_closes(mills, contacts):
    moved = simulation_of(mills, contacts)
    series = series_of(moved)
    one = simulation_of(mills, contacts, DEM.model_copy(update={"run_up_fraction": 0}))
    assert one.run_up_step == one.step == moved.step and moved.run_up_step > 3.9 * moved.step
    assert moved.begin_s == pytest.approx(0.05) and moved.time_s == pytest.approx(0.25, abs=2 * moved.step)
    # A sample is a whole number of steps of both lengths.
    assert np.diff(series["time_s"]) == pytest.approx(moved.sample_every * moved.step)
    ratio = moved.sample_every * moved.step / moved.run_up_step
    assert ratio == pytest.approx(round(ratio))
    assert closure(series) < 2 * closure(series_of(one)) + 1e-4


@pytest.mark.parametrize(
    ("dem", "change"),
    [
        ({}, {"snapshot_interval_s": 1e-3}),
        ({}, {"rayleigh_fraction": 0.2}),
        ({}, {"rayleigh_fraction": 0.3, "rayleigh_fraction_max": 0.35}),
        ({"rayleigh_fraction_max": 0.1}, {"rayleigh_fraction": 0.1}),
    ],
)
def test_one_step_is_taken_where_motion_is_seen_from_its_start_or_the_step_is_as_long(mills, contacts, dem, change):
    own = simulation_of(mills, contacts, DEM.model_copy(update=dem), **change)
    assert own.run_up_step == own.step and own.discard_steps == own.begin_step


def test_what_is_discarded_is_counted_in_turns_unless_a_sweep_says_seconds():
    own = {"name": "s", "contacts": ["steel"], "ball_diameters_mm": [10], "fill_ratios": [0.1], "seeds": [0]}
    dem = DemConfig(discard_turns=4)
    cases = expand_sweep(SweepConfig(**own, speeds_rpm=[0, 600, 1200]), dem, "emax")
    assert [case.discard_s for case in cases] == pytest.approx([0.0, 0.4, 0.2])
    for key, expected in (("discard_s", 0.0), ("discard_s", 0.3), ("discard_turns", 10)):
        (case,) = expand_sweep(SweepConfig(**own, speeds_rpm=[600], **{key: expected}), dem, "emax")
        assert case.discard_s == pytest.approx(1.0 if key == "discard_turns" else expected)
    with pytest.raises(ValidationError, match="discard_s and discard_turns cannot both be given"):
        SweepConfig(**own, speeds_rpm=[600], discard_s=0.1, discard_turns=1)
