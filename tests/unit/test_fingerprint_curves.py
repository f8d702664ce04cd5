"""Master curves: averages, smooth curves, predictions, collapse, exponents and zones."""

import numpy as np
import pandas as pd
import pytest
from millprint.fingerprint.master import MasterCurves
from millprint.fingerprint.smooth import smooth_curves

from millprint.errors import ConfigError
from millprint.files import write_json, write_table
from millprint.fingerprint.collapse import tabulate_collapse
from millprint.fingerprint.curves import QUANTITIES, average_curves, conditions_of, universal_descriptors
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.exponents import fit_exponents
from millprint.fingerprint.zones import choking, elbow
from tests.unit.synthetic_mill import (
    AMPLITUDE,
    DENSITY,
    FILLS,
    descriptors,
    fitted_curves,
    summaries,
    summary,
    true_curves,
)


@pytest.fixture(scope="module")
def exact() -> pd.DataFrame:
    return descriptors()


@pytest.fixture(scope="module")
def curves() -> MasterCurves:
    return fitted_curves()


def scattered(seed: int = 1, size: float = 0.05) -> pd.DataFrame:
    """Descriptors whose powers scatter between conditions."""
    generator = np.random.default_rng(seed)
    runs = [
        summary(fill, diameter, speed, noise=size * generator.standard_normal())
        for fill in FILLS
        for diameter in (5.0, 10.0)
        for speed in (600.0, 1200.0)
    ]
    return tabulate_descriptors(runs, "gap_3ms")


def test_the_average_of_a_mill_without_scatter_has_no_width(exact):
    table = average_curves(exact)
    assert list(table["fill_ratio"]) == sorted(FILLS)
    np.testing.assert_allclose(table["Pn"], true_curves(table["fill_ratio"])[0], rtol=1e-12)
    np.testing.assert_allclose(table["Pn_upper"], table["Pn_lower"], rtol=1e-9)
    assert set(table["conditions"]) == {4}


def test_a_fill_with_one_condition_borrows_the_spread_of_the_others():
    frame = scattered()
    alone = frame[~((frame["fill_ratio"] == 0.10) & ((frame["speed_rpm"] > 600) | (frame["ball_diameter_mm"] < 10)))]
    row = average_curves(alone).set_index("fill_ratio").loc[0.10]
    relative = (row["Pn_upper"] - row["Pn"]) / row["Pn"]
    assert row["conditions"] == 1
    assert 0.02 < relative < 0.10


def test_the_smooth_curve_passes_through_an_exact_mill(curves):
    table = curves.table
    for name, curve in zip(("Pn", "Pt", "f"), true_curves(table["fill_ratio"]), strict=True):
        np.testing.assert_allclose(table[name], curve, rtol=0.02)
    for name in QUANTITIES:
        assert (table[f"{name}_lower"] < table[name]).all() and (table[name] < table[f"{name}_upper"]).all()


def test_the_band_holds_new_conditions_as_often_as_it_says():
    table = smooth_curves(scattered(seed=2), 200, 0.95)
    new = scattered(seed=3)
    lower = np.interp(new["fill_ratio"], table["fill_ratio"], table["Pn_lower"])
    upper = np.interp(new["fill_ratio"], table["fill_ratio"], table["Pn_upper"])
    assert 0.85 <= ((lower < new["Pn"]) & (new["Pn"] < upper)).mean() <= 1.0
    assert np.median(upper / lower) < 1.6


def test_too_few_fills_are_refused(exact):
    with pytest.raises(ConfigError, match="2 fill ratios"):
        smooth_curves(exact[exact["fill_ratio"].isin([0.04, 0.10])], 50, 0.95)


def test_predictions_return_the_simulated_conditions(exact, curves):
    for row in exact.itertuples():
        found = curves.predict(row.speed_hz, row.ball_diameter_m, row.fill_ratio)
        assert found.outside == ()
        assert found.balls == row.balls
        assert found.normal_energy_J.value == pytest.approx(row.normal_energy_J, rel=0.03)
        assert found.frequency_per_ball_hz.value == pytest.approx(row.frequency_per_ball_hz, rel=0.03)
        assert found.power_W.value == pytest.approx(row.normal_power_W + row.tangential_power_W, rel=0.03)


def test_energies_times_frequency_are_the_power(curves):
    found = curves.predict(13.14, 0.01, 0.06)
    energies = found.normal_energy_J.value + found.tangential_energy_J.value
    assert found.balls * found.frequency_per_ball_hz.value * energies == pytest.approx(found.power_W.value, rel=1e-9)


