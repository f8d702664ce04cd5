"""The literature: reported and missing parameters, and contradictions."""

import pandas as pd
import pytest

from millprint.thesis.doe.literature import (
    literature_checks,
    missingness_table,
    read_literature,
    read_reported_yields,
)
from tests.conftest import ROOT

LITERATURE = ROOT / "config/data/literature.tsv"
YIELDS = ROOT / "config/data/literature_yields.tsv"


@pytest.fixture(scope="module")
def studies() -> pd.DataFrame:
    return read_literature(LITERATURE)


@pytest.fixture(scope="module")
def checks(studies) -> pd.DataFrame:
    return literature_checks(studies, read_reported_yields(YIELDS)).set_index(["reference", "check"])


def test_the_table_of_missingness_counts_the_dashes_of_both_directions(studies):
    table = missingness_table(studies).set_index("parameter")
    columns = [name for name in table if name.startswith("reference_")]
    assert len(columns) == 7
    # What Table 2.2 shows as a dash, by study.
    assert (table[columns] == "no").sum().tolist() == [0, 9, 1, 9, 2, 2, 5]
    assert table.loc["ball_diameter_mm", "unreported"] == 5
    assert table.loc["speed_rpm", ["reference_12", "reference_14"]].tolist() == ["no", "no"]
    assert table["unreported"].is_monotonic_decreasing


def test_masses_and_balls_that_agree_are_found_to_agree(checks):
    assert checks.loc[("11", "total mass [g]"), "agrees"] == "yes"
    assert checks.loc[("11", "ball-to-powder ratio with steel balls [-]"), "follows"] == pytest.approx(39, abs=0.1)
    assert checks.loc[("15", "molar ratio [-]"), "follows"] == pytest.approx(5.55, abs=0.01)
    assert checks.loc[("17", "molar ratio [-]"), "agrees"] == "yes"


def test_reference_16_was_charged_with_the_dihydrate(checks):
    ratio = checks.loc[("16", "molar ratio [-]")]
    # 0.44 g of the tetrahydrate would be a ratio of 6.67; 5.0 and the 90 % are those of the dihydrate.
    assert (ratio["agrees"], ratio["follows"]) == ("no", pytest.approx(6.67, abs=0.01))
    assert "NaBO2.2H2O" in ratio["note"]
    assert "NaBO2.2H2O" in checks.loc[("16", "yield in Tables 2.2 and 2.1 [%]"), "note"]


def test_what_cannot_follow_from_a_study_s_other_numbers_is_found(checks):
    assert checks.loc[("11", "molar ratio [-]"), "follows"] == pytest.approx(0.985, abs=0.001)
    balls = checks.loc[("13", "ball-to-powder ratio with steel balls [-]")]
    assert balls["follows"] == pytest.approx(5.1, abs=0.05)
    assert "15.2 g/cm3" in balls["note"]
    wrong = checks[checks["agrees"] == "no"].index.tolist()
    assert [reference for reference, _ in wrong] == ["11", "13", "13", "16", "16"]
