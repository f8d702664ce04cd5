"""The command that repairs what earlier runs left: it removes locks, and renames, keeps and restores files."""

import os
from pathlib import Path

import pytest

from millprint.files import whole_file
from millprint.job import job
from millprint.liveness import DEAD, LIVING, UNKNOWN, Run
from millprint.records import damaged_files, keep
from millprint.verify import repair
from millprint.verify.repair import KEEP, MAKE_AGAIN, STOP, mend_files
from millprint.verify.runner import Snakemake, mend_locks

COMMAND = ["python", "scripts/verify_results.py", "results", "--", "--cores", "2"]


class Pretended(Snakemake):
    """In place of Snakemake: calls a function, and records the arguments of each run."""

    def __init__(self, make=lambda: True):
        super().__init__(["--cores", "2"])
        self.make, self.calls = make, []

    def run(self, *more, quiet=False):
        self.calls.append(more)
        return self.make()


def runs(folder: Path, **states: str) -> list[Run]:
    """A file in `folder` and a run for each name and state."""
    found = []
    for number, (host, state) in enumerate(states.items()):
        path = folder / f"{host}-{number}"
        path.touch()
        found.append(Run(path, host, number, state))
    return found


def test_locks_of_dead_runs_are_removed_by_snakemake(tmp_path, capsys):
    snakemake = Pretended()
    assert mend_locks(runs(tmp_path, a=DEAD, b=DEAD), snakemake)
    assert snakemake.calls == [("--unlock",)]
    assert list(tmp_path.iterdir()) == []
    assert "its locks are removed: snakemake --cores 2 --unlock" in capsys.readouterr().out


def test_locks_of_a_run_that_was_killed_as_it_ended_are_removed(tmp_path, monkeypatch, capsys):
    """It had removed its own record already; without locks nothing is called."""
    monkeypatch.chdir(tmp_path)
    snakemake = Pretended()
    assert mend_locks([], snakemake) and snakemake.calls == []
    (tmp_path / ".snakemake/locks").mkdir(parents=True)
    (tmp_path / ".snakemake/locks/0.output.lock").touch()
    assert mend_locks([], snakemake) and snakemake.calls == [("--unlock",)]
    assert "found: a run that was killed as it ended" in capsys.readouterr().out


@pytest.mark.parametrize("other", [LIVING, UNKNOWN])
def test_no_lock_is_removed_if_a_run_may_be_alive(tmp_path, capsys, other):
    snakemake = Pretended()
    assert mend_locks(runs(tmp_path, a=DEAD, b=other), snakemake)
    assert snakemake.calls == []
    assert len(list(tmp_path.iterdir())) == 2
    printed = capsys.readouterr().out
    assert "its locks stay" in printed
    assert "snakemake --unlock" in printed
    assert ("a run that is alive: process 1" in printed) == (other == LIVING)


def test_the_record_of_a_dead_run_stays_if_snakemake_cannot_unlock(tmp_path, capsys):
    assert not mend_locks(runs(tmp_path, a=DEAD), Pretended(lambda: False))
    assert len(list(tmp_path.iterdir())) == 1
    assert "error: its locks could not be removed" in capsys.readouterr().out


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder whose job wrote a.txt, b.txt and clock.txt (the time it took); a.txt is then damaged."""
    monkeypatch.chdir(tmp_path)
    run_job(1)
    Path("a.txt").write_text("damaged")
    with open(os.devnull) as empty, monkeypatch.context() as patch:
        patch.setattr("sys.stdin", empty)
        yield


def run_job(clock: int, a: str = "content of a") -> bool:
    """Writes the files of the job, which differ between runs in the clock alone, or in `a`."""
    with job("logs/one.log", "one"):
        for name, text in {"a.txt": a, "b.txt": "content of b", "clock.txt": f"{clock} s"}.items():
            with whole_file(name) as partial:
                partial.write_text(text)
    return True


def fail() -> bool:
    """A failing job: Snakemake removes its files before and after it, and the job has removed its record."""
    for name in ("a.txt", "b.txt", "clock.txt", "logs/one.json"):
        Path(name).unlink(missing_ok=True)
    return False


def content() -> dict[str, str]:
    return {path.name: path.read_text() for path in sorted(Path().glob("*.txt*"))}


def test_only_the_damaged_file_is_made_again(place, capsys):
    date, snakemake = Path("clock.txt").stat().st_mtime_ns, Pretended(lambda: run_job(2))
    assert mend_files(damaged_files("logs"), MAKE_AGAIN, snakemake, COMMAND)
    assert snakemake.calls == [("--", "a.txt")]
    assert content() == {
        "a.txt": "content of a",
        "a.txt.damaged": "damaged",
        "b.txt": "content of b",
        "clock.txt": "1 s",
    }
    # With its old date, so that Snakemake makes nothing that depends on it again.
    assert Path("clock.txt").stat().st_mtime_ns == date
    assert damaged_files("logs") == []
    assert "made again: a.txt, bit for bit" in capsys.readouterr().out


def test_if_a_file_gets_another_content_the_other_outputs_are_replaced_too(place, capsys):
    keep_edited("b.txt")
    assert mend_files(damaged_files("logs"), MAKE_AGAIN, Pretended(lambda: run_job(2, "better")), COMMAND)
    # The file that the user has kept stays.
    assert content() == {"a.txt": "better", "a.txt.damaged": "damaged", "b.txt": "edited", "clock.txt": "2 s"}
    assert damaged_files("logs") == []
    assert "made again: a.txt, with another content" in capsys.readouterr().out


def keep_edited(name: str) -> None:
    Path(name).write_text("edited")
    (found,) = [damage for damage in damaged_files("logs") if damage.path == name]
    keep(found)


def test_a_job_that_fails_leaves_everything_as_it_was(place, capsys):
    before, found = content(), damaged_files("logs")
    assert not mend_files(found, MAKE_AGAIN, Pretended(fail), COMMAND)
    assert content() == before
    assert damaged_files("logs") == found
    assert "not made again, see above: a.txt is unchanged" in capsys.readouterr().out


def test_nothing_is_moved_without_a_terminal(place, capsys):
    before, snakemake = content(), Pretended()
    assert not mend_files(damaged_files("logs"), None, snakemake, COMMAND)
    assert content() == before
    assert snakemake.calls == []
    printed = capsys.readouterr().out
    for option in ("--repair", "--keep"):
        assert f"python scripts/verify_results.py results {option} -- --cores 2  # " in printed


def test_kept_files_are_results(place):
    snakemake = Pretended()
    assert mend_files(damaged_files("logs"), KEEP, snakemake, COMMAND)
    assert snakemake.calls == []
    assert content()["a.txt"] == "damaged"
    assert damaged_files("logs") == []


@pytest.mark.parametrize(("answers", "choice"), [("x\nm\n", MAKE_AGAIN), ("K\n", KEEP), ("s\n", STOP), ("", STOP)])
def test_on_a_terminal_the_user_is_asked(place, monkeypatch, tmp_path, answers, choice):
    (tmp_path / "answers").write_text(answers)
    with open(tmp_path / "answers") as typed, monkeypatch.context() as patch:
        patch.setattr("sys.stdin", typed)
        assert repair.ask(damaged_files("logs")) == choice


def test_snakemake_works_in_the_folder_that_its_arguments_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert Snakemake([]).folder == tmp_path
    assert Snakemake(["--cores", "2", "--directory", "elsewhere"]).folder == tmp_path / "elsewhere"
    assert Snakemake(["--configfile", "a.yaml", "-d", "/abs"]).folder == Path("/abs")
