"""The user's tables of the calibration, its configuration, and its claims."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from millprint.config.calibration import CalibrationConfig
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.run.files import write_table
from millprint.thesis.calibration.drop import read_heights, summarise_drops
from millprint.thesis.calibration.oscillation import read_track
from millprint.thesis.claims.evidence import Finding
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.claims.tolerances import judge_repeats
from tests.unit.claim_words import word_of

CONFIG = Path(__file__).parents[2] / "config/config.yaml"


def written(folder: Path, **columns) -> str:
    path = folder / "table.tsv"
    write_table(pd.DataFrame(columns), path)
    return str(path)


def test_measured_drops_give_the_mean_of_eq_3_19_with_students_interval(tmp_path):
    path = written(tmp_path, drop_height_mm=[100, 100, 50], bounce_height_mm=[9, 16, 4.5])
    drops = read_heights(path)
    np.testing.assert_allclose(drops["restitution"], [0.3, 0.4, 0.3])
    found = summarise_drops(drops, 0.95)
    assert found["mean"] == pytest.approx(1 / 3)
    # t(0.975; 2) = 4.303 times the standard error 0.1 / 3.
    assert found["upper"] - found["mean"] == pytest.approx(4.3027 * 0.1 / 3, rel=1e-4)


@pytest.mark.parametrize(
    ("columns", "parts"),
    [
        ({"drop_height_mm": [10, 10]}, ["bounce_height_mm", "missing"]),
        ({"drop_height_mm": [10, 10], "bounce_height_mm": [1, 11]}, ["bounce_height_mm, row 2 = 11", "at most"]),
        ({"drop_height_mm": [10, -10], "bounce_height_mm": [1, 1]}, ["drop_height_mm", "row 2 = -10", "above 0"]),
        ({"drop_height_mm": [10], "bounce_height_mm": [1]}, ["1 rows", "at least 2"]),
    ],
)
def test_bad_drops_are_refused_in_one_line(tmp_path, columns, parts):
    with pytest.raises(ConfigError) as caught:
        read_heights(written(tmp_path, **columns))
    assert "\n" not in str(caught.value) and all(part in str(caught.value) for part in ["table.tsv", *parts])


TIMES = np.arange(30) / 50


@pytest.mark.parametrize(
    ("columns", "parts"),
    [
        ({"time_s": TIMES}, ["across_mm or height_mm", "missing"]),
        ({"time_s": TIMES, "across_cm": TIMES}, ["across_mm or height_mm", "missing", "across_cm"]),
        ({"time_s": TIMES[:5], "across_mm": TIMES[:5]}, ["5 rows", "at least 20"]),
        ({"time_s": TIMES[::-1], "across_mm": TIMES}, ["time_s, row 2", "more than in the row before"]),
        ({"time_s": TIMES - 1, "across_mm": TIMES}, ["time_s", "row 1 = -1", "at least 0"]),
        ({"time_s": TIMES, "height_mm": ["lost", *TIMES[1:]]}, ["height_mm, row 1", "lost", "finite number"]),
    ],
)
def test_bad_tracks_are_refused_in_one_line(tmp_path, columns, parts):
    with pytest.raises(ConfigError) as caught:
        read_track(written(tmp_path, **columns))
    assert "\n" not in str(caught.value) and all(part in str(caught.value) for part in ["table.tsv", *parts])


@pytest.mark.parametrize(
    ("place", "value", "parts"),
    [
        (("release", "across"), [1, 0, 0], ["release", "across", "perpendicular"]),
        (("static_friction",), [1.0, 0.5], ["static_friction", "below"]),
        (("experiments", 0), {"name": "a", "contact": "b", "track": "c", "track_mill": "d"}, ["track_mill", "both"]),
        (("experiments", 1, "name"), "calibrated", ["experiments", "calibrated"]),
        (("duration_s",), -1, ["duration_s", "-1"]),
    ],
)
def test_a_bad_section_is_refused_in_one_line(place, value, parts):
    content = yaml.safe_load(CONFIG.read_text())["calibration"]
    inner = content["oscillation"]
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    with pytest.raises(ConfigError) as caught:
        check_model(content, CalibrationConfig, "config.yaml")
    assert "\n" not in str(caught.value) and all(part in str(caught.value) for part in parts)


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
    finding = friction_claim(tmp_path)
    assert word_of("0.30/0.045", "recover", finding) == expected
    assert "emax_smooth gives 0.45/0.04" in finding.explanation


def test_a_wide_fit_decides_nothing_on_the_friction_claim(tmp_path):
    table = friction_table(0.3, 0.045, lower=0.0, upper=1.0)
    write_table(table, tmp_path / "calibration/calibrated/friction_fit.tsv")
    assert judge_repeats("0.30/0.045", "recover", friction_claim(tmp_path)) == ("open", "wider than the tolerance")


def test_without_a_simulated_track_the_friction_claim_is_not_run(tmp_path):
    write_table(friction_table(0.3, 0.045, source="measured"), tmp_path / "calibration/mine/friction_fit.tsv")
    assert friction_claim(tmp_path).value is None
