"""A few wrong command lines and damaged files; `python -m tests.fuzz_commands --count 2000` tries more."""

import pytest

from tests.fuzz_commands import fuzz


@pytest.mark.slow
def test_no_command_line_and_no_damaged_file_ends_in_a_traceback(tmp_path):
    folder = tmp_path / "here"
    folder.mkdir()
    statuses, faults = fuzz(30, 11, folder)
    assert not faults, faults[0]
    assert len(statuses) > 1
