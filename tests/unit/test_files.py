"""Files are whole or absent; tables are checked as they are read."""

import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.run.files import read_table, whole_file, write_table
from tests.refusals import refusals


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with pytest.raises(RuntimeError), whole_file(target) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert [path.name for path in tmp_path.iterdir()] == ["out.txt"]
    assert target.read_text() == "old"


def test_a_table_survives_a_round_trip(tmp_path):
    frame = pd.DataFrame({"case": ["a", "b"], "power_W": [1.25, 2e-7]})
    write_table(frame, tmp_path / "t.tsv")
    pd.testing.assert_frame_equal(read_table(tmp_path / "t.tsv", ["power_W"], ["case"]), frame)


@pytest.mark.parametrize(("text", "parts"), refusals("files_a_bad_table_is_refused_in_one_line"))
def test_a_bad_table_is_refused_in_one_line(tmp_path, text, parts):
    path = tmp_path / "t.tsv"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_table(path, ["c"])
    message = str(caught.value)
    assert "\n" not in message
    assert all(part in message for part in [str(path), *parts])
