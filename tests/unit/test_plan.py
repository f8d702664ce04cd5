"""The plan of a run: what simulations and jobs take, how long they take on some cores, and what is said about it."""

import json

import pytest

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.strict_yaml import read_yaml
from millprint.config.sweep import Case, DemConfig
from millprint.errors import ConfigError
from millprint.plan.costs import (
    BALL_STEP_S,
    CASE_START_S,
    JOB_START_S,
    UNKNOWN_S,
    Row,
    cost_of,
    measured_rows,
    own_ball_step,
    simulation_cost,
)
from millprint.plan.estimate import estimate_plan
from millprint.plan.jobs import STAGES, PlannedCase, PlannedJob, needed_for, planned_case, stage_title
from millprint.plan.text import plan_text
from millprint.plan.timetable import timetable
from tests.conftest import ROOT

DEM = DemConfig(time_step_s=1e-6, settle_s=0.25, discard_s=0.25, window_s=0.5)


def case_of(seed: int = 0, **given) -> Case:
    return Case(
        **{"mill": "emax", "contact": "calibrated", "ball_diameter_mm": 10, "fill_ratio": 0.1, "speed_rpm": 600,
           "seed": seed, "settle_s": 0.25, "discard_s": 0.25, "window_s": 0.5, **given}
    )  # fmt: skip


def planned(seed: int = 0, exists: bool = False, **given) -> PlannedCase:
    mill = MillConfig(**read_yaml(ROOT / "config/mills/emax.yaml"))
    contact = ContactConfig(**read_yaml(ROOT / "config/contacts/calibrated.yaml"))
    return planned_case(case_of(seed, **given), DEM, mill, contact, exists)


def job_of(rule: str = "a", after: tuple[int, ...] = (), stage: str = "doe", **given) -> PlannedJob:
    values = {"rule": rule, "stage": stage, "name": rule, "needed": True, "missing": True, "threads": 1, "after": after}
    return PlannedJob(**values | given)


def test_a_simulation_has_its_balls_and_steps_and_takes_time_for_each():
    own = planned()
    # 125 mL, a tenth of it balls of 10 mm: 23.9.
    assert own.balls == 24
    assert own.steps == pytest.approx(1_000_000, rel=1e-6)
    assert own.condition == "emax/calibrated/d10_f0.10_n600"
    cost = simulation_cost([own, planned(1)])
    assert cost.processor_s == pytest.approx(JOB_START_S + CASE_START_S + 2 * 24e6 * BALL_STEP_S)
    assert simulation_cost([planned(snapshot_interval_s=1e-4)]).disk_mb > simulation_cost([own]).disk_mb
    # A table of collisions that is too long is not written, and holds no more memory than the longest.
    long, longer = planned(window_s=200.0), planned(window_s=400.0)
    assert simulation_cost([long]).disk_mb == 0.0
    assert simulation_cost([long]).memory_mb == simulation_cost([longer]).memory_mb < 600


def test_a_job_that_makes_what_is_missing_leaves_its_other_cases():
    cases = planned(0, exists=True), planned(1)
    assert [each.case.seed for each in job_of(cases=cases).cases_to_run] == [1]
    # All files exist, but code or input has changed.
    assert len(job_of(cases=cases, missing=False).cases_to_run) == 2
    assert job_of(cases=cases, needed=False).cases_to_run == ()


def test_other_jobs_take_what_the_same_job_took_or_the_mean_of_its_rule():
    rows = [
        Row("thesis", "fit", "a", 10.0, 100.0, 1.0),
        Row("thesis", "fit", "b", 30.0, 200.0, 3.0),
        Row("smoke", "fit", "a", 1.0, 50.0, 0.1),
        Row("smoke", "draw", "draw", 5.0, 50.0, 0.1),
    ]
    assert cost_of(job_of("fit", name="a"), "thesis", rows).processor_s == JOB_START_S + 10
    assert cost_of(job_of("fit", name="c"), "mine", rows).processor_s == JOB_START_S + 20
    assert cost_of(job_of("fit", name="a"), "smoke", rows).processor_s == JOB_START_S + 1
    assert cost_of(job_of("draw"), "mine", rows).processor_s == JOB_START_S + 5
    unknown = cost_of(job_of("new"), "thesis", rows)
    assert unknown.processor_s == JOB_START_S + UNKNOWN_S
    assert not unknown.measured


