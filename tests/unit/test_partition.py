"""Chapter 4: every printed digit of Tables 4.2 to 4.5 from the master-curve values."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.observables.condition import Condition
from millprint.thesis.claims.tolerances import agrees
from millprint.thesis.curves.energy import Chemistry, compare_with_prior, energy_leverage, fit_slopes, specific_yields
from millprint.thesis.curves.regimes import (
    cases_at,
    design_cases,
    equal_power_speed,
    power_as_run,
    read_regimes,
    with_curves,
    with_published,
)
from tests.conftest import PRINTED
from tests.unit.synthetic_mill import fingerprint

DATA = Path(__file__).parents[2] / "config/data"
REFERENCE = Condition(0.10, 10.0, 0.01, 7700.0, 0.017)
CHEMISTRY = Chemistry(0.13786, 0.03783, 1226e3, 1510e3, 2908e3)
ORDER = ["reference", "speed.tangential", "speed.normal", "power.tangential", "power.normal"]


def printed_column(form: str) -> list[str]:
    """The printed values of the claims whose id has this form, in the order of the cases."""
    return [PRINTED[form.format(case=case)] for case in ORDER]


TABLE_4_2 = {
    "speed_hz": printed_column("4.case.{case}.speed"),
    "specific_frequency_hz": printed_column("4.case.{case}.f"),
    "power_as_printed_W": printed_column("4.case.{case}.P"),
    "normal_energy_J": printed_column("4.case.{case}.En"),
    "tangential_energy_J": printed_column("4.case.{case}.Et"),
    "ratio": printed_column("4.case.{case}.ratio"),
}
TABLE_4_4 = {
    "specific_yield_per_W": printed_column("4.specific_yield.{case}"),
    "mass_per_watt_g_W": printed_column("4.mass_per_watt.{case}"),
    "gain_percent": printed_column("4.gain.{case}"),
    "mass_gain_percent": ["0", "63", "-24", "-20", "-4"],
}
TABLE_4_5 = {f"leverage_{name}_percent": printed_column(f"4.leverage.{{case}}.{name}") for name in ("dH", "dG", "LHV")}


@pytest.fixture(scope="module")
def measured() -> pd.DataFrame:
    return read_regimes(DATA / "regimes.tsv")


@pytest.fixture(scope="module")
def runs(measured) -> pd.DataFrame:
    return measured.assign(power_W=design_cases(measured, REFERENCE)["power_as_printed_W"])


def assert_printed(table: pd.DataFrame, printed: dict[str, list[str]], scale: float = 1.0) -> None:
    assert list(table["case"]) == ORDER
    for column, digits in printed.items():
        factor = 1e4 if column.endswith("energy_J") else 1.0
        for case, text, value in zip(ORDER, digits, factor * table[column], strict=True):
            assert agrees(text, "printed", float(value)), (case, column, text, value)


def test_table_4_2_to_the_printed_digits(measured):
    assert_printed(design_cases(measured, REFERENCE), TABLE_4_2)


def test_62_8_rad_s_changes_energies_powers_and_ratios_only_by_rounding(measured):
    table = design_cases(measured, replace(REFERENCE, speed_hz=62.8 / (2 * np.pi)))
    normal, tangential = (table[f"{name}_energy_J"].mul(1e4).round(2) for name in ("normal", "tangential"))
    for column, values, digits in (
        ("normal_energy_J", normal, 2),
        ("tangential_energy_J", tangential, 2),
        ("power_as_printed_W", table["power_W"], 1),
        ("ratio", tangential / normal, 2),
    ):
        assert values.round(digits).tolist() == [float(text) for text in TABLE_4_2[column]]


def test_tables_4_4_and_4_5_to_the_printed_digits(runs):
    assert_printed(specific_yields(runs), TABLE_4_4)
    assert_printed(energy_leverage(runs, CHEMISTRY, 0.5, 0.2), TABLE_4_5)


def test_equal_power_is_equal_and_a_like_case_keeps_the_speed(measured):
    table = design_cases(measured, REFERENCE)
    kept = table[table["mode"].isin(["reference", "power"])]
    np.testing.assert_allclose(kept["power_W"], kept["power_W"].iloc[0], rtol=1e-12)
    assert equal_power_speed(10.0, 24, 129.7, 24, 129.7) == pytest.approx(10.0)
    assert equal_power_speed(10.0, 24, 100.0, 24, 12.5) == pytest.approx(20.0)


def test_plug_energy_and_cost(runs):
    table = energy_leverage(runs, CHEMISTRY, 0.5, 0.2)
    # 6.9 W for 12.5 h are 0.08625 kWh; half of the plug's energy reaches the balls.
    mass = 1.10e-3 / 0.13786 * 0.71 * 0.03783
    assert table["plug_energy_kWh_kg"].iloc[0] == pytest.approx(0.08625 / (0.5 * mass), rel=1e-9)
    np.testing.assert_allclose(table["cost_EUR_kg"], 0.2 * table["plug_energy_kWh_kg"])
    doubled = energy_leverage(runs, CHEMISTRY, 0.25, 0.2)
    np.testing.assert_allclose(doubled["plug_energy_kWh_kg"], 2 * table["plug_energy_kWh_kg"])


def test_slopes_of_both_lines(measured):
    table = fit_slopes(measured, 0.95).set_index("series")
    assert agrees(PRINTED["4.slope.speed"], "printed", -table.loc["speed", "slope_per_pp"])
    assert agrees(PRINTED["4.slope.power"], "printed", -table.loc["power", "slope_per_pp"])
    assert (table["r2"] > 0.99).all()
    assert ((table["slope_lower"] < table["slope_per_pp"]) & (table["slope_per_pp"] < table["slope_upper"])).all()


def test_changes_against_prior_work():
    prior = {"yield_percent": 88, "time_h": 20, "bpr": 50, "speed_hz": 20}
    best = {"yield_percent": 94, "time_h": 12.5, "bpr": 30, "speed_hz": 13.14}
    changes = compare_with_prior(best, prior).set_index("metric")["change"]
    assert changes["yield_percent"] == 6
    for metric, name in (("time_h", "time"), ("bpr", "bpr"), ("speed_hz", "speed")):
        assert agrees(PRINTED[f"4.prior.{name}"], "printed", changes[metric])


def test_our_curves_take_the_place_of_the_published(measured):
    ours = design_cases(with_curves(measured, fingerprint()), REFERENCE)
    assert (ours["power_lower_W"] < ours["power_W"]).all() and (ours["power_W"] < ours["power_upper_W"]).all()
    assert ours["power_W"][3] == pytest.approx(ours["power_W"][0], rel=1e-9)
    np.testing.assert_allclose(power_as_run(ours, ours["speed_hz"], REFERENCE), ours["power_W"], rtol=1e-12)


def test_cases_at_any_fill_keep_speed_or_power_of_the_reference(measured):
    cases = cases_at([0.30, 0.08, 0.30], REFERENCE, 125e-6)
    assert list(cases["case"]) == ["reference", "speed.0.08", "speed.0.3", "power.0.08", "power.0.3"]
    assert list(cases["balls"]) == [24, 19, 72, 19, 72]
    table = design_cases(with_curves(cases, fingerprint()), REFERENCE).set_index("case")
    assert (table.loc[["speed.0.08", "speed.0.3"], "speed_hz"] == 10.0).all()
    np.testing.assert_allclose(table.loc[["power.0.08", "power.0.3"], "power_W"], table.loc["reference", "power_W"])
    printed = with_published(cases_at([0.06, 0.08, 0.17], REFERENCE, 125e-6), measured)
    assert set(printed["fill_ratio"]) == {0.06, 0.10, 0.17}
    assert design_cases(printed, REFERENCE).set_index("case").loc["power.0.06", "speed_hz"] == pytest.approx(
        design_cases(measured, REFERENCE).set_index("case").loc["power.tangential", "speed_hz"]
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("\treference\t", "\tbase\t", "column mode, case reference = 'base'"),
        ("0.06\t14\t23", "0.06\tmany\t23", "column balls, case speed.tangential = 'many'"),
        ("yield_percent", "yield", "column yield_percent is missing"),
        ("\tspeed\t0.06", "\treference\t0.06", "exactly one row must be the reference"),
        ("0.17\t41", "-0.17\t41", r"column fill_ratio, case speed.normal = -0.17"),
    ],
)
def test_a_faulty_table_of_cases_is_refused(tmp_path, old, new, message):
    text = (DATA / "regimes.tsv").read_text()
    assert old in text
    path = tmp_path / "regimes.tsv"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ConfigError) as error:
        read_regimes(path)
    assert message in str(error.value) and "\n" not in str(error.value)
