"""Starting positions, steps and the Rayleigh time."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from millprint.config.contact import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.packing import capacity, inside, largest_fill, pack
from millprint.dem.simulation import Simulation
from millprint.dem.timestep import aligned_step, rayleigh_time
from millprint.errors import SimulationError
from millprint.mill.vessel import build_vessel

CONFIG = Path(__file__).parents[2] / "config"
VOLUME = 125e-6


def load_mill(name: str) -> MillConfig:
    return load_named(CONFIG / "mills", name, MillConfig, "mill")


@pytest.mark.parametrize(
    ("name", "diameter", "count"),
    [("emax", 0.010, 24), ("emax", 0.010, 95), ("emax", 0.005, 764), ("emax_post", 0.010, 24)],
)
def test_balls_start_apart_and_inside(name, diameter, count):
    vessel = build_vessel(load_mill(name))
    first, again, other = (pack(vessel, diameter, count, seed, VOLUME) for seed in (5, 5, 6))
    assert first.shape == (count, 3)
    assert pdist(first).min() >= diameter
    assert inside(vessel, first, diameter / 2).all()
    assert np.array_equal(first, again)
    assert np.abs(first - other).max() > diameter / 10


def test_too_many_balls_are_refused_with_the_largest_fill():
    vessel = build_vessel(load_mill("emax"))
    most = capacity(vessel, 0.010)
    assert most >= 96
    fill = largest_fill(vessel, 0.010, VOLUME)
    assert fill == pytest.approx(most * math.pi / 6 * 1e-6 / VOLUME, abs=0.011)
    with pytest.raises(SimulationError, match=f"largest fill ratio that does is {fill:g}"):
        pack(vessel, 0.010, most + 60, 0, VOLUME)


def test_rayleigh_time_of_a_soft_steel_ball():
    shear = 2.05e9 / (2 * 1.235)
    expected = math.pi * 0.005 * math.sqrt(7700 / shear) / (0.1631 * 0.235 + 0.8766)
    assert rayleigh_time(0.005, 7700, 2.05e9, 0.235) == pytest.approx(expected)
    assert rayleigh_time(0.005, 7700, 2.05e9, 0.235) == pytest.approx(10 * rayleigh_time(0.005, 7700, 205e9, 0.235))


def test_aligned_step():
    step, number = aligned_step(2e-6, 1e-4)
    assert number == 50
    assert step == pytest.approx(2e-6)
    step, number = aligned_step(3e-6, 1e-4)
    assert number == 34
    assert step <= 3e-6


def test_a_step_over_the_rayleigh_fraction_is_refused():
    case = Case(
        mill="emax", contact="calibrated", ball_diameter_mm=5, fill_ratio=0.1, speed_rpm=600, seed=0,
        settle_s=0.1, discard_s=0.1, window_s=0.1,
    )  # fmt: skip
    dem = DemConfig(time_step_s=1e-5, settle_s=0.1, discard_s=0.1, window_s=0.1)
    contact = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
    with pytest.raises(SimulationError, match="of the Rayleigh time"):
        Simulation(case, load_mill("emax"), contact, dem)
