"""Files are whole or absent; tables are checked as they are read."""

import pytest

from millprint.run.files import read_table, whole_file
from tests.refusals import refusal, refusals


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with pytest.raises(RuntimeError), whole_file(target) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]
    assert target.read_text() == "old"


@pytest.mark.parametrize(("text", "parts"), refusals("files_a_bad_table_is_refused_in_one_line"))
def test_a_bad_table_is_refused_in_one_line(tmp_path, text, parts):
    path = tmp_path / "t.tsv"
    path.write_text(text)
    message = refusal(read_table, path, ["c"])
    assert all(part in message for part in [str(path), *parts])