def test_the_table_of_measured_runs_has_positive_times_and_no_job_twice():
    rows = measured_rows()
    assert {"smoke"} <= {row.run for row in rows} <= {"thesis", "smoke"}
    assert all(row.processor_s > 0 and row.memory_mb > 0 and row.disk_mb >= 0 for row in rows)
    assert len({(row.run, row.rule, row.job) for row in rows}) == len(rows)


def test_finished_simulations_tell_the_speed_of_this_machine(tmp_path):
    files = [tmp_path / f"{number}.json" for number in range(6)]
    for number, file in enumerate(files):
        file.write_text(json.dumps({"ns_per_ball_step": 10.0 * (number + 1)}))
    assert own_ball_step(files) == pytest.approx(35e-9)
    assert own_ball_step([*files[:4], tmp_path / "none.json"]) is None


def test_jobs_wait_for_cores_and_for_each_other():
    jobs = [job_of(), job_of(), job_of(after=(0,)), job_of(after=(1, 2), threads=2)]
    seconds, memory = {0: 3.0, 1: 5.0, 2: 4.0, 3: 2.0}, {0: 10.0, 1: 20.0, 2: 5.0, 3: 50.0}
    two = timetable(jobs, seconds, memory, 2)
    assert two.wall_s == 9.0
    assert two.memory_mb == 50.0
    assert timetable(jobs, seconds, memory, 1).wall_s == 14.0
    # A job that is done holds nobody up.
    assert timetable(jobs, {3: 2.0}, memory, 2).wall_s == 2.0
    assert timetable([], {}, {}, 2).wall_s == 0.0


def test_the_longest_chain_starts_first():
    """Two short jobs and a chain of three on two cores: the chain decides, if it is not left for last."""
    jobs = [job_of(), job_of(), job_of(), job_of(after=(2,)), job_of(after=(3,))]
    seconds = {0: 3.0, 1: 3.0, 2: 2.0, 3: 2.0, 4: 2.0}
    assert timetable(jobs, seconds, dict.fromkeys(seconds, 1.0), 2).wall_s == 6.0


def test_a_target_counts_what_it_waits_for():
    jobs = [job_of(), job_of(after=(0,)), job_of(), job_of("t", (1,), stage="")]
    assert needed_for(jobs, 3) == {0, 1, 3}


def test_every_stage_of_the_workflow_has_a_title():
    text = "".join(file.read_text() for file in (ROOT / "workflow/rules").glob("*.smk"))
    used = {part.split("/")[0] for part in text.split('f"{LOGS}/')[1:]}
    assert used - {"{case.path}.log"} == set(STAGES)
    with pytest.raises(ConfigError, match="nothing"):
        stage_title("nothing")


def test_the_text_says_what_is_new_and_done_and_how_long_it_takes(tmp_path):
    cases = planned(0, exists=True), planned(1)
    jobs = [
        job_of("run_dem_case", stage="dem", name="x", cases=(cases[0],), needed=False, missing=False),
        job_of("run_dem_case", stage="dem", name="y", cases=(cases[1],)),
        job_of("unheard", after=(1,)),
        job_of("everything", (0, 2), stage=""),
    ]
    estimate = estimate_plan(jobs, "thesis", [2, 1])
    text = plan_text(estimate, {"everything": 3}, 2, "results", 5000.0, "snakemake --cores 2")
    assert "simulations   2: 1 done, 1 new" in text
    assert "conditions    1: balls of 10 mm; fill ratio 0.1; 600 rpm" in text
    assert "together" + " " * 30 + "     2     0     1" in text
    assert "guessed: unheard" in text
    assert text.endswith("To run it: snakemake --cores 2")
    assert "TOO SMALL" not in text
    assert "TOO SMALL" in plan_text(estimate, {"everything": 3}, 2, "results", 0.1, "")
    # Two targets are told apart.
    both = plan_text(estimate, {"everything": 3, "x.json": 0}, 2, "results", 5000.0, "")
    assert "each by itself" in both


def test_a_plan_with_nothing_to_do_says_so():
    jobs = [job_of(needed=False, missing=False), job_of("everything", (0,), stage="")]
    text = plan_text(estimate_plan(jobs, "thesis", [2]), {"everything": 1}, 2, "results", 1.0, "")
    assert "nothing to do" in text
