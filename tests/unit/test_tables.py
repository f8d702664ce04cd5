"""The checker of measured tables: one line for the first fault, with the place, the value and what would be right."""

import pytest

from millprint.config.errors import ConfigError
from millprint.run.files import read_table
from millprint.run.tables import Number, Text, read_measured, read_printed, refuse_rows
from tests.refusals import refusal, refusals

COLUMNS = [
    Text("case", unique=True),
    Text("role", choices=("train", "test")),
    Number("mass_g", 0, above=True),
    Number("share", 0, 1, above=True),
    Number("yield_percent", 0, 100),
    Number("wait_h", 0, optional=True),
    Number("speed_rpm", 0, may_be_blank=True),
]
HEADER = "case\trole\tmass_g\tshare\tyield_percent\tspeed_rpm"
ROWS = ("a\ttrain\t1\t0.5\t100\t600", " b \ttest\t2.5\t1\t0\t")


def written(tmp_path, *lines: str) -> str:
    (tmp_path / "t.tsv").write_text("\n".join(lines) + "\n")
    return str(tmp_path / "t.tsv")


def test_a_table_on_its_bounds_is_read_with_its_blanks_and_without_its_optional_column(tmp_path):
    table = read_measured(written(tmp_path, HEADER, *ROWS), COLUMNS)
    assert table["case"].tolist() == ["a", "b"]
    assert table["speed_rpm"].isna().tolist() == [False, True]
    assert table["yield_percent"].tolist() == [100, 0]
    assert "wait_h" not in table


@pytest.mark.parametrize(("row", "fault"), refusals("the_first_fault_is_told_in_one_line"))
def test_the_first_fault_is_told_in_one_line(tmp_path, row, fault):
    path = written(tmp_path, HEADER, ROWS[0], row)
    with pytest.raises(ConfigError) as caught:
        read_measured(path, COLUMNS)
    assert str(caught.value) == f"{path}: {fault}"


def test_an_optional_column_is_checked_if_it_is_there(tmp_path):
    path = written(tmp_path, f"{HEADER}\twait_h", f"{ROWS[0]}\t-2")
    with pytest.raises(ConfigError, match="column wait_h, case a = -2: must be at least 0"):
        read_measured(path, COLUMNS)


@pytest.mark.parametrize(("rows", "fault"), [((), "no rows"), (ROWS[:1], "1 rows")])
def test_too_few_rows_are_refused(tmp_path, rows, fault):
    with pytest.raises(ConfigError, match=f"{fault}; the table needs at least 2"):
        read_measured(written(tmp_path, HEADER, *rows), COLUMNS, fewest_rows=2)


def test_a_row_without_a_name_is_told_by_its_number_and_the_reason_may_come_from_the_row(tmp_path):
    path = written(tmp_path, "low\thigh", "1\t2", "4\t3")
    table = read_measured(path, [Number("low"), Number("high")])
    refuse_rows(table, path, "low", [False, False], "never")
    with pytest.raises(ConfigError, match=r"column low, row 2 = 4: must be at most 3$"):
        refuse_rows(table, path, "low", table["low"] > table["high"], lambda row: f"must be at most {row['high']:g}")


def test_an_id_that_two_claims_share_is_refused_in_one_line(tmp_path):
    path = tmp_path / "claims.tsv"
    path.write_text("id\tvalue\n2.a\t1\n2.b\t2\n2.a\t3\n")
    with pytest.raises(ConfigError, match=r"claims.tsv: column id = 2.a appears twice"):
        read_printed(path)


@pytest.mark.parametrize(("text", "parts"), refusals("files_a_bad_table_is_refused_in_one_line"))
def test_a_table_that_cannot_be_read_is_refused_in_one_line(tmp_path, text, parts):
    path = written(tmp_path, text.removesuffix("\n"))
    line = refusal(read_table, path, ["c"])
    assert all(part in line for part in [path, *parts]), line
