"""Drums of balls: what their power must be in limits, and what a slice needs to be more than a plane."""

import numpy as np
import pytest

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.simulation import Simulation
from millprint.validation.tumbling_runs import critical_speed_rpm, simulate

CONTACT = ContactConfig(
    name="test", source="test", restitution=0.6, static_friction=0.3, wall_static_friction=0.5, rolling_friction=0.01,
    density_kg_m3=7800, young_modulus_gpa=2.0, poisson_ratio=0.3,
)  # fmt: skip
DEM = DemConfig(rayleigh_fraction_max=0.2)
CRITICAL = critical_speed_rpm(0.05, 0.01)


def drum(length_mm: float) -> MillConfig:
    return MillConfig(
        name="drum", title="drum", source="test", volume_ml=round(7.831 * length_mm, 1),
        geometry={"kind": "cylinder", "axis": "y", "radius_mm": 50, "height_mm": length_mm, "fillet_ends": "none"},
        motion={"kind": "rotation", "axis": [0, 1, 0]},
    )  # fmt: skip


def case(speed_rpm: float, fill_ratio: float = 0.15, **values) -> Case:
    turn_s = 60 / speed_rpm
    return Case(
        mill="drum", contact="test", ball_diameter_m=0.01, fill_ratio=fill_ratio, speed_hz=speed_rpm / 60,
        rayleigh_fraction=0.1, closure_max=0.05, snapshot_interval_s=turn_s / 36,
        **{"seed": 0, "settle_s": 0.2, "discard_s": 2 * turn_s, "window_s": 6 * turn_s} | values,
    )  # fmt: skip


@pytest.mark.slow
def test_in_a_steady_drum_the_work_of_the_walls_is_dissipated():
    results, _ = simulate(case(0.7 * CRITICAL), drum(30), CONTACT, DEM)
    assert results["power_W"] > 0
    assert results["dissipation_W"] == pytest.approx(results["power_W"], rel=0.03)
    assert 90 < results["toe_deg"] < 200 < results["shoulder_deg"] < 360


@pytest.mark.slow
def test_a_charge_that_centrifuges_in_a_smooth_drum_takes_almost_no_energy():
    """What turns with the shell stays there where m (w^2 r - g) > 0 presses it on at the top; here that is 9 g.

    Friction holds it everywhere if mu > 1 / sqrt((w^2 r / g)^2 - 1), the largest ratio of g along the shell to the
    acceleration into it. A charge that starts at rest slides first, for 3 to 12 s from start to start.
    """
    share = 3.0
    assert CONTACT.at_wall.static_friction > 1 / np.sqrt(share**4 - 1)
    fast, slow = share * CRITICAL, 0.7 * CRITICAL
    tumbling, _ = simulate(case(slow, fill_ratio=0.06), drum(11), CONTACT, DEM)
    spun, _ = simulate(case(fast, fill_ratio=0.06, discard_s=13.0, window_s=0.5), drum(11), CONTACT, DEM)
    assert spun["carried"] == 10
    # A turn: gravity still rolls the balls a little to and fro on the shell.
    a_turn = spun["power_W"] / fast
    assert abs(a_turn) < 0.05 * tumbling["power_W"] / slow


def test_balls_of_a_slice_do_not_stay_in_its_middle():
    start = Simulation(case(0.7 * CRITICAL), drum(11), CONTACT, DEM).balls.position[:, 1]
    assert np.abs(start).max() <= 0.5e-3
    assert np.ptp(start) > 0.5e-3
