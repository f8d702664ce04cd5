"""Fuzzing with 50 damaged files; `make fuzz COUNT=5000 SEED=7` uses more (tests/fuzz.py)."""

import os
import re
import subprocess
import sys

from tests.conftest import ROOT

COUNT = int(os.environ.get("MILLPRINT_FUZZ", "50"))


def test_damaged_input_is_refused_in_one_line_or_makes_a_valid_plan(tmp_path):
    """The fuzzing runs in a process of its own, because it limits its memory."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.fuzz", "--count", str(COUNT), "--seed", "3", "--keep", str(tmp_path / "project")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-3000:]
    # The damage is real: most files are refused, and some changes are harmless.
    counts = {kind: int(count) for kind, count in re.findall(r"'(\w+)': (\d+)", done.stdout)}
    assert counts["refused"] > COUNT / 3
    assert counts["valid"] > COUNT / 50
