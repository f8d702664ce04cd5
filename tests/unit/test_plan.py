"""The plan of a run: what its jobs take, and what is said about it."""

from pathlib import Path
from types import SimpleNamespace

import pytest
from pydantic import ValidationError

from millprint.cases import simulate as simulations
from millprint.cases.simulate import simulate_each
from millprint.cases.table import CaseTable, Why
from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.included import load_contact, load_mill
from millprint.config.sweep import Case, DemConfig
from millprint.config.workflow import EngineConfig
from millprint.dem.lammps.cost import lammps_resources
from millprint.dem.laws.registry import step_scale
from millprint.dem.resources import LIKELY_BALL_STEP_S, LIKELY_START_S, resources_of
from millprint.run import plan
from millprint.run.plan import JOB_START_S, LONG_S, OTHER_S, SIMULATION_START_S, Job, check_disk, plan_text
from tests.conftest import ROOT

DEM = DemConfig(time_step_s=1e-6, settle_s=0.25, window_s=0.5, run_up_fraction=0)
CASE = Case(
    mill="emax", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.1, speed_hz=10.0, seed=0, settle_s=0.25,
    discard_s=0.25, window_s=0.5,
)  # fmt: skip


def resources(**given):
    return resources_of(CASE.model_copy(update=given), DEM, load_mill("emax"), load_contact("calibrated"))


def job(rule: str = "fit", threads: int = 1, outputs: tuple[str, ...] = ("results/fit.tsv",), **declared) -> Job:
    return Job(rule, threads, outputs, declared)


def test_a_simulation_is_likely_to_take_time_for_its_balls_and_steps():
    # 125 mL, a tenth of it balls of 10 mm: 24, for a second with steps of a microsecond.
    own = resources()
    assert own.processor_s == pytest.approx(LIKELY_START_S + 24e6 * LIKELY_BALL_STEP_S)
    grown = resources(window_max_s=5.0)
    assert (grown.processor_s, own.processor_max_s) == (own.processor_s, own.processor_s)
    assert grown.processor_max_s - own.processor_s == pytest.approx((5.0 - CASE.window_s) * 24e6 * LIKELY_BALL_STEP_S)
    # 1,000 collisions of a ball in a second, and 24 balls in 5,000 snapshots.
    assert own.disk_mb == pytest.approx(24 * 500 * 32e-6)
    assert resources(snapshot_interval_s=1e-4).disk_mb == pytest.approx(own.disk_mb + 24 * 5000 * 38e-6)
    # A table of collisions that is too long is not written.
    assert resources(window_s=400.0).disk_mb == 0


def test_what_was_made_is_said_where_it_is_there(tmp_path):
    """Not after a run that --until has ended before."""
    values = {"results": str(tmp_path), "mill": "mine", "contact": "steel", "given": " mine.yaml"}
    assert plan.success_lines([], "fingerprint", values) == []
    page = tmp_path / "mills/mine/fingerprint.pdf"
    page.parent.mkdir(parents=True)
    page.touch()
    _, made, look, _ = plan.success_lines([], "fingerprint", values)
    assert made.startswith("made:  ") and look.startswith(f"look:  {page}: ")


def test_what_is_not_recorded_is_planned_at_its_own_step():
    """Half of the case is settling and discarding: with steps four times as long, it takes an eighth and a half."""
    scale = step_scale(load_contact("calibrated"), CASE.ball_diameter_m / 2)
    dem = DEM.model_copy(update={"run_up_fraction": 4e-6 / scale})
    own = resources_of(CASE, dem, load_mill("emax"), load_contact("calibrated"))
    assert own.processor_s == pytest.approx(LIKELY_START_S + (1 / 8 + 1 / 2) * 24e6 * LIKELY_BALL_STEP_S)
    # LAMMPS has no longer one.
    planned = [
        lammps_resources(
            CASE, EngineConfig(**each.model_dump(), engine="lammps"), load_mill("emax"), load_contact("calibrated")
        )
        for each in (DEM, dem)
    ]
    assert planned[0] == planned[1]


def test_a_request_to_a_queue_is_capped_and_the_cap_reruns_nothing():
    capped = DEM.model_copy(update={"runtime_max_h": 0.25})
    own = resources_of(CASE, capped, load_mill("emax"), load_contact("calibrated"))
    # 2.4 s three times, in minutes, and ten to start.
    assert [own.requested_min(attempt) for attempt in (1, 2, 3)] == [11, 15, 15]
    assert resources().requested_min(3) == 33
    assert capped.model_dump() == DEM.model_dump()
    with pytest.raises(ValidationError, match="runtime_max_h"):
        DemConfig(runtime_max_h=0)


