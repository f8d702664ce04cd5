"""Killed and damaged runs, and full disks: sealed checkpoints, records of results, files of runs."""

import json
import os
import socket
import subprocess
import sys

import h5py
import numpy as np
import pytest

from millprint import files
from millprint.errors import ConfigError, MillprintError
from millprint.files import read_json, whole_file
from millprint.hdf5 import open_hdf5, whole_hdf5
from millprint.job import job
from millprint.liveness import DEAD, LIVING, RUN_VARIABLE, UNKNOWN, outlive_run, runs_of
from millprint.records import damaged_files, keep, read_record, record_path, report_damaged, set_aside
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
        message = r"a.h5: truncated or damaged .* delete it"
        with pytest.raises(ConfigError, match=message) as caught, open_hdf5(path) as file:
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
    assert damaged_files(tmp_path / "logs") == []
    os.utime(names[1])
    assert damaged_files(tmp_path / "logs") == []
    os.truncate(names[0], 5)
    (found,) = damaged_files(tmp_path / "logs")
    assert str(found).startswith(f"{names[0]}: truncated, 5 bytes of {len('content of ' + names[0])} (dated 20")
    with open(names[1], "r+") as file:
        file.write("C")
    assert str(damaged_files(tmp_path / "logs")[1]).startswith(f"{names[1]}: changed since it was written (dated 20")


@pytest.fixture
def recorded(tmp_path):
    """The logs of a job that wrote one.txt and two.txt, and both files."""
    paths = [tmp_path / "one.txt", tmp_path / "two.txt"]
    with job(str(tmp_path / "logs/a.log"), "a job"):
        for path in paths:
            write(path, path.name)
    return tmp_path / "logs", paths


def test_a_run_reports_damage_in_a_line_a_file_and_changes_none(recorded, capsys):
    logs, (one, two) = recorded
    one.write_text("edited")
    os.utime(two, ns=(1, 1))
    report_damaged(logs)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"found: {one}: truncated, 6 bytes of 7 (dated ")
    assert line.endswith("; make verify tells more")
    assert one.read_text() == "edited"
    # The damaged file is reported each time; of the other one only the date is new.
    entries = read_record(logs / "a.json")
    assert entries[str(two)]["date_ns"] == 1
    assert entries[str(one)]["bytes"] == 7
    report_damaged(logs)
    assert capsys.readouterr().err.splitlines() == [line]


def test_a_file_that_is_as_dated_is_not_read(recorded, monkeypatch):
    logs, (one, _) = recorded
    monkeypatch.setattr("millprint.records.digest", lambda path: pytest.fail(f"{path} was read"))
    assert damaged_files(logs) == []
    os.utime(one)
    with pytest.raises(pytest.fail.Exception, match=r"one\.txt was read"):
        damaged_files(logs)


def test_a_file_that_is_kept_is_a_result(recorded):
    logs, (one, _) = recorded
    one.write_text("edited on purpose")
    (found,) = damaged_files(logs)
    keep(found)
    assert damaged_files(logs) == []
    one.write_text("edited by accident")
    assert [damage.path for damage in damaged_files(logs)] == [str(one)]


def test_what_is_set_aside_replaces_nothing(tmp_path):
    names = []
    for text in ("first", "second", "third"):
        (tmp_path / "a.txt").write_text(text)
        names.append(set_aside(str(tmp_path / "a.txt")))
    assert [path.name for path in names] == ["a.txt.damaged", "a.txt.damaged.2", "a.txt.damaged.3"]
    assert [path.read_text() for path in names] == ["first", "second", "third"]


def test_each_fault_of_a_job_is_a_line(tmp_path, capsys):
    with pytest.raises(SystemExit), job(str(tmp_path / "a.log"), "a job"):
        raise ConfigError("a.yaml: x = 1: too small\na.yaml: y = 2: too large")
    assert capsys.readouterr().err.splitlines() == [
        "error: a job: a.yaml: x = 1: too small",
        "error: a job: a.yaml: y = 2: too large",
    ]


def test_what_the_snakefile_imports_of_this_needs_no_scientific_libraries():
    code = """
import millprint.liveness, millprint.records
heavy = {"numpy", "pandas", "scipy", "numba", "h5py", "matplotlib", "torch"}
print(sorted(heavy & set(sys.modules)))
"""
    assert python(code, stdout=subprocess.PIPE).communicate(timeout=60)[0] == "[]\n"


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


HOLD = """
import time
from millprint.liveness import hold
hold(sys.argv[1])
hold(sys.argv[1])
print("held", flush=True)
sys.stdin.readline()
"""


def holding(folder) -> subprocess.Popen:
    """A process that holds the file of a run until a line is written to it."""
    process = python(HOLD, str(folder), stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert process.stdout.readline() == "held\n"
    return process


def states(folder) -> dict[str, str]:
    return {run.path.name: run.state for run in runs_of(folder)}


def test_a_run_is_alive_until_its_process_ends_and_leaves_no_file_at_a_normal_end(tmp_path):
    host = socket.gethostname()
    assert states(tmp_path / "none") == {}
    first, second = holding(tmp_path), holding(tmp_path)
    names = [f"{host}-{process.pid}" for process in (first, second)]
    assert states(tmp_path) == dict.fromkeys(names, LIVING)
    first.kill()
    first.wait()
    assert states(tmp_path) == {names[0]: DEAD, names[1]: LIVING}
    second.communicate("\n", timeout=60)
    assert states(tmp_path) == {names[0]: DEAD}


def test_the_state_of_a_run_on_another_machine_is_unknown_and_its_file_stays(tmp_path):
    other = tmp_path / "other-host-7"
    other.write_text("theirs")
    process = holding(tmp_path)
    (found,) = [run for run in runs_of(tmp_path) if run.path == other]
    assert (found.host, found.pid, found.state, found.is_here) == ("other-host", 7, UNKNOWN, False)
    process.communicate("\n", timeout=60)
    assert other.read_text() == "theirs"
    assert states(tmp_path) == {"other-host-7": UNKNOWN}


def test_where_a_file_system_knows_no_locks_nothing_is_known(tmp_path, monkeypatch):
    def no_locks(file, how):
        raise OSError(95, "Operation not supported")

    (tmp_path / f"{socket.gethostname()}-{os.getpid()}").touch()
    monkeypatch.setattr("fcntl.flock", no_locks)
    assert list(states(tmp_path).values()) == [UNKNOWN]


def test_a_living_process_is_alive_even_if_every_lock_is_granted(tmp_path):
    """The file of this very process, which holds no lock on it; then one older than this process, so another's."""
    path = tmp_path / f"{socket.gethostname()}-{os.getpid()}"
    path.touch()
    assert list(states(tmp_path).values()) == [LIVING]
    os.utime(path, (0, 0))
    assert list(states(tmp_path).values()) == [DEAD]


def test_a_job_of_a_queue_belongs_to_no_run(monkeypatch):
    monkeypatch.setenv(RUN_VARIABLE, f"{socket.gethostname()} 1 0.0")
    outlive_run()
    outlive_run()
    assert RUN_VARIABLE not in os.environ


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
