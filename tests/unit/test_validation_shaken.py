"""Shaken boxes: the closed law, the balance of a box on its spring, predictions of short runs, and what is refused."""

import math

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError, SimulationError
from millprint.config.setup_models import (
    LOSS_EXPONENT,
    LOST,
    PLATE_MEAN,
    QUICK,
    SETTINGS,
    SWING,
    SetupConfig,
    quantities_of,
)
from millprint.config.sweep import DemConfig
from millprint.dem.layout import TOTAL
from millprint.validation.measured import DEM, Inputs, measured_points, read_measurements
from millprint.validation.setups import predict
from millprint.validation.shaken import (
    FITTED,
    LAW,
    LAW_END,
    POURED,
    SAME,
    THICKNESS,
    ShakenBox,
    fitted_thickness,
    gap_ratio,
    law_of_loss,
    law_of_swing,
    meeting_phase,
    pour,
    spread,
)
from tests.physics.test_impacts import contact_set
from tests.workflow.conftest import ROOT

MEASURED = ROOT / "config/data/measured.tsv"
SPHERES, SMOOTH = contact_set("generic_spheres"), contact_set("smooth_spheres")
RADIUS, SIDE, FRACTION = 5e-3, 0.04, 0.2


def points_of(id: str) -> pd.DataFrame:
    points = measured_points(read_measurements(MEASURED, SETTINGS))
    return points[points["id"] == id].reset_index(drop=True)


def predicted(name: str, settings: SetupConfig, measured: pd.DataFrame) -> pd.DataFrame:
    contacts = {settings.contact: contact_set(settings.contact)}
    return predict(name, settings, None, contacts, DemConfig(), {}, "", measured)


# ---- The law ----


def test_the_table_of_the_law_is_that_of_its_equation():
    points = points_of("21a")
    assert [round(law_of_loss(x), 3) for x in points["x"]] == points["measured"].tolist()
    assert (points["class"] == "law").all()


def test_the_law_has_its_largest_loss_where_it_ends():
    assert law_of_loss(LAW_END) == pytest.approx(1, abs=1e-9)
    assert math.isnan(law_of_loss(0.99 * LAW_END))
    for gap in (0.1, 1.0, 3.0):
        tau = meeting_phase(gap)
        assert tau - math.sin(tau) == pytest.approx(gap, abs=1e-12)
    # A small gap is crossed early: tau^3 / 6 = G / A.
    assert meeting_phase(1e-6) == pytest.approx(6e-6 ** (1 / 3), rel=1e-4)


def test_the_swing_by_the_law_spends_the_energy_of_the_box():
    amplitudes = np.linspace(5.0, LAW_END, 400)
    periods = law_of_swing(amplitudes, 3.0)
    # M A^2 / 2 falls by m A^2 (1 - cos tau)^2 in a period, in units of w^2 and m.
    fall = np.gradient(3.0 * amplitudes**2 / 2, periods)[1:-1]
    lost = np.array([4 * law_of_loss(x) * x**2 for x in amplitudes[1:-1]])
    assert fall == pytest.approx(-lost, rel=0.01)


def test_a_thickness_is_found_again():
    places = np.array([0.4, 0.6, 1.0, 2.0])
    values = [law_of_loss(x / gap_ratio(1.1, 0.5)) for x in places]
    assert fitted_thickness(pd.DataFrame({"x": places, "value": values}), 0.5) == pytest.approx(1.1, abs=1e-4)
    assert gap_ratio(1.1, 0.5) == pytest.approx(0.9)


# ---- Balls in a box ----


def test_a_pile_rests_on_the_floor():
    piles = [pour(SPHERES, RADIUS, SIDE, 40, seed, FRACTION) for seed in range(3)]
    assert [pile.centres[:, 2].min() for pile in piles] == pytest.approx([RADIUS] * 3, rel=0.05)
    # Packed loosely, more so between walls that are four balls apart, or densely.
    full = 40 * 4 / 3 * math.pi * RADIUS**3 / SIDE**2
    assert 0.4 < np.mean([full / pile.thickness for pile in piles]) < 0.7
    with pytest.raises(SimulationError, match="do not fit"):
        spread(RADIUS, SIDE, 0.02, 40, 0)


