"""Timing of surrogates and of the simulation."""

import time

import pytest
import yaml

from millprint.thesis.surrogate.timing import PHYSICAL_S, scaled_thresholds, simulation_seconds, time_rollouts
from tests.conftest import configuration
from tests.unit.surrogate_samples import CONTACTS, simulate, write_run
from tests.unit.test_surrogate_scene import ROOT


class Sleeper:
    """A surrogate that takes a millisecond a step and a trajectory."""

    step_s, balls = 1e-4, 7

    def begin(self, starts_s: list[float]):
        return lambda steps, steps_per_frame: time.sleep(1e-3 * steps * len(starts_s))


def test_seconds_are_those_of_a_batch_and_of_its_share():
    table = time_rollouts(Sleeper(), 0.1, [1, 4], 20, "one thread")
    assert table["batch"].tolist() == [1, 4] and table["balls"].tolist() == [7, 7]
    expected = 1e-3 * PHYSICAL_S / 1e-4
    # A sleep is never shorter than asked for, and a busy machine makes it longer.
    assert expected <= table["seconds_per_trajectory"].min() < 3 * expected
    assert table["seconds_for_15_s"][1] == pytest.approx(4 * table["seconds_per_trajectory"][1])
    assert table["basis"][0] == "extrapolated from 20 steps of 0.0001 s, one thread"


def test_thresholds_of_smaller_balls_are_at_the_same_gaps():
    rule, snap_back_m = scaled_thresholds(CONTACTS, -0.0049, 0.0025, 0.005)
    assert rule.wall_threshold_m == pytest.approx(-0.0027) and snap_back_m == pytest.approx(-0.0024)
    assert rule.ball_threshold_m == CONTACTS.ball_threshold_m
    assert scaled_thresholds(CONTACTS, None, 0.0025, 0.005)[1] is None


def test_the_simulation_is_timed_again(tmp_path):
    path = tmp_path / "run.h5"
    mill, contact = (
        yaml.safe_load((ROOT / "config" / name).read_text()) for name in ("mills/emax.yaml", "contacts/calibrated.yaml")
    )
    dem = configuration()["dem"]
    case = {"mill": "emax", "contact": "calibrated", "ball_diameter_m": 0.01, "fill_ratio": 0.1, "speed_hz": 5.0}
    case |= {"seed": 0, "settle_s": 0.01, "discard_s": 5.0, "window_s": 1.0, "snapshot_interval_s": 1e-4}
    write_run(simulate(3), path, {"mill": mill, "contact": contact, "case": case, "dem": dem})
    simulation_seconds(path, 1e-3)  # compiles the kernels where no test did
    begin = time.perf_counter()
    seconds = simulation_seconds(path, 0.05)
    assert 0.5 < seconds < 1e4
    # Neither the five seconds left out nor the window of the recorded case are simulated.
    assert time.perf_counter() - begin < max(20.0, seconds)
