"""Chapters 3 and 4: tables of the calibration and its claims, every printed digit of Tables 4.2 to 4.5."""

import statistics
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.stats import linregress

from millprint.observables.condition import Condition
from millprint.run.files import write_table
from millprint.thesis.claims.evidence import Finding, judge_repeats
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.drop import read_heights, summarise_drops
from millprint.thesis.regimes import (
    cases_at,
    design_cases,
    equal_power_speed,
    fit_slopes,
    power_as_run,
    read_regimes,
    specific_yields,
    with_curves,
    with_published,
)
from millprint.thesis.scaling import tabulate_collapse
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


@pytest.fixture(scope="module")
def measured() -> pd.DataFrame:
    return read_regimes(DATA / "regimes.tsv")


@pytest.fixture(scope="module")
def runs(measured) -> pd.DataFrame:
    return measured.assign(power_W=design_cases(measured, REFERENCE)["power_as_printed_W"])


def test_equal_power_is_equal_and_a_like_case_keeps_the_speed(measured):
    table = design_cases(measured, REFERENCE)
    kept = table[table["mode"].isin(["reference", "power"])]
    np.testing.assert_allclose(kept["power_W"], kept["power_W"].iloc[0], rtol=1e-12)
    assert equal_power_speed(10.0, 24, 129.7, 24, 129.7) == pytest.approx(10.0)
    assert equal_power_speed(10.0, 24, 100.0, 24, 12.5) == pytest.approx(20.0)


def test_gains_and_slopes_of_the_printed_cases_are_by_hand(runs):
    table = specific_yields(runs).set_index("case")
    # Yield over printed power, 0.71 / 6.9 of the reference and 0.84 / 3.0 of shear at constant speed.
    assert table["gain_percent"]["reference"] == 0
    assert table["gain_percent"]["speed.tangential"] == pytest.approx(100 * (0.84 / 3.0 / (0.71 / 6.9) - 1))
    assert table["mass_gain_percent"]["power.normal"] == pytest.approx(100 * (1.87 * 0.40 / (1.10 * 0.71) - 1))
    slopes = fit_slopes(runs, 0.95).set_index("series")
    for series, yields in (("speed", [0.84, 0.71, 0.43]), ("power", [0.94, 0.71, 0.40])):
        line = linregress([6, 10, 17], yields)
        # Student's quantile of one degree of freedom.
        half, own = 12.7062047 * line.stderr, slopes.loc[series]
        assert own[["intercept", "slope_per_pp"]].tolist() == pytest.approx([line.intercept, line.slope])
        assert own[["slope_lower", "slope_upper"]].tolist() == pytest.approx([line.slope - half, line.slope + half])
        assert (own["points"], own["r2"], own["p_value"]) == pytest.approx((3, line.rvalue**2, line.pvalue))


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