@pytest.mark.slow
def test_a_box_on_a_spring_loses_what_its_balls_get_and_dissipate():
    start = spread(RADIUS, 0.052, 0.04, 37, 0)
    box = ShakenBox(start, SMOOTH, 0.04, 0.05, 1.23, FRACTION / 2)
    kg, w = 2.93 * box.mass, 2 * math.pi * 1.23
    before = kg * (w * box.amplitude) ** 2 / 2
    track = box.swing(kg, 0.75, chunk=2)
    after = kg * (w * box.amplitude) ** 2 / 2
    moving = box.balls.mass[0] * (box.balls.velocity**2).sum() / 2
    dissipated = box.totals[TOTAL.normal_damping_J]
    assert dissipated > 0.05 * before
    assert before - after == pytest.approx(moving + dissipated, rel=2e-3)
    # Without gravity nothing else gives or takes momentum: spring, box and balls.
    assert track["place_m"].iloc[0] == pytest.approx(-0.05, rel=1e-3)
    steady = ShakenBox(start, SMOOTH, 0.04, 0.05, 1.23, FRACTION).swing(1e9, 0.25)
    assert steady["amplitude_m"].to_numpy() == pytest.approx(0.05, rel=1e-6)


# ---- Predictions ----


@pytest.fixture(scope="module")
def box_table() -> pd.DataFrame:
    changes = {"varied_amplitudes": [1.0], "further_speeds_m_s": [0.6], "further_balls": []}
    changes |= {"further_restitutions": [], "further_frictions": [0.0]}
    settings = QUICK["shaken_box"].model_copy(update=changes)
    return predicted("shaken_box", settings, points_of("21a").query("x in [0.5, 1.0]"))


def test_a_short_run_of_a_shaken_box_is_near_the_law(box_table):
    own = box_table[(box_table["model"] == DEM) & (box_table["quantity"] == LOST)]
    assert own["x"].tolist() == [0.5, 1.0] and set(own["id"]) == {"21a"}
    assert own["predicted"].tolist() == pytest.approx([0.839, 0.460], rel=0.15)
    same = box_table[box_table["quantity"] == SAME]
    assert same["model"].tolist() == ["DEM, 0.6 m/s", "DEM, friction 0"]
    assert same["predicted"].to_numpy() == pytest.approx(1, abs=0.15)
    thickness = box_table[box_table["quantity"] == THICKNESS].set_index("model")["predicted"]
    assert set(thickness.index) == {FITTED, POURED} and thickness.between(0.9, 1.3).all()


@pytest.mark.slow
def test_a_box_on_a_spring_slows_down_and_meets_a_measured_time():
    row = {"id": "mine", "setup": "leaf_spring", "quantity": SWING, "unit": "-", "x": 0.7}
    table = predicted(
        "leaf_spring", QUICK["leaf_spring"].model_copy(update={"further_balls": [36]}), pd.DataFrame([row])
    )
    own = table[table["model"] == DEM]
    assert own["x"].tolist() == [0.5, 0.7, 1.0] and own["id"].tolist() == ["", "mine", ""]
    assert (np.diff(own["predicted"]) < 0).all() and own["predicted"].iloc[0] < SETTINGS[
        "leaf_spring"
    ].amplitude_diameters
    assert (own["lower"] < own["upper"]).all() and set(own["interval"]) == {"scatter of seeds and number of balls"}
    law = table[table["model"] == LAW]
    assert law["predicted"].iloc[0] == pytest.approx(10.7)
    assert np.interp(1.0, law["x"], law["predicted"]) == pytest.approx(own["predicted"].iloc[-1], rel=0.2)


@pytest.mark.slow
def test_the_power_of_a_plate_is_of_the_order_of_the_bouncing_ball():
    table = predicted("shaken_plate", QUICK["shaken_plate"], pd.concat([points_of("23a"), points_of("23c")]))
    single = table[table["x"].isna()].set_index("quantity")
    assert single["id"].to_dict() == {PLATE_MEAN: "23c", LOSS_EXPONENT: "23a"}
    assert 0.14 < single.loc[PLATE_MEAN, "predicted"] < 0.98


@pytest.mark.parametrize(
    ("name", "quantity", "words"),
    [
        ("shaken_box", LOST, "x = -1: the amplitude over the free gap must be above 0"),
        ("leaf_spring", SWING, "x = -1: the time must be above 0"),
    ],
)
def test_a_place_that_is_not_above_zero_is_refused_in_one_line(monkeypatch, name, quantity, words):
    monkeypatch.setattr(Inputs, "simulated", None)
    row = {"id": "t1", "setup": name, "quantity": quantity, "unit": "-", "x": -1.0}
    with pytest.raises(ConfigError, match=words) as refused:
        predicted(name, SETTINGS[name], pd.DataFrame([row]))
    assert "\n" not in str(refused.value) and quantity in quantities_of(SETTINGS[name])
