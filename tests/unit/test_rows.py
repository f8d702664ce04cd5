"""The reader of tables that people write: bytes and what they mean, and rows that are added without a changed byte."""

import csv
import io
import random

import pytest

from millprint.config.errors import ConfigError
from millprint.config.rows import append_row, read_cells, read_rows
from millprint.own_machine.readings import append_measured
from millprint.run.tables import Number, Text, read_measured
from millprint.validation.measured import read_measurements
from tests.refusals import refusal, truths

COLUMNS = [Text("case", unique=True), Number("m"), Number("n", may_be_blank=True, optional=True)]


@pytest.mark.parametrize(("content", "m"), truths("what_a_file_means"))
def test_what_a_file_means(tmp_path, content, m):
    path = tmp_path / "t.tsv"
    path.write_bytes(content.encode("latin-1"))
    if isinstance(m, list):
        assert read_measured(path, COLUMNS)["m"].tolist() == m
        return
    line = refusal(read_measured, path, COLUMNS)
    assert m in line and line.startswith(str(path))


def test_only_an_empty_cell_is_nothing_and_a_comment_begins_a_line(tmp_path):
    path = tmp_path / "t.tsv"
    path.write_text(
        '# mine\ncase\tm\tnote\nrun#1\t1\tjar #2, steel\n#run#2\t2\tleft out\nNone\t3\t"5"" jar\n# no comment"\nNA\t4\n'
    )
    found = read_measured(path, COLUMNS)
    assert found["case"].tolist() == ["run#1", "None", "NA"]
    assert found["note"].tolist()[:2] == ["jar #2, steel", '5" jar\n# no comment'] and found["note"].isna()[2]


@pytest.mark.parametrize(("cells", "shown"), [("0.35 0.9", "90 % or 0.9 %"), ("0.35% 0.9%", ""), ("35% 0.9%", "")])
def test_a_share_of_1_is_asked_about_where_per_cent_are_meant(tmp_path, cells, shown):
    path = tmp_path / "t.tsv"
    path.write_text("case\tyield_percent\n" + "".join(f"{k}\t{cell}\n" for k, cell in enumerate(cells.split())))
    column = Number("yield_percent", 0, 100)
    if shown:
        with pytest.raises(ConfigError, match=shown):
            read_measured(path, [Text("case"), column])
    else:
        assert read_measured(path, [Text("case"), column])["yield_percent"][1] == 0.9


def test_a_table_of_conditions_has_the_same_grammar(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes(b"name;balls.fill_ratio;speed_rpm\nrun#1;0,2;1.100\n")
    assert read_rows(path) == [{"name": "run#1", "balls": {"fill_ratio": "0.2"}, "speed_rpm": "1100"}]


WORDS = ["", "None", "NA", "n/a", "nan", "true", "#1", "a#b", '5" jar', '"quoted"', "a,b", "a;b", "a\tb", "two\nlines",
         "two\r\nlines", "1,5", "x = 1", "Mühle", "'", "\\", "- "]  # fmt: skip


def random_table(rng: random.Random) -> tuple[bytes, list[list[str]], str]:
    """A table as a program of tables writes it: its bytes, the cells of its rows, and its encoding."""
    width, mark, end = rng.randint(2, 5), rng.choice("\t;,"), rng.choice(["\n", "\r\n"])
    rows = [[f"c{k}" for k in range(width)]]
    rows += [[f"r{k}", *(rng.choice(WORDS) for _ in range(width - 1))] for k in range(rng.randint(1, 5))]
    lines = []
    for row in rows:
        line = io.StringIO(newline="")
        csv.writer(line, delimiter=mark, lineterminator=end).writerow(row)
        lines += [line.getvalue(), *([f'# a remark, "{mark}{end}'] if rng.random() < 0.3 else [])]
    text = "".join(lines)
    text = text.removesuffix(end) if rng.random() < 0.5 else text
    encoding = rng.choice(["utf-8", "utf-8-sig", "cp1252", "utf-16"])
    return text.encode(encoding), [[cell.strip() for cell in row] for row in rows], encoding


def test_cells_come_back_and_a_new_row_changes_no_byte(tmp_path):
    rng, path = random.Random(5), tmp_path / "t"
    for _ in range(300):
        content, rows, _ = random_table(rng)
        path.write_bytes(content)
        assert [read_cells(path).header, *read_cells(path).rows] == rows
        new = {name: rng.choice(WORDS) for name in rng.sample(rows[0], len(rows[0]))} | {"c0": rng.choice(["#", "n"])}
        append_row(path, new, numbers=())
        assert path.read_bytes().startswith(content)
        assert read_cells(path).rows == [*rows[1:], [new[name].strip() for name in rows[0]]]


@pytest.mark.parametrize("content", [b'id\tsetup\n"a\tb\n', b"id\tid\na\tb\n", b"id\na\n", b"\x00\x01"])
def test_what_cannot_be_read_stays_as_it_is(tmp_path, content):
    path = tmp_path / "mine.tsv"
    path.write_bytes(content)
    with pytest.raises(ConfigError):
        append_measured(path, {"id": "a", "quantity": "power", "value": "1", "unit": "W"})
    assert path.read_bytes() == content


def test_a_row_is_added_as_the_table_is_written(tmp_path):
    path = tmp_path / "mine.csv"
    old = (
        ("unit;value;id;setup;quantity;uncertainty;uncertainty_unit;note\r\nW;12,5;a;unknown;power;0,5;W;jar #2; Stahl")
        .replace("jar #2; Stahl", '"jar #2; Mühle"')
        .encode("cp1252")
    )
    path.write_bytes(old)
    row = {"id": "a", "quantity": "power", "value": "1.25", "unit": "W", "uncertainty": "0.1", "uncertainty_unit": "W"}
    assert append_measured(path, row) == "a_2"
    assert path.read_bytes() == old + b"\r\nW;1,25;a_2;unknown;power;0,1;W;\r\n"
    assert read_measurements(path, [])["value"].tolist() == ["12.5", "1.25"]
    with pytest.raises(ConfigError, match="has no column place"):
        append_measured(path, row | {"place": "x"})
