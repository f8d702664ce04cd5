"""The user's tables of the calibration, its configuration, and its claims."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.run.files import write_table
from millprint.thesis.calibration.drop import read_heights, summarise_drops
from millprint.thesis.claims.evidence import Finding
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.claims.tolerances import TOO_WIDE, interval_verdict, verdict

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


def friction_table(static: float, rolling: float, **changed) -> pd.DataFrame:
    rows = {"parameter": ["static_friction", "rolling_friction"], "estimate": [static, rolling]}
    rows |= {"lower": [0.995 * static, 0.995 * rolling], "upper": [1.005 * static, 1.005 * rolling]}
    fixed = {"experiment": "calibrated", "source": "simulated", "contact": "calibrated", "mill": "emax"}
    fixed |= {"track_mill": "emax", "rms_mm": 0.3, "frames": 180}
    return pd.DataFrame(rows).assign(**fixed | changed)


def friction_claim(results: Path) -> Finding:
    return collect_findings(results, CONFIG.parent / "data/claims.tsv", "3.friction")["3.friction_fit"]


@pytest.mark.parametrize(("pair", "expected"), [((0.298, 0.0455), "reproduced"), ((0.33, 0.045), "deviates")])
def test_the_friction_claim_uses_the_track_of_the_same_mill(tmp_path, pair, expected):
    write_table(friction_table(*pair), tmp_path / "calibration/calibrated/friction_fit.tsv")
    other = friction_table(0.45, 0.04, experiment="another", track_mill="emax_smooth")
    write_table(other, tmp_path / "calibration/another/friction_fit.tsv")
    finding = friction_claim(tmp_path)
    assert verdict("0.30/0.045", "recover", finding) == expected
    assert "emax_smooth gives 0.45/0.04" in finding.explanation


def test_a_wide_fit_decides_nothing_on_the_friction_claim(tmp_path):
    table = friction_table(0.3, 0.045, lower=0.0, upper=1.0)
    write_table(table, tmp_path / "calibration/calibrated/friction_fit.tsv")
    assert interval_verdict("0.30/0.045", "recover", friction_claim(tmp_path)) == TOO_WIDE


def test_without_a_simulated_track_the_friction_claim_is_not_run(tmp_path):
    write_table(friction_table(0.3, 0.045, source="measured"), tmp_path / "calibration/mine/friction_fit.tsv")
    assert friction_claim(tmp_path).value is None
