"""What a killed, damaged or disk-less run leaves: sealed checkpoints, records of results, locks of the dead."""

import json
import os
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from millprint import files
from millprint.errors import ConfigError, MillprintError
from millprint.files import read_json, whole_file
from millprint.hdf5 import open_hdf5, whole_hdf5
from millprint.job import job
from millprint.liveness import claim
from millprint.records import damaged_files, read_record, record_path
from millprint.sealed import BLOCK, seal, unsealed
from tests.conftest import ROOT

PREFACE = f"import sys; sys.path.insert(0, {str(ROOT / 'scripts')!r})\n"


def python(code: str, *words: str, **options) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-c", PREFACE + code, *words], stderr=subprocess.PIPE, text=True, **options
    )


def test_one_wrong_bit_breaks_a_seal(tmp_path):
    path, payload = tmp_path / "state", os.urandom(3000)
    path.write_bytes(seal(payload) + payload)
    assert unsealed(path) == payload
    whole = path.read_bytes()
    for place in (0, 40, BLOCK, BLOCK + 1500, len(whole) - 1):
        damaged = bytearray(whole)
        damaged[place] ^= 1
        path.write_bytes(damaged)
        with pytest.raises(ValueError):
            unsealed(path)
    for length in (0, 10, BLOCK, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(ValueError):
            unsealed(path)


def test_a_sealed_hdf5_file_opens_as_it_is(tmp_path):
    with whole_hdf5(tmp_path / "a.h5", seal) as file:
        file["x"] = np.arange(1000)
    with h5py.File(tmp_path / "a.h5") as file:
        assert (file["x"][:] == np.arange(1000)).all()
    assert (tmp_path / "a.h5").stat().st_size == BLOCK + len(unsealed(tmp_path / "a.h5"))


def test_a_truncated_hdf5_file_is_named(tmp_path):
    path = tmp_path / "a.h5"
    with whole_hdf5(path) as file:
        file["x"] = np.random.default_rng(0).random(50_000)
    for length in (path.stat().st_size - 1000, 100, 0):
        os.truncate(path, length)
        wanted = r"a.h5: truncated or damaged .* delete it"
        with pytest.raises(ConfigError, match=wanted) as caught, open_hdf5(path) as file:
            file["x"][:]
        assert "\n" not in str(caught.value)


def test_truncated_json_is_named(tmp_path):
    (tmp_path / "a.json").write_text('{"a": 1, ')
    with pytest.raises(MillprintError, match=r"a.json: not valid JSON .* delete it"):
        read_json(tmp_path / "a.json")


def write(path, text: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def test_what_jobs_wrote_is_recorded_and_damage_found(tmp_path):
    log, names = tmp_path / "logs/a.log", [str(tmp_path / name) for name in ("one.txt", "two.txt", "gone.txt")]
    with job(str(log), "a job"):
        for name in names:
            write(name, "content of " + name)
        (tmp_path / "gone.txt").unlink()
    assert sorted(read_record(record_path(log))) == names[:2]
    assert list(damaged_files(tmp_path / "logs")) == []
    os.utime(names[1])
    assert list(damaged_files(tmp_path / "logs")) == []
    os.truncate(names[0], 5)
    (found,) = damaged_files(tmp_path / "logs")
    assert str(found) == f"{names[0]}: truncated, 5 bytes of {len('content of ' + names[0])}"
    with open(names[1], "r+") as file:
        file.write("C")
    assert str(list(damaged_files(tmp_path / "logs"))[1]) == f"{names[1]}: changed since it was written"


def test_a_file_made_again_bit_for_bit_gets_its_date_back(tmp_path):
    log, path = str(tmp_path / "logs/a.log"), tmp_path / "one.txt"
    for text, same in (("first", None), ("first", True), ("second", False)):
        before = path.stat().st_mtime_ns if path.exists() else None
        time.sleep(0.02)
        with job(log, "a job"):
            write(path, text)
        assert same is None or (path.stat().st_mtime_ns == before) == same


def test_a_failed_job_leaves_no_record(tmp_path):
    with pytest.raises(ZeroDivisionError), job(str(tmp_path / "a.log"), "a job"):
        write(tmp_path / "one.txt", "x")
        1 / 0  # noqa: B018
    assert not (tmp_path / "a.json").exists()


def test_what_a_killed_process_was_writing_is_removed(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    left, other = tmp_path / f".partial.{dead.pid}.a.txt", tmp_path / f".partial.{os.getppid()}.a.txt"
    left.touch()
    other.touch()
    write(tmp_path / "a.txt", "x")
    assert not left.exists()
    assert other.exists()


@pytest.mark.parametrize("what", ["hdf5", "table"])
def test_a_full_disk_ends_a_job_in_one_line_and_leaves_nothing_half_written(tmp_path, what):
    """A file may be no larger than 100 kB, which fails as a full disk does: in the middle of a write."""
    code = """
import resource, numpy as np, pandas as pd
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
from millprint.files import write_table
from millprint.hdf5 import whole_hdf5
from millprint.job import job
with job(sys.argv[1] + "/logs/a.log", "a job"):
    if sys.argv[2] == "table":
        write_table(pd.DataFrame(np.random.rand(10_000, 4)), sys.argv[1] + "/out")
    with whole_hdf5(sys.argv[1] + "/out") as file:
        file["x"] = np.random.rand(100_000)
"""
    (tmp_path / "out").write_text("before")
    done = python(code, str(tmp_path), what)
    (line,) = done.communicate(timeout=120)[1].splitlines()
    assert done.returncode == 1
    assert line.startswith("error: a job: ")
    assert "make room and run the same command again" in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["logs", "out"]
    assert (tmp_path / "out").read_text() == "before"
    assert [path.name for path in (tmp_path / "logs").iterdir()] == ["a.log"]


HOLD = "import time\nfrom millprint.liveness import claim\nprint(claim(sys.argv[1]), flush=True)\ntime.sleep(60)"


def test_a_lock_is_held_by_the_living_only(tmp_path):
    lock = str(tmp_path / "lock")
    first = python(HOLD, lock, stdout=subprocess.PIPE)
    assert first.stdout.readline() == "True\n"
    second = python(HOLD, lock, stdout=subprocess.PIPE)
    assert second.stdout.readline() == "False\n"
    first.kill()
    first.wait()
    assert not claim(lock)
    second.kill()
    second.wait()
    third = python(HOLD, str(tmp_path / "other"), stdout=subprocess.PIPE)
    assert third.stdout.readline() == "True\n"
    third.kill()
    third.wait()
    assert claim(str(tmp_path / "other"))


def test_the_lock_of_another_machine_is_left_alone(tmp_path):
    (tmp_path / "lock").write_text("another-host")
    assert not claim(tmp_path / "lock")


def test_a_job_ends_with_the_run_that_started_it(tmp_path):
    code = """
import subprocess
from millprint.liveness import announce
announce()
inner = "import sys, time; sys.path.insert(0, sys.argv[1])\\n" \\
    "from millprint.job import job\\nwith job(sys.argv[2], 'a job'):\\n    print(1, flush=True); time.sleep(60)"
subprocess.run([sys.executable, "-c", inner, sys.argv[1], sys.argv[2]])
"""
    log = tmp_path / "a.log"
    run = python(code, str(ROOT / "scripts"), str(log), stdout=subprocess.PIPE)
    assert run.stdout.readline() == "1\n"
    run.kill()
    # Both ends of the pipe are closed when the job has ended too.
    assert "with it this job" in run.communicate(timeout=30)[1]


def test_the_collector_rests_while_a_job_is_imported_and_nowhere_else(tmp_path):
    code = """
import gc
from millprint.liveness import announce
print(gc.isenabled(), flush=True)
announce()
inner = "import gc, sys; sys.path.insert(0, sys.argv[1])\\n" \\
    "from millprint.job import job\\nprint(gc.isenabled(), flush=True)\\n" \\
    "with job(sys.argv[2], 'a job'):\\n    print(gc.isenabled(), gc.get_freeze_count() > 10000, flush=True)"
import subprocess
subprocess.run([sys.executable, "-c", inner, sys.argv[1], sys.argv[2]])
"""
    run = python(code, str(ROOT / "scripts"), str(tmp_path / "a.log"), stdout=subprocess.PIPE)
    assert run.communicate(timeout=60)[0].split() == ["True", "False", "True", "True"]


def test_a_second_attempt_waits_for_the_first(tmp_path):
    code = """
from millprint.job import job
with job(sys.argv[1], "a job"):
    print("began", flush=True)
    sys.stdin.readline()
    open(sys.argv[1] + ".order", "a").write(sys.argv[2])
"""
    log, pipes = str(tmp_path / "a.log"), {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    first = python(code, log, "1", **pipes)
    assert first.stdout.readline() == "began\n"
    second = python(code, log, "2", **pipes)
    assert "waiting: another process still writes" in second.stderr.readline()
    for process in (first, second):
        process.communicate("\n", timeout=60)
    assert (tmp_path / "a.log.order").read_text() == "12"


def test_records_of_nonsense_are_no_records(tmp_path):
    for content in ("", "[1]", '{"files": 3}', '{"files": {"a": 1}}', json.dumps({"other": 1})):
        (tmp_path / "a.json").write_text(content)
        assert read_record(tmp_path / "a.json") == {}
    assert list(damaged_files(tmp_path)) == []
    files.written.clear()
