"""A run that is stopped and continued equals one that never stopped, bit for bit."""

import h5py
import numpy as np
import pytest

from millprint.config.contact_set import CohesionConfig, RestitutionTable
from millprint.config.sweep import Case, DemConfig
from millprint.dem import run as runs
from millprint.dem import simulation as simulations
from millprint.dem.layout import SAMPLE
from millprint.dem.ledger import OpenBalanceError
from millprint.dem.recording import write_restart
from millprint.dem.run import RESTART, run_case
from millprint.dem.simulation import Simulation

CASE = Case(
    mill="emax", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.10, speed_hz=20.0, seed=0,
    settle_s=0.01, discard_s=0.02, window_s=0.05, snapshot_interval_s=1e-3,
)  # fmt: skip
# Without snapshots the step changes where the window begins.
TWO_STEPS = CASE.model_copy(update={"snapshot_interval_s": None})
DEM = DemConfig(time_step_s=2e-6, settle_s=0.01, window_s=0.05, restart_interval_s=0, closure_max=0.05)


CHUNK_S = 4e-4


class Killed(Exception):
    """Stands for the kill of a process between two chunks."""


def make_small_chunks(patched) -> None:
    """Chunks of some hundred steps, so that there are many moments at which to stop; most write no restart file."""
    patched.setattr(simulations, "CHUNK_S", CHUNK_S)
    patched.setattr(simulations, "write_restart", lambda *arguments: None)


@pytest.fixture
def small_chunks(monkeypatch):
    make_small_chunks(monkeypatch)


def kill_after(monkeypatch, chunks: int, fraction: float | None = None) -> None:
    """Make the run die right after the n-th of its moments to write a restart file, which it writes.

    fraction: moments count with this step only, a fraction of the Rayleigh time.
    """
    count = [0]

    def write_and_die(path, simulation, recording):
        count[0] += fraction in (None, simulation.case.rayleigh_fraction)
        if count[0] == chunks:
            write_restart(path, simulation, recording)
            raise Killed

    monkeypatch.setattr(simulations, "write_restart", write_and_die)