def test_a_job_takes_what_its_rule_declares_or_as_long_as_others():
    assert job(processor_s=40).processor_s == JOB_START_S + 40
    # The rule may simulate, but does not in this job.
    assert job(processor_s=0).processor_s == job().processor_s == JOB_START_S + OTHER_S
    assert job("train_surrogate").processor_s == JOB_START_S + LONG_S["train_surrogate"]
    assert job("run_dem_case", outputs=("a/summary.json",), processor_s=40).processor_s == SIMULATION_START_S + 40


def test_the_plan_counts_simulations_with_files_and_those_inside_a_rule(monkeypatch):
    monkeypatch.setattr("millprint.run.plan.free_mb", lambda files: 500.0)
    jobs = [
        job(
            "run_dem_case", outputs=("results/dem/a/run.h5", "results/dem/a/summary.json"), processor_s=59.5, mem_mb=900
        ),
        job("simulate_tumbling", processor_s=118, mem_mb=800),
        job("plot"),
    ]
    text = plan_text(jobs, 2)
    assert "simulations  1, and more inside simulate_tumbling\n" in text
    assert "about 2 min 0 s on 2 cores; 3 min 8 s of one processor; the longest job, simulate_tumbling, 2 min" in text
    assert "up to 1.7 GB" in text and "TOO SMALL" not in text
    grown = plan_text([*jobs, job(processor_s=58, processor_max_s=178)], 2)
    assert "4 min 8 s of one processor, at most 6 min 8 s until powers are known; the longest job" in grown
    assert "THE DISK IS TOO SMALL" in plan_text([*jobs, job(disk_mb=600)], 2)
    assert "nothing to do" in plan_text([], 2)


def test_a_run_that_has_no_room_is_refused_before_its_first_job(tmp_path, monkeypatch):
    results = str(tmp_path / "results/mine")
    monkeypatch.setattr(plan.shutil, "disk_usage", lambda path: SimpleNamespace(free=30e6))
    check_disk([job(disk_mb=20), job()], results)
    with pytest.raises(ConfigError, match="needs about 42 MB and 30 MB are free on that disk; make room"):
        check_disk([job(disk_mb=40), job()], results)


def test_a_run_continues_with_what_is_done_and_whole_and_repeats_what_changed(tmp_path):
    made, lost = [], set()

    def simulate(values: dict) -> dict:
        made.append(values["seed"])
        return {"power_W": 2.0 * values["seed"]}

    def call(**seeds: int) -> dict:
        runs = {name: {"seed": seed} for name, seed in seeds.items()}
        return simulate_each(runs, simulate, [DEM], "runs", tmp_path / "done", is_whole=lambda name: name not in lost)

    assert call(a=1, b=2) == {"a": {"power_W": 2.0}, "b": {"power_W": 4.0}}
    assert call(a=1, b=3, c=4)["b"] == {"power_W": 6.0} and made == [1, 2, 3, 4]
    lost.add("a")
    assert call(a=1, c=4)["c"] == {"power_W": 8.0} and made == [1, 2, 3, 4, 1]


def test_a_run_is_repeated_where_the_code_of_its_simulation_changed(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(simulations, "program_digest", lambda file: digests[Path(file).name])

    def simulate(values: dict) -> dict:
        made.append(values["seed"])
        return {}

    for digest in ("first", "first", "second"):
        digests = {Path(__file__).name: digest}
        simulate_each({"a": {"seed": 1}}, simulate, [DEM], "runs", tmp_path / "done")
    assert made == [1, 1]


def test_a_case_of_several_rows_is_simulated_as_the_first_of_them_says(monkeypatch):
    """A sweep of the configuration that has a case of the mill's own sweep, with another window."""
    monkeypatch.chdir(ROOT)
    sweep = {
        "name": "mine", "contacts": ["calibrated"], "ball_diameters_mm": [10], "fill_ratios": [0.2], "window_s": 9.0,
        "speeds_rpm": [300], "seeds": [0],
    }  # fmt: skip
    config, mills, contacts, _ = load_workflow({"mill": "planetary", "sweeps": [sweep]}, [])
    table = CaseTable(config, mills, contacts)
    (own,) = table.rows(Why.SWEEP, "mine")
    others = table.cases(Why.MILL, "planetary")
    assert own.case.path in others and others[own.case.path] != own.case
    assert table.at(own.case.path) == own and own.folder == f"dem/{own.case.path}"
    other = next(path for path in others if path != own.case.path)
    assert table.at(other).why is Why.MILL and table.processor_s([table.at(other)]) > 0
    with pytest.raises(ConfigError, match="no such case"):
        table.at("planetary/calibrated/d1_f0.10_n1_s0")
