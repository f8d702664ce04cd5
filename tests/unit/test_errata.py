"""Errata follow from tables: each is found if, and only if, the tables contradict the printed value."""

import pandas as pd
import pytest

from millprint.run.files import write_json, write_table
from millprint.thesis.claims.errata import collect_errata
from millprint.thesis.claims.evidence import Contradiction, Finding

CLAIM = {
    "id": "2.anova.AB.df",
    "locus": "Table 2.5",
    "quantity": "degrees of freedom",
    "published": "6",
    "unit": "-",
    "reproduced": "4",
    "reason": "erratum",
    "explanation": "4 by the rank of the design",
}


def claims(*reasons: str) -> pd.DataFrame:
    return pd.DataFrame([CLAIM | {"reason": reason} for reason in reasons], columns=list(CLAIM))


@pytest.fixture
def data(tmp_path):
    """The screening's energies by speed, to be changed."""
    folder = tmp_path / "data"
    folder.mkdir()

    def write(normal=(221, 393, 613), tangential=(500, 889, 1389), prior_h=15.0):
        rows = {"speed_rpm": [600, 800, 1000], "normal_energy_uJ": normal, "tangential_energy_uJ": tangential}
        write_table(pd.DataFrame(rows), folder / "screening.tsv")
        # As the thesis reports the study that it compares with in another chapter.
        write_table(pd.DataFrame({"reference": [16], "time_h": [prior_h]}), folder / "literature.tsv")
        return folder

    write()
    return write


def found(results, folder, table=None) -> pd.DataFrame:
    findings = {CLAIM["id"]: Finding(4, contradiction=Contradiction("Table 2.3", "27 runs leave no residual"))}
    return collect_errata(results, folder, claims() if table is None else table, findings)


def test_an_energy_off_the_square_of_the_speed_is_found_and_a_digit_is_not(tmp_path, data):
    table = found(tmp_path, data(normal=(221, 382, 613), tangential=(500, 888, 1391)))
    assert table["printed"].tolist() == ["normal energy of a collision at 800 rpm: 382 microjoules"]
    assert (
        "-2.6 % off" in table["calculation"].iloc[0]
        and "221 at 600 and 613 at 1000 rpm" in table["calculation"].iloc[0]
    )


def test_a_run_off_its_generator_is_found_with_what_it_costs(tmp_path, data):
    rows = [
        ("generator D = A + B + C", "case 4", "D = 0", "D = 1", "yes", "run as 0100"),
        ("runs at each level", "factor D", "10/8/9", "9/9/9", "yes", ""),
        ("shared degrees of freedom", "A and D", "0.0167", "0", "yes", ""),
        ("shared degrees of freedom", "A and B", "0", "0", "no", ""),
    ]
    write_table(
        pd.DataFrame(rows, columns=["check", "subject", "found", "wanted", "departs", "note"]),
        tmp_path / "doe/audit.tsv",
    )
    table = found(tmp_path, data())
    assert table["computed"].tolist() == ["D = 1"]
    told = table["calculation"].iloc[0]
    assert "10/8/9" in told and "A and D share 0.0167" in told and "A and B" not in told
    contested = {"term": ["A:B", "A:C"], "rival": ["C:D", "B:D"]}
    contested |= {"degrees_of_freedom_if_rival_first": [3, 4], "degrees_of_freedom_if_designed": [2, 4]}
    write_table(pd.DataFrame(contested), tmp_path / "doe/contested.tsv")
    told = found(tmp_path, data())["calculation"].iloc[0]
    assert "A:B after C:D has 3 degrees of freedom, and would have 2 without" in told and "A:C" not in told


def test_centres_are_compared_with_the_radius(tmp_path, data):
    for seed, overlap in enumerate((0.01, 0.02)):
        write_json(
            {"ball_diameter_m": 0.01, "max_overlap_fraction": overlap},
            tmp_path / f"dem/emax/calibrated/d10_f0.10_n300_s{seed}/summary.json",
        )
    table = found(tmp_path, data())
    # Two balls of radius 5 mm with an overlap of 0.1 mm.
    assert table["computed"].tolist() == ["centres never come nearer than 0.00990 m"]
    assert "2 run(s)" in table["calculation"].iloc[0] and "6.6 times r_c" in table["calculation"].iloc[0]


def test_the_share_of_contacts_on_each_side_of_the_threshold_is_counted(tmp_path, data):
    rows = {"low_m": [-0.00500, -0.00495, -0.00489], "high_m": [-0.00499, -0.00494, -0.00488], "contacts": [60, 30, 10]}
    write_table(pd.DataFrame(rows), tmp_path / "surrogate/wall_contacts.tsv")
    assert "90.00 % of the 100 wall contacts" in found(tmp_path, data())["calculation"].iloc[0]


def test_a_table_that_says_of_one_contact_set_what_the_text_says_of_the_other_is_found(tmp_path, data):
    printed = {"3.size.steel.t": "13", "3.size.calibrated.n": "20"}
    for speed in (600, 800, 1000, 1200):
        for size, normal, tangential in ((10, "1.01", "1.13"), (5, "1.00", "1.00")):
            printed |= {f"3.cycle.{size}mm.{speed}.n": normal, f"3.cycle.{size}mm.{speed}.t": tangential}
    table = pd.DataFrame({"id": list(printed), "published": list(printed.values()), "reason": ""})
    (row,) = found(tmp_path, data(), table).to_dict("records")
    assert row["locus"] == "Table 3.5" and row["computed"] == "normal +1 %, tangential +13 %"
    agreeing = table.assign(published=table["published"].replace({"1.01": "1.20", "1.13": "1.00"}))
    assert found(tmp_path, data(), agreeing).empty


def test_a_time_of_the_prior_art_that_differs_between_two_tables_is_found(tmp_path, data):
    table = pd.DataFrame({"id": ["4.prior.time"], "published": ["-38"], "reason": [""]})
    (row,) = found(tmp_path, data(), table).to_dict("records")
    # 12.5 h after 20 h, and after 15 h.
    assert row["locus"] == "Table 4.3" and "15 h" in row["against"] and row["computed"] == "-17 %"
    assert found(tmp_path, data(prior_h=20.0), table).empty
