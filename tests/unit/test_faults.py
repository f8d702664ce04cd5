"""Killed jobs, damaged files and full disks: sealed checkpoints, whole files, records of results."""

import json
import os
import subprocess
import sys

import h5py
import numpy as np
import psutil
import pytest

from millprint.cli.commands import main as millprint
from millprint.config.errors import ConfigError, MillprintError
from millprint.run import files
from millprint.run.digest import read_record, record_path, report_damaged
from millprint.run.files import BLOCK, checksum_header, read_checksummed, read_json, whole_file
from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.run.job import job
from tests.conftest import ROOT

PREFACE = f"import sys; sys.path.insert(0, {str(ROOT / 'src')!r})\n"


def python(code: str, *words: str, **options) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-c", PREFACE + code, *words], stderr=subprocess.PIPE, text=True, **options
    )


def test_one_wrong_bit_breaks_a_seal(tmp_path):
    path, payload = tmp_path / "state", os.urandom(3000)
    path.write_bytes(checksum_header(payload) + payload)
    assert read_checksummed(path) == payload
    whole = path.read_bytes()
    for place in (0, 40, BLOCK, BLOCK + 1500, len(whole) - 1):
        damaged = bytearray(whole)
        damaged[place] ^= 1
        path.write_bytes(damaged)
        with pytest.raises(ValueError):
            read_checksummed(path)
    for length in (0, 10, BLOCK, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(ValueError):
            read_checksummed(path)


def test_a_sealed_hdf5_file_opens_as_it_is(tmp_path):
    with whole_hdf5(tmp_path / "a.h5", checksum_header) as file:
        file["x"] = np.arange(1000)
    with h5py.File(tmp_path / "a.h5") as file:
        assert (file["x"][:] == np.arange(1000)).all()
    assert (tmp_path / "a.h5").stat().st_size == BLOCK + len(read_checksummed(tmp_path / "a.h5"))


def test_a_truncated_file_is_named(tmp_path):
    path = tmp_path / "a.h5"
    with whole_hdf5(path) as file:
        file["x"] = np.random.default_rng(0).random(50_000)
    for length in (path.stat().st_size - 1000, 100, 0):
        os.truncate(path, length)
        with pytest.raises(ConfigError, match=r"a\.h5: .* delete it"), open_hdf5(path) as file:
            file["x"][:]
    (tmp_path / "a.json").write_text('{"a": 1, ')
    with pytest.raises(MillprintError, match=r"a\.json: .* delete it"):
        read_json(tmp_path / "a.json")


def write(path, text: str) -> None:
    with whole_file(path) as partial:
        partial.write_text(text)


def test_a_job_records_what_it_wrote_and_is_still_there(tmp_path):
    log, names = tmp_path / "logs/a.log", [str(tmp_path / name) for name in ("one.txt", "two.txt", "gone.txt")]
    with job(str(log), "a job"):
        for name in names:
            write(name, "content of " + name)
        (tmp_path / "gone.txt").unlink()
    assert sorted(read_record(record_path(log))) == names[:2]
    assert report_damaged(tmp_path / "logs") == 0


@pytest.fixture
def recorded(tmp_path):
    """The logs of a job that wrote one.txt and two.txt, and both files."""
    paths = [tmp_path / "one.txt", tmp_path / "two.txt"]
    with job(str(tmp_path / "logs/a.log"), "a job"):
        for path in paths:
            write(path, path.name)
    return tmp_path / "logs", paths


def test_damage_is_reported_in_a_line_a_file_with_what_to_do_and_changes_none(recorded, capsys):
    logs, (one, two) = recorded
    assert millprint(["verify", str(logs.parent)]) == 0
    capsys.readouterr()
    one.write_text("edited")
    os.utime(two, ns=(1, 1))
    for _ in range(2):
        assert report_damaged(logs) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert str(one) in line and f"delete {logs / 'a.json'}" in line and one.read_text() == "edited"
    # The damaged file is reported each time; of the other one only the date is new.
    entries = read_record(logs / "a.json")
    assert entries[str(two)]["date_ns"] == 1 and entries[str(one)]["bytes"] == 7
    one.unlink()
    two.write_text("Two.txt")
    assert report_damaged(logs) == 1 and str(two) in capsys.readouterr().err
    assert millprint(["verify", str(logs.parent)]) == 1


def test_a_file_that_is_as_dated_is_not_read(recorded, monkeypatch):
    logs, (one, _) = recorded
    monkeypatch.setattr("millprint.run.digest.digest", lambda path: pytest.fail(f"{path} was read"))
    assert report_damaged(logs) == 0
    os.utime(one)
    with pytest.raises(pytest.fail.Exception, match=r"one\.txt was read"):
        report_damaged(logs)


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


@pytest.mark.slow
@pytest.mark.parametrize("what", ["hdf5", "table"])
def test_a_full_disk_ends_a_job_in_one_line_and_leaves_nothing_half_written(tmp_path, what):
    """A file may be no larger than 100 kB, which fails as a full disk does: in the middle of a write."""
    code = """
import resource, numpy as np, pandas as pd
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
from millprint.run.files import write_table
from millprint.run.hdf5 import whole_hdf5
from millprint.run.job import job
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


def test_two_attempts_at_a_job_leave_a_whole_file(tmp_path):
    """As after the kill of Snakemake only, whose jobs go on: both write, and none removes the file of the other."""
    code = """
from millprint.run.files import whole_file
from millprint.run.job import job
with job(sys.argv[1] + "/a.log", "a job"):
    with whole_file(sys.argv[1] + "/out") as partial:
        partial.write_text("x" * 1000)
        print("writing", flush=True)
        sys.stdin.readline()
"""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    attempts = [python(code, str(tmp_path), **pipes) for _ in range(2)]
    for attempt in attempts:
        assert attempt.stdout.readline() == "writing\n"
    for attempt in attempts:
        attempt.communicate("\n", timeout=60)
        assert attempt.returncode == 0
        assert (tmp_path / "out").read_text() == "x" * 1000
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json", "a.log", "out"]
    assert report_damaged(tmp_path) == 0


@pytest.mark.slow
def test_a_process_of_a_pool_ends_when_its_parent_is_killed():
    code = """
import os, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from millprint.cases.simulate import end_with_parent
with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=end_with_parent) as pool:
    print(pool.submit(os.getpid).result(), flush=True)
    time.sleep(600)
"""
    parent = python(code, stdout=subprocess.PIPE)
    worker = psutil.Process(int(parent.stdout.readline()))
    parent.kill()
    worker.wait(timeout=60)


def test_records_of_nonsense_are_no_records(tmp_path):
    for content in ("", "[1]", '{"files": 3}', '{"files": {"a": 1}}', json.dumps({"other": 1})):
        (tmp_path / "a.json").write_text(content)
        assert read_record(tmp_path / "a.json") == {}
    assert report_damaged(tmp_path) == 0
    files.written.clear()
