"""Master curves: averages, collapse, exponents of the scaling, and the marks on a curve."""

import numpy as np
import pandas as pd
import pytest
import statsmodels.api as sm

from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.mill_collapse import choking, elbow
from millprint.thesis.scaling import (
    FACTOR,
    average_curves,
    fit_exponents,
    tabulate_collapse,
    tabulate_counting_rules,
    universal_descriptors,
)
from tests.unit.synthetic_mill import AMPLITUDE, DENSITY, FILLS, descriptors, overrides, summaries, summary, true_curves


@pytest.fixture(scope="module")
def exact() -> pd.DataFrame:
    return descriptors()


def scattered(seed: int = 1, size: float = 0.05) -> pd.DataFrame:
    """Descriptors whose powers scatter between conditions."""
    generator = np.random.default_rng(seed)
    runs = [
        summary(fill, diameter, speed, noise=size * generator.standard_normal())
        for fill in FILLS
        for diameter in (5.0, 10.0)
        for speed in (600.0, 1200.0)
    ]
    return tabulate_descriptors(runs, "gap_0_03")


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


def test_the_universal_factor_collapses_sets_that_obey_it():
    both = tabulate_descriptors(
        summaries(fills=(0.06, 0.10), factor=1 / np.sqrt(1 - 0.117037))
        + summaries(contacts=("steel",), fills=(0.06, 0.10, 0.17), factor=1 / np.sqrt(1 - 0.551421)),
        "gap_0_03",
    )
    pooled = tabulate_collapse(both).query("scope == 'universal' and quantity != 'ratio'")
    assert set(pooled["fill_ratio"]) == {0.06, 0.10}
    energies = pooled["quantity"].isin(["En_star", "Et_star"])
    assert (pooled.loc[~energies, "spread_scaled"] > 0.15).all() and (
        pooled.loc[energies, "spread_scaled"] < 1e-9
    ).all()
    assert (pooled["spread_universal"] < 1e-5).all()
    np.testing.assert_allclose(universal_descriptors(both)["Pn"], true_curves(both["fill_ratio"])[0], rtol=1e-5)


def exponents_of(runs: list[dict]) -> pd.DataFrame:
    return fit_exponents(tabulate_descriptors(runs, "gap_0_03"), tabulate_counting_rules(runs), 0.95)


@pytest.mark.slow
def test_exponents_of_an_exact_mill_are_those_of_the_scaling():
    table = exponents_of(summaries() + overrides())
    assert set(table["variable"]) == {"rho", "omega", "A", "d", FACTOR}
    fitted = table[table["exponent"].notna()]
    assert set(fitted["variable"]) == {"rho", "omega", "A", "d"}
    np.testing.assert_allclose(fitted["exponent"], fitted["supposed"], atol=1e-9)
    levels = fitted[fitted["quantity"] == "normal_power_per_ball_W"].set_index("variable")["levels"]
    assert levels.to_dict() == {"rho": 3, "omega": 2, "A": 4, "d": 2}


@pytest.mark.slow
def test_other_exponents_are_found_and_differ_from_the_supposed():
    generator = np.random.default_rng(4)
    runs = summaries(fills=(0.06, 0.10, 0.17)) + overrides()
    for run in runs:
        # The true mill: power with A^1.5 and rho^1.2, collisions with omega^0.7.
        strength = (run["amplitude_m"] / AMPLITUDE) ** -0.5 * (run["density_kg_m3"] / DENSITY) ** 0.2
        for channel in ("normal", "tangential"):
            run["power_W"][channel] *= strength * np.exp(0.01 * generator.standard_normal())
        for rule in run["collisions"]:
            rule["frequency_hz"] *= (run["frequency_hz"] / 10.0) ** -0.3
    table = exponents_of(runs)
    table = table[table["counting_rule"] == "gap_0_03"].set_index(["quantity", "variable"])
    for quantity, variable, true, agrees in (
        ("normal_power_per_ball_W", "A", 1.5, "differs"),
        ("tangential_power_per_ball_W", "rho", 1.2, "differs"),
        ("specific_frequency_hz", "omega", 0.7, "differs"),
        ("normal_power_per_ball_W", "omega", 3.0, "agrees"),
    ):
        row = table.loc[(quantity, variable)]
        assert row["lower"] <= true <= row["upper"] and row["upper"] - row["lower"] < 0.2
        assert row["exponent"] == pytest.approx(true, abs=0.05)
        assert row["verdict"] == agrees


@pytest.mark.slow
def test_the_interval_is_that_of_a_regression_with_a_constant_for_each_group():
    """Two groups of three speeds: slopes and degrees of freedom as statsmodels has them with dummies."""
    generator = np.random.default_rng(5)
    runs = [
        summary(fill, speed_rpm=speed, noise=0.05 * generator.standard_normal())
        for fill in (0.06, 0.10)
        for speed in (600.0, 800.0, 1200.0)
    ]
    table = exponents_of(runs)
    found = table[(table["quantity"] == "normal_power_per_ball_W") & (table["variable"] == "omega")].iloc[0]
    frame = tabulate_descriptors(runs, "gap_0_03")
    design = pd.get_dummies(frame["fill_ratio"], dtype=float).assign(speed=np.log(frame["speed_hz"]))
    fit = sm.OLS(np.log(frame["normal_power_W"] / frame["balls"]).to_numpy(), design.to_numpy()).fit()
    assert found["exponent"] == pytest.approx(fit.params[-1], rel=1e-9)
    np.testing.assert_allclose(found[["lower", "upper"]].astype(float), fit.conf_int(0.05)[-1], rtol=1e-9)


def test_variables_changed_only_together_have_no_exponents():
    runs = [summary(fill, d, n) for fill in (0.06, 0.10) for d, n in ((5.0, 1200.0), (10.0, 600.0))]
    table = exponents_of(runs)
    assert table["exponent"].isna().all()
    assert set(table["remark"]) == {"not varied with all else kept"}


@pytest.mark.slow
def test_the_factor_of_the_restitution_is_an_exponent_too():
    """Sets that obey Eqs 3.31 and 3.32 have the exponent -1/2 of 1 - eps; equal sets have none."""
    obeying = summaries(factor=1 / np.sqrt(1 - 0.117037))
    obeying += summaries(contacts=("steel",), factor=1 / np.sqrt(1 - 0.551421))
    for runs, true in ((obeying, -0.5), (summaries(contacts=("calibrated", "steel")), 0.0)):
        table = exponents_of(runs)
        factor = table[table["variable"] == FACTOR]
        assert list(factor["quantity"]) == ["Pn", "Pt", "P", "f"] and set(factor["contact"]) == {"all"}
        np.testing.assert_allclose(factor["exponent"], true, atol=1e-4)


def test_the_spread_of_a_sweep_over_amplitude_is_its_own():
    runs = summaries() + overrides()
    for run in runs:
        run["power_W"]["normal"] *= (run["amplitude_m"] / AMPLITUDE) ** -2
    table = tabulate_collapse(tabulate_descriptors(runs, "gap_0_03"))
    spread = table[table["quantity"] == "Pn"].groupby("compared")["spread_scaled"].max()
    assert spread["speed and ball size"] < 1e-9 and spread["density"] < 1e-9
    assert spread["amplitude"] > 0.4
    swept = table[(table["compared"] == "amplitude") & (table["quantity"] == "Pn")]
    # Fill 0.17 is not in the sweep as built, so there only its three amplitudes count.
    assert dict(zip(swept["fill_ratio"], swept["conditions"], strict=True)) == {0.06: 4, 0.10: 4, 0.17: 3}
    assert swept["spread_dimensional"].max() < 1e-9


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
