"""Progress in a file: a line of its own now and then, that says what, how much of how much, and how long it takes."""

import pytest

from millprint.run.job import Lines, progress
from millprint.run.numbers import duration


class Clock:
    """The time that a bar sees [s]."""

    now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch) -> Clock:
    """A clock for bars that are made from now on, which no other thread asks."""
    watch = Clock()
    monkeypatch.setattr("tqdm.std.time", watch)
    monkeypatch.setattr(Lines, "monitor_interval", 0)
    return watch


def lines_of(capsys) -> list[str]:
    text = capsys.readouterr().err
    assert "\r" not in text
    assert "\x1b" not in text
    assert not text or text.endswith("\n")
    return text.splitlines()


def test_a_long_job_writes_a_line_every_half_minute_with_the_time_to_go(clock, capsys):
    with progress(120, "fitting", "fold") as bar:
        for _ in range(120):
            clock.now += 1.0
            bar.update()
    lines = lines_of(capsys)
    assert lines[0] == "fitting: 10 of 120 folds, 10 s so far; about 1 min 50 s to go"
    # At 10, 40, 70 and 100 s, and at the end.
    assert len(lines) == 5
    assert lines[-1] == "fitting: 120 of 120 folds, 2 min 0 s so far; done"


def test_a_simulation_counts_seconds_and_a_search_of_unknown_length_its_steps(clock, capsys):
    with progress(1_000_000, "emax", "s simulated", unit_scale=2e-6) as bar:
        clock.now += 12.0
        bar.update(250_000)
    with progress(None, "searching", "simulation") as bar:
        clock.now += 12.0
        bar.update(3)
    lines = lines_of(capsys)
    assert lines[0] == "emax: 0.50 of 2.00 s simulated, 12 s so far; about 36 s to go"
    assert lines[2] == "searching: 3 simulations, 12 s so far"


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.4, "0 s"), (59.6, "1 min 0 s"), (200, "3 min 20 s"), (700, "11 min"), (7500, "2 h 5 min")]
)
def test_times_are_in_words(seconds, words):
    assert duration(seconds) == words
