"""Chapters 3 and 4: tables of the calibration and its claims, every printed digit of Tables 4.2 to 4.5."""

import statistics
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.observables.condition import Condition
from millprint.run.files import write_table
from millprint.thesis.calibration.drop import read_heights, summarise_drops
from millprint.thesis.claims.evidence import Finding, agrees, judge_repeats
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.curves.regimes import (
    Chemistry,
    cases_at,
    compare_with_prior,
    design_cases,
    energy_leverage,
    equal_power_speed,
    fit_slopes,
    power_as_run,
    read_regimes,
    specific_yields,
    with_curves,
    with_published,
)
from millprint.thesis.curves.scaling import tabulate_collapse
from tests.conftest import PRINTED
from tests.unit.claim_words import word_of
from tests.unit.synthetic_mill import descriptors, fingerprint

CONFIG = Path(__file__).parents[2] / "config/config.yaml"


def test_measured_drops_give_the_mean_of_eq_3_19_with_students_interval(tmp_path):
    heights = {"drop_height_mm": [100, 100, 50], "bounce_height_mm": [9, 16, 4.5]}
    write_table(pd.DataFrame(heights), tmp_path / "table.tsv")
    drops = read_heights(str(tmp_path / "table.tsv"))
    np.testing.assert_allclose(drops["restitution"], [0.3, 0.4, 0.3])
    found = summarise_drops(drops, 0.95)
    assert found["mean"] == pytest.approx(1 / 3)
    # t(0.975; 2) = 4.303 times the standard error 0.1 / 3.
    assert found["upper"] - found["mean"] == pytest.approx(4.3027 * 0.1 / 3, rel=1e-4)


def friction_table(static: float, rolling: float, **changed) -> pd.DataFrame:
    rows = {"parameter": ["static_friction", "rolling_friction"], "estimate": [static, rolling]}
    rows |= {"lower": [0.995 * static, 0.995 * rolling], "upper": [1.005 * static, 1.005 * rolling]}
    fixed = {"experiment": "calibrated", "source": "simulated", "contact": "calibrated", "mill": "emax"}
    fixed |= {"track_mill": "emax", "rms_mm": 0.3, "frames": 180}
    return pd.DataFrame(rows).assign(**fixed | changed)


def friction_claim(results: Path) -> Finding:
    return collect_findings(results, CONFIG.parent / "data/claims.tsv", "3.friction")["3.friction_fit"]


@pytest.mark.parametrize(("pair", "expected"), [((0.298, 0.0455), "agrees"), ((0.33, 0.045), "differs")])
def test_the_friction_claim_uses_the_track_of_the_same_mill(tmp_path, pair, expected):
    write_table(friction_table(*pair), tmp_path / "calibration/calibrated/friction_fit.tsv")
    other = friction_table(0.45, 0.04, experiment="another", track_mill="emax_smooth")
    write_table(other, tmp_path / "calibration/another/friction_fit.tsv")
    assert word_of("0.30/0.045", "recover", friction_claim(tmp_path)) == expected


def test_a_wide_fit_decides_nothing_and_a_measured_track_is_none_on_the_friction_claim(tmp_path):
    path = tmp_path / "calibration/calibrated/friction_fit.tsv"
    write_table(friction_table(0.3, 0.045, lower=0.0, upper=1.0), path)
    assert judge_repeats("0.30/0.045", "recover", friction_claim(tmp_path)) == ("open", "wider than the tolerance")
    write_table(friction_table(0.3, 0.045, source="measured"), path)
    assert friction_claim(tmp_path).value is None


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


def test_the_spread_of_a_collapse_is_the_sample_deviation_over_the_mean():
    own = descriptors()
    found = tabulate_collapse(own).set_index(["quantity", "fill_ratio"])
    for fill, at in own.groupby("fill_ratio"):
        rate, scaled = statistics.stdev(at["specific_frequency_hz"]), statistics.stdev(at["f"])
        row = found.loc[("f", fill)]
        assert row["spread_dimensional"] == pytest.approx(rate / statistics.mean(at["specific_frequency_hz"]))
        assert row["spread_scaled"] == pytest.approx(scaled / statistics.mean(at["f"]), rel=1e-9, abs=1e-12)