def content(path) -> dict[str, np.ndarray]:
    """Every dataset of a run.h5."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


def run(folder, mills, contacts, case=CASE) -> dict:
    folder.mkdir(exist_ok=True)
    return run_case(case, mills[case.mill], contacts["calibrated"], DEM, folder / "run.h5", folder / "summary.json")


def whole_run(mills, contacts, folder, case):
    """The folder and the summary of a run that never stopped."""
    with pytest.MonkeyPatch.context() as patched:
        make_small_chunks(patched)
        return folder, run(folder, mills, contacts, case)


@pytest.fixture(scope="module")
def unbroken(mills, contacts, tmp_path_factory):
    return whole_run(mills, contacts, tmp_path_factory.mktemp("whole"), CASE)


@pytest.fixture(scope="module")
def unbroken_of_two_steps(mills, contacts, tmp_path_factory):
    return whole_run(mills, contacts, tmp_path_factory.mktemp("two"), TWO_STEPS)


# While settling, between the start and the window, at the window's beginning, and within it.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "chunks"),
    [*((CASE, chunks) for chunks in (3, 15, 26, 60)), *((TWO_STEPS, chunks) for chunks in (2, 5, 8, 9, 30))],
)
def test_a_stopped_run_goes_on_bit_for_bit(
    unbroken, unbroken_of_two_steps, mills, contacts, tmp_path, monkeypatch, small_chunks, case, chunks
):
    folder, whole = unbroken if case is CASE else unbroken_of_two_steps
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, chunks)
        run(tmp_path / "parts", mills, contacts, case)
    assert (tmp_path / "parts" / RESTART).exists()
    assert not (tmp_path / "parts" / "run.h5").exists()
    parts = run(tmp_path / "parts", mills, contacts, case)
    assert not (tmp_path / "parts" / RESTART).exists()
    first, second = content(folder / "run.h5"), content(tmp_path / "parts" / "run.h5")
    assert first.keys() == second.keys()
    for name, values in first.items():
        assert np.array_equal(values, second[name], equal_nan=values.dtype.kind == "f"), name
    clocks = {"wall_clock_s", "processor_s", "ns_per_ball_step"}
    assert {k: v for k, v in whole.items() if k not in clocks} == {k: v for k, v in parts.items() if k not in clocks}


@pytest.mark.slow
def test_what_a_contact_has_from_its_beginning_outlives_a_stop(mills, contacts, tmp_path, monkeypatch, small_chunks):
    """The coefficients of the speed of the hit, and cohesion; balls are in contact when the run is stopped."""
    changed = {
        "restitution": RestitutionTable(speeds_m_s=(0.01, 0.1, 1.0), values=(0.1, 0.3, 0.7)),
        "cohesion": CohesionConfig(ball_ball_J_m2=0.5, ball_wall_J_m2=0.5),
    }
    own = {"calibrated": contacts["calibrated"].model_copy(update=changed)}
    whole = run(tmp_path / "whole", mills, own)
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 60)
        run(tmp_path / "parts", mills, own)
    assert run(tmp_path / "parts", mills, own)["ledger_J"] == whole["ledger_J"]


@pytest.mark.slow
def test_a_run_that_was_stopped_twice(unbroken, mills, contacts, tmp_path, monkeypatch, small_chunks):
    _, whole = unbroken
    for chunks in (20, 25):
        with monkeypatch.context() as patched, pytest.raises(Killed):
            kill_after(patched, chunks)
            run(tmp_path / "parts", mills, contacts)
    assert run(tmp_path / "parts", mills, contacts)["ledger_J"] == whole["ledger_J"]


@pytest.mark.slow
def test_a_longer_window_is_restarted_too(mills, contacts, tmp_path, monkeypatch, small_chunks):
    """A window that is made longer until the powers are known well, stopped in its second part."""
    case = CASE.model_copy(update={"power_error_max": 1e-6, "window_max_s": 0.11})
    whole = run(tmp_path / "whole", mills, contacts, case)
    assert whole["window_s"] == pytest.approx(2 * 0.05)
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 75)
        run(tmp_path / "parts", mills, contacts, case)
    parts = run(tmp_path / "parts", mills, contacts, case)
    assert (parts["window_s"], parts["ledger_J"]) == (whole["window_s"], whole["ledger_J"])


def begins_at(begin_s):
    """Tells that a window begins anew until that time, and is then as long as it can be."""

    def goes_on(recording):
        return "anew" if recording.samples[0][0, SAMPLE.time_s] < begin_s else "longer"

    return lambda simulation: goes_on


# In the first window, at its end, between the windows, at the beginning of the second, and in its second part.
@pytest.mark.slow
@pytest.mark.parametrize("chunks", [60, 72, 73, 75, 130])
def test_a_window_that_begins_anew_is_that_of_a_longer_run_up(
    mills, contacts, tmp_path, monkeypatch, small_chunks, chunks
):
    """The same motion, counted from the beginning of the second window on, stopped and continued too."""
    case = CASE.model_copy(update={"power_error_max": 1e-6, "window_max_s": 0.16})
    monkeypatch.setattr(runs, "_goes_on", begins_at(0.03))
    whole = run(tmp_path / "whole", mills, contacts, case)
    assert whole["window_s"] == pytest.approx(0.10) and 0.07 < whole["begin_s"] < 0.075
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, chunks)
        run(tmp_path / "parts", mills, contacts, case)
    parts = run(tmp_path / "parts", mills, contacts, case)
    assert [parts[key] for key in ("begin_s", "steps", "ledger_J")] == [
        whole[key] for key in ("begin_s", "steps", "ledger_J")
    ]
    later = CASE.model_copy(update={"discard_s": whole["begin_s"], "window_s": 0.10})
    longer = run(tmp_path / "longer", mills, contacts, later)
    assert (longer["begin_s"], longer["steps"]) == (whole["begin_s"], whole["steps"])
    first, second = content(tmp_path / "whole/run.h5"), content(tmp_path / "longer/run.h5")
    assert first.keys() == second.keys()
    for name, values in first.items():
        assert values == pytest.approx(second[name], rel=1e-9, abs=1e-12, nan_ok=True), name


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["truncated", "other speed"])
def test_a_useless_restart_file_is_ignored(unbroken, mills, contacts, tmp_path, monkeypatch, small_chunks, damage):
    _, whole = unbroken
    speed = 1100 if damage == "other speed" else 1200
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 40)
        run(tmp_path / "parts", mills, contacts, CASE.model_copy(update={"speed_hz": speed / 60}))
    restart = tmp_path / "parts" / RESTART
    if damage == "truncated":
        restart.write_bytes(restart.read_bytes()[: restart.stat().st_size // 2])
    assert run(tmp_path / "parts", mills, contacts)["ledger_J"] == whole["ledger_J"]


@pytest.mark.slow
def test_words_and_the_time_between_restart_files_lose_no_run(
    unbroken, mills, contacts, tmp_path, monkeypatch, small_chunks, caplog
):
    """They decide no number, so that a stopped run goes on."""
    _, whole = unbroken
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 40)
        run(tmp_path / "parts", mills, contacts)
    other = {"emax": mills["emax"].model_copy(update={"title": "another"})}
    monkeypatch.setitem(globals(), "DEM", DEM.model_copy(update={"restart_interval_s": 1e-3}))
    with caplog.at_level("INFO", "millprint"):
        assert run(tmp_path / "parts", other, contacts)["ledger_J"] == whole["ledger_J"]
    assert "continuing from" in caplog.text


@pytest.mark.slow
def test_a_run_of_a_shortened_step_goes_on_with_it(mills, contacts, tmp_path, monkeypatch, small_chunks):
    """Where the balance does not close with the first step, which is not simulated again after a stop."""
    case, steps = CASE.model_copy(update={"rayleigh_fraction": 0.2}), []

    def summarise(simulation, *arguments):
        steps.append(simulation.case.rayleigh_fraction)
        if steps[-1] == 0.2:
            raise OpenBalanceError(0.1, 0.05, "", 0.5)
        return summarised(simulation, *arguments)

    summarised = runs.summarise
    monkeypatch.setattr(runs, "summarise", summarise)
    whole = run(tmp_path / "whole", mills, contacts, case)
    assert steps == [0.2, 0.1]
    with monkeypatch.context() as patched, pytest.raises(Killed):
        kill_after(patched, 8, fraction=0.1)
        run(tmp_path / "parts", mills, contacts, case)
    assert steps == [0.2, 0.1, 0.2]
    assert run(tmp_path / "parts", mills, contacts, case)["ledger_J"] == whole["ledger_J"]
    assert steps == [0.2, 0.1, 0.2, 0.1]


def test_other_jobs_do_not_change_a_run(mills, contacts):
    """Two simulations that run alternately give the same results as each by itself."""
    alone = Simulation(CASE, mills["emax"], contacts["calibrated"], DEM)
    alone.run("alone")
    first, second = (
        Simulation(CASE.model_copy(update={"seed": seed}), mills["emax"], contacts["calibrated"], DEM)
        for seed in (0, 1)
    )
    second.run("beside")
    first.run("again")
    assert np.array_equal(first.balls.position, alone.balls.position)
    assert not np.array_equal(first.balls.position, second.balls.position)


def test_lists_that_are_too_short_are_made_longer(mills, contacts):
    """A run that begins with room for half a candidate a ball equals one that has plenty."""
    plenty, scarce = (Simulation(CASE, mills["emax"], contacts["calibrated"], DEM) for _ in range(2))
    names = ("ball", "partner", "plane", "sure", "lane", "trigger")
    cut = {name: getattr(scarce.candidates, name)[:12] for name in names}
    scarce.candidates = scarce.candidates._replace(**cut, found=scarce.candidates.found[:13])
    plenty.run("plenty")
    scarce.run("scarce")
    assert scarce.candidates.partner.size > 12
    assert np.array_equal(plenty.balls.position, scarce.balls.position)
    assert np.array_equal(plenty.totals, scarce.totals)


@pytest.mark.slow
def test_the_window_ends_when_the_powers_are_known_well(mills, contacts, tmp_path):
    case = CASE.model_copy(update={"power_error_max": 0.5, "window_max_s": 10.0, "window_s": 0.1})
    found = run(tmp_path / "certain", mills, contacts, case)
    assert 0.39 < found["window_s"] < 2.0
    assert max(found["power_relative_error"].values()) <= 0.5


def test_a_window_does_not_grow_by_default(mills, contacts):
    assert runs._goes_on(Simulation(CASE, mills["emax"], contacts["calibrated"], DEM)) is None
