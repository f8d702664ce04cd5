"""An invalid run stops with one line that names the fault, the ball and the time."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from millprint.config.contact import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig, ball_count
from millprint.dem.simulation import Simulation
from millprint.errors import SimulationError

CONFIG = Path(__file__).parents[2] / "config"
MILL = load_named(CONFIG / "mills", "emax", MillConfig, "mill")
CONTACT = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
DEM = DemConfig(time_step_s=4e-6, settle_s=0.02, discard_s=0.0, window_s=0.02)


def simulation(dem=DEM, contact=CONTACT, **change) -> Simulation:
    settings = {"ball_diameter_mm": 10, "fill_ratio": 0.1, "speed_rpm": 600, "seed": 0}
    times = {name: getattr(dem, name) for name in ("settle_s", "discard_s", "window_s")}
    return Simulation(Case(mill="emax", contact="calibrated", **(settings | times | change)), MILL, contact, dem)


def refusal(action) -> str:
    """The one line by which an action is refused."""
    with pytest.raises(SimulationError) as caught:
        action()
    (line,) = str(caught.value).splitlines()
    return line


def test_the_refusal_of_too_many_balls_names_the_largest_fill():
    line = refusal(lambda: simulation(fill_ratio=0.9))
    balls, fill = re.fullmatch(
        r"(\d+) balls of 10 mm do not fit .* largest fill ratio that does is ([\d.]+)", line
    ).groups()
    assert int(balls) == ball_count(0.9, 125e-6, 0.010)
    # The fill it names can be placed, and one more hundredth cannot.
    fits = simulation(fill_ratio=float(fill))
    assert len(np.unique(fits.balls.position, axis=0)) == ball_count(float(fill), 125e-6, 0.010)
    refusal(lambda: simulation(fill_ratio=float(fill) + 0.02))


def test_less_than_one_ball_is_refused():
    assert "less than one ball of 10 mm" in refusal(lambda: simulation(fill_ratio=0.001))


def test_a_ball_outside_the_vessel_has_left_it():
    run = simulation()
    run.balls.position[7] += [0.0, 0.0, 1.0]
    assert re.fullmatch(r"ball 7 has left the vessel at -?\d+\.\d+ s", refusal(lambda: run.run("test")))


def test_a_ball_through_the_wall_is_caught_whatever_its_speed():
    """At 3 km/s a ball crosses a wall in less than a step: it overlaps too much or is outside, but never lost."""
    run = simulation()
    run.balls.rate[3, :3] = run.balls.rate_now[3, :3] = [0.0, 3000.0, 0.0]
    assert re.match(r"ball \d+ (has left the vessel|overlaps) ", refusal(lambda: run.run("test")))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_number_that_is_not_finite_names_its_ball(value):
    run = simulation()
    run.balls.velocity[5, 1] = value
    assert re.match(r"the position of ball 5 is not a finite number at -?\d+\.\d+ s", refusal(lambda: run.run("test")))


def test_an_overlap_that_is_too_large_names_both_sides_and_the_bound():
    run = simulation(DEM.model_copy(update={"overlap_max": 1e-3}))
    line = refusal(lambda: run.run("test"))
    pattern = (
        r"ball \d+ overlaps (ball|wall feature) \d+ by more than 0\.1 % of its radius at .* s: the speed is too high"
    )
    assert re.match(pattern, line)


def test_two_balls_in_one_place_overlap_too_much():
    run = simulation()
    run.balls.position[4] = run.balls.position[9] + [0.0, 0.0, 1e-3]
    assert re.match(r"ball 4 overlaps ball 9 by more than 15 %", refusal(lambda: run.run("test")))


def test_a_step_over_the_fraction_of_the_case_is_refused_and_a_wider_bound_lets_it_pass():
    """Steps of the case's own; 9e-6 s is 0.17 of the Rayleigh time of 10 mm balls."""
    tight = DEM.model_copy(update={"rayleigh_fraction_max": 0.1})
    line = refusal(lambda: simulation(tight, time_step_s=9e-6))
    assert re.match(r"the time step of 9e-06 s is 0\.17\d* of the Rayleigh time; at most 0\.1 \(", line)
    run = simulation(tight, time_step_s=9e-6, rayleigh_fraction_max=0.2)
    assert 0.99 * 9e-6 < run.step <= 9e-6
