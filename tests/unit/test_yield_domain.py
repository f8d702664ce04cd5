"""Where a yield model may be asked: one setting of the mill for its descriptors, and runs nearby in its metric."""

from typing import ClassVar

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.yields import PredictionConfig
from millprint.thesis.curves.regimes import read_regimes
from millprint.thesis.yields.averaging import AveragedModel, Candidate, fit_member
from millprint.thesis.yields.experiments import Mill, described_settings
from millprint.thesis.yields.groups import regime_rows
from millprint.thesis.yields.new_conditions import (
    DESCRIPTORS,
    MillCurves,
    correlation_warnings,
    domain_warnings,
    nearest_correlation,
)
from tests.unit.test_yield_proposals import MILL, REFERENCE, REGIMES, SCALES
from tests.unit.yield_settings import all_runs, settings

CASES = read_regimes(str(REGIMES))
CURVES = MillCurves("emax", CASES, MILL.density, MILL.amplitude, (10.0,), (540.0, 1000.0))
TOLERANCE = settings().prediction.curve_tolerance
# The energies of 600 rpm at a fill ratio of 10 %, with the frequency of 1000 rpm.
MIXED = {"normal_energy_uJ": 221.0, "tangential_energy_uJ": 500.0, "specific_frequency_hz": 667.0}


def described(curves: pd.DataFrame = CASES, mill: Mill = MILL, **changes) -> pd.DataFrame:
    """One condition with the descriptors that the curves give."""
    setting = {"bpr": 30, "molar_ratio": 10, "time_h": 12.5, "speed_rpm": 700, "fill_ratio": 0.08}
    return described_settings(pd.DataFrame([setting | {"ball_diameter_mm": 10} | changes]), curves, mill)


def test_every_run_is_a_setting_of_the_mill():
    rows = pd.concat([all_runs(), regime_rows(CASES, REFERENCE)])
    assert CURVES.warnings(rows, TOLERANCE) == [""] * 31


@pytest.mark.parametrize("speed", [560, 700, 990])
@pytest.mark.parametrize("fill", [0.06, 0.075, 0.13, 0.17])
def test_what_the_curves_give_is_possible_and_what_they_do_not_is_not(speed, fill):
    row = described(speed_rpm=speed, fill_ratio=fill)
    assert CURVES.warnings(row, TOLERANCE) == [""]
    for name in DESCRIPTORS:
        assert CURVES.warnings(row.assign(**{name: 1.6 * row[name]}), TOLERANCE) != [""]


def test_energies_of_one_speed_with_the_frequency_of_another_are_refused():
    row = described(bpr=50, time_h=20).assign(**MIXED)
    (told,) = CURVES.warnings(row, TOLERANCE)
    assert told.startswith("descriptors that emax does not have at once") and "specific_frequency_hz" in told
    assert ";" not in told and "\n" not in told


def test_a_ball_size_or_a_speed_that_the_mill_does_not_have_is_refused():
    assert CURVES.warnings(described(ball_diameter_mm=7), TOLERANCE) != [""]
    assert CURVES.warnings(described(speed_rpm=1400), TOLERANCE) != [""]
    other = MillCurves("emax", CASES, MILL.density, MILL.amplitude, (7.0, 10.0), (540.0, 1500.0))
    assert other.warnings(described(ball_diameter_mm=7), TOLERANCE) == [""]
    assert other.warnings(described(speed_rpm=1400), TOLERANCE) == [""]
    # Smaller balls at a higher speed have these energies with this frequency.
    assert other.warnings(described().assign(**MIXED), TOLERANCE) == [""]


def test_a_descriptor_within_the_band_of_its_curve_is_possible():
    row = described()
    off = row.assign(specific_frequency_hz=1.25 * row["specific_frequency_hz"])
    assert CURVES.warnings(off, TOLERANCE) != [""]
    band = {f"{name}{end}": CASES[name] * (1 + step) for name in ("Pn", "Pt", "f") for end, step in BAND.items()}
    wide = MillCurves("emax", CASES.assign(**band), MILL.density, MILL.amplitude, (10.0,), (540.0, 1000.0))
    assert wide.warnings(off, TOLERANCE) == [""]


BAND = {"_lower": -0.2, "_upper": 0.25}


def test_the_curves_are_read_as_they_were_written_and_others_are_refused_in_one_line(tmp_path):
    path = tmp_path / "mill.json"
    CURVES.write(path)
    again = MillCurves.read(path)
    rows = pd.concat([described(), described().assign(**MIXED)])
    assert again.warnings(rows, TOLERANCE) == CURVES.warnings(rows, TOLERANCE)
    for text in ("[]", "{", '{"format": "else"}', '{"format": "millprint curves of a mill 1"}'):
        path.write_text(text)
        with pytest.raises(ConfigError, match=r"mill\.json") as caught:
            MillCurves.read(path)
        assert "\n" not in str(caught.value)


def one_member() -> tuple[AveragedModel, pd.DataFrame]:
    rows = all_runs()
    yields = rows["yield_percent"].to_numpy(float)
    member = fit_member(Candidate("avrami", SCALES, "product"), rows, yields, settings().averaging)
    return AveragedModel([member], np.array([1.0])), rows


def test_the_correlation_is_one_at_a_run_and_that_of_the_kernel_elsewhere():
    model, rows = one_member()
    np.testing.assert_allclose(nearest_correlation(model, rows, rows), 1)
    member = model.members[0]
    only, lengths = rows.iloc[[0]], np.exp(member.process.logs[:5])
    # One length scale further in the molar ratio, which is on a linear scale.
    step = lengths[1] * member.standard.deviation[1]
    moved = only.assign(molar_ratio=only["molar_ratio"] + step)
    assert nearest_correlation(model, only, moved)[0] == pytest.approx(np.exp(-0.5))
    far = only.assign(molar_ratio=only["molar_ratio"] + 20 * step)
    assert nearest_correlation(model, only, far)[0] < 1e-6
    (told,) = correlation_warnings(model, only, far, 0.5)
    assert told == "correlation = 0.00 with the yield of the nearest run is below 0.5"


def test_a_gap_inside_every_range_is_refused_by_the_correlation():
    """Each condition is within its trained range, and no run is near."""
    model, rows = one_member()
    corner = rows[(rows["bpr"] < 50) | (rows["time_h"] < 20)]
    limits = settings().prediction
    left_out = rows[(rows["bpr"] == 50) & (rows["time_h"] == 20)]
    assert domain_warnings(model, rows, left_out, limits, CURVES) == ["", "", ""]

    class Strict(PredictionConfig):
        correlation_min: ClassVar[float] = 0.99

    told = domain_warnings(model, corner, left_out, Strict(**limits.model_dump()), CURVES)
    assert all(text.startswith("correlation = ") for text in told)
