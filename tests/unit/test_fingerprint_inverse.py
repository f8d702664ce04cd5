"""Inverse mode: the thesis's 1698 rpm, and conditions that are found again from their own descriptors."""

import numpy as np
import pytest
from millprint.fingerprint.master import MasterCurves

from millprint.fingerprint.inverse import CurvePoint, descriptors_at, invert_speed, solve_speed
from millprint.fingerprint.search import Allowed, rank_conditions
from tests.unit.synthetic_mill import AMPLITUDE, DENSITY, VOLUME, fitted_curves

PRINTED = CurvePoint(39.7, 90.0, 40.0)  # Table 4.2, fill 0.10
TARGET = {"normal_energy_J": 2.21e-4, "tangential_energy_J": 5.00e-4, "frequency_per_ball_hz": 400.0}
EQUAL = dict.fromkeys(TARGET, 1.0)


@pytest.fixture(scope="module")
def curves() -> MasterCurves:
    return fitted_curves()


def test_the_thesis_speed_keeps_the_energies_and_loses_the_frequency():
    table = invert_speed(TARGET, PRINTED, 0.10, DENSITY, AMPLITUDE, 0.005, VOLUME).set_index("kept")
    assert round(table.loc["normal energy", "speed_rpm"]) == 1698
    assert table.loc["both energies", "speed_rpm"] == pytest.approx(1698, rel=2e-3)
    assert table.loc["both energies", "balls"] == 191
    assert abs(table.loc["both energies", "normal_energy_J_residual_percent"]) < 0.2
    # The frequency per ball is that of 600 rpm times 2 sqrt 2: not kept, against the text of Sec. 3.3.4.
    assert table.loc["both energies", "frequency_per_ball_hz_residual_percent"] == pytest.approx(182.8, abs=0.5)
    assert table.loc["frequency per ball", "speed_rpm"] == pytest.approx(600, rel=1e-12)


@pytest.mark.parametrize("kept", ["normal_energy_J", "tangential_energy_J", "frequency_per_ball_hz"])
def test_a_descriptor_kept_alone_is_met_exactly(kept):
    speed = solve_speed(TARGET, PRINTED, DENSITY, AMPLITUDE, 0.007, {kept: 1.0})
    assert descriptors_at(PRINTED, speed, DENSITY, AMPLITUDE, 0.007)[kept] == pytest.approx(TARGET[kept], rel=1e-12)


def test_no_weight_at_all_is_refused():
    with pytest.raises(ValueError, match="weight"):
        solve_speed(TARGET, PRINTED, DENSITY, AMPLITUDE, 0.01, {})


@pytest.mark.parametrize(("speed", "diameter", "fill"), [(10.0, 0.01, 0.10), (18.0, 0.005, 0.17), (12.5, 0.008, 0.06)])
def test_a_condition_is_found_again_from_its_descriptors(curves, speed, diameter, fill):
    known = curves.predict(speed, diameter, fill)
    target = {name: getattr(known, name).value for name in TARGET}
    allowed = Allowed((5.0, 33.0), (0.04, 0.40), (0.005, 0.008, 0.01))
    best = rank_conditions(target, [curves], allowed, EQUAL, 5).iloc[0]
    assert best["distance"] < 1e-3
    assert best["ball_diameter_mm"] == pytest.approx(diameter * 1e3)
    assert best["fill_ratio"] == pytest.approx(fill, rel=5e-3)
    assert best["speed_rpm"] == pytest.approx(speed * 60, rel=5e-3)


def test_ranking_stays_in_the_allowed_range_and_is_sorted(curves):
    allowed = Allowed((8.0, 9.0), (0.06, 0.20), (0.005, 0.01))
    table = rank_conditions(TARGET, [curves], allowed, EQUAL, 3)
    assert table["speed_rpm"].between(480 - 1e-9, 540 + 1e-9).all()
    assert table["fill_ratio"].between(0.06, 0.20).all()
    assert list(table["rank"]) == list(range(1, len(table) + 1)) and len(table) <= 3
    assert table["distance"].is_monotonic_increasing
    assert np.isfinite(table.filter(like="residual").to_numpy()).all()


def test_no_common_fill_ratio_gives_an_empty_ranking(curves):
    table = rank_conditions(TARGET, [curves], Allowed((8.0, 9.0), (0.5, 0.6), (0.01,)), EQUAL, 3)
    assert table.empty and "distance" in table