def test_predictions_scale_as_the_equations_say(curves):
    base = curves.predict(10.0, 0.01, 0.10)
    assert curves.predict(20.0, 0.01, 0.10).power_W.value == pytest.approx(8 * base.power_W.value)
    assert curves.predict(20.0, 0.01, 0.10).normal_energy_J.value == pytest.approx(4 * base.normal_energy_J.value)
    assert curves.predict(10.0, 0.005, 0.10).tangential_energy_J.value == pytest.approx(
        base.tangential_energy_J.value / 8
    )
    far = curves.predict(10.0, 0.01, 0.10, density_kg_m3=2 * DENSITY, amplitude_m=2 * AMPLITUDE)
    assert far.power_W.value == pytest.approx(8 * base.power_W.value)


def test_what_lies_outside_is_named_or_refused(curves):
    assert set(curves.predict(30.0, 0.02, 0.10, amplitude_m=0.03).outside) == {
        "speed_hz",
        "ball_diameter_m",
        "amplitude_m",
    }
    with pytest.raises(ConfigError, match=r"fill_ratio = 0\.5.*0\.04 to 0\.4"):
        curves.predict(10.0, 0.01, 0.5)


def test_curves_are_read_back_as_written(curves, tmp_path):
    write_table(curves.table, tmp_path / "smooth.tsv", digits=12)
    write_json(curves.about, tmp_path / "smooth.json")
    again = MasterCurves.read(tmp_path / "smooth.tsv", tmp_path / "smooth.json")
    assert again.predict(12.0, 0.008, 0.13).power_W.value == pytest.approx(
        curves.predict(12.0, 0.008, 0.13).power_W.value, rel=1e-9
    )


def test_an_unknown_contact_set_is_refused(exact):
    with pytest.raises(ConfigError, match="contact set brass"):
        conditions_of(exact, "emax", "brass")


def test_scaling_collapses_what_was_far_apart(exact):
    table = tabulate_collapse(exact)
    powers = table[table["quantity"].isin(["Pn", "Pt"])]
    assert (powers["spread_dimensional"] > 0.9).all()
    assert (table["spread_scaled"] < 1e-9).all()
    assert set(table["scope"]) == {"calibrated"}


def test_the_universal_factor_collapses_sets_that_obey_it():
    both = tabulate_descriptors(
        summaries(fills=(0.06, 0.10), factor=1 / np.sqrt(1 - 0.117037))
        + summaries(contacts=("steel",), fills=(0.06, 0.10, 0.17), factor=1 / np.sqrt(1 - 0.551421)),
        "gap_3ms",
    )
    pooled = tabulate_collapse(both).query("scope == 'universal' and quantity != 'ratio'")
    assert set(pooled["fill_ratio"]) == {0.06, 0.10}
    assert (pooled["spread_scaled"] > 0.15).all()
    assert (pooled["spread_universal"] < 1e-5).all()
    np.testing.assert_allclose(universal_descriptors(both)["Pn"], true_curves(both["fill_ratio"])[0], rtol=1e-5)


def test_exponents_of_the_scaling_are_found_and_what_was_not_varied_is_said():
    table = fit_exponents(scattered(size=0.01), 0.95)
    fitted = table[table["remark"].str.startswith("fitted")]
    assert set(fitted["variable"]) == {"omega", "d"}
    np.testing.assert_allclose(fitted["exponent"], fitted["supposed"], atol=0.03)
    assert ((fitted["lower"] <= fitted["exponent"]) & (fitted["exponent"] <= fitted["upper"])).all()
    assert set(table[table["variable"].isin(["rho", "A"])]["remark"]) == {"not varied"}


def test_variables_changed_only_together_are_not_separable():
    runs = [summary(fill, d, n) for fill in (0.06, 0.10) for d, n in ((5.0, 1200.0), (10.0, 600.0))]
    table = fit_exponents(tabulate_descriptors(runs, "gap_3ms"), 0.95)
    assert set(table[table["variable"].isin(["omega", "d"])]["remark"]) == {"not separable"}


def test_the_elbow_of_two_straight_lines_is_their_crossing():
    fill = np.linspace(0.04, 0.40, 361)
    ratio = np.where(fill < 0.10, 4.0 - 30 * (fill - 0.04), 2.2 - 2 * (fill - 0.10))
    assert elbow(fill, ratio) == pytest.approx(0.10, abs=2e-3)


def test_the_elbow_leaves_out_a_rise_before_the_top_and_is_absent_without_a_fall():
    fill = np.linspace(0.04, 0.40, 361)
    peak = np.where(fill < 0.06, 3.0 + 50 * (fill - 0.06), 3.0 - 40 * (fill - 0.06))
    assert elbow(fill, np.maximum(peak, 1.4 - (fill - 0.10))) == pytest.approx(0.10, abs=2e-3)
    assert np.isnan(elbow(fill, fill))


def test_choking_begins_where_both_powers_have_fallen():
    fill = np.linspace(0.04, 0.40, 37)
    falling = np.where(fill < 0.2, 1.0, 0.5)
    assert choking(fill, falling, 1.2 * falling) == pytest.approx(0.20, abs=0.011)
    assert np.isnan(choking(fill, np.ones(37), falling))
