"""Short cases as one job: which ones, and what such a job leaves as it is."""

import logging

import pytest

from millprint.config.sweep import Case
from millprint.dem import batches
from millprint.dem.resources import Resources, resources_together
from millprint.files import write_json
from millprint.job import job
from millprint.records import made_from, read_record, record_path, replace_entries

CONDITION = {"mill": "emax", "contact": "calibrated", "ball_diameter_mm": 10, "fill_ratio": 0.1, "speed_rpm": 600}
TIMES = {"settle_s": 0.1, "discard_s": 0.1, "window_s": 0.2}


def case(seed: int, **changed) -> Case:
    return Case(**{**CONDITION, **TIMES, "seed": seed, **changed})


def by_path(*cases: Case) -> dict[str, Case]:
    return {each.path: each for each in cases}


def taking(seconds: float, threads: int = 1):
    return lambda case: Resources(
        runtime_min=11, memory_mb=700, threads=threads, seconds=seconds, processor_s=seconds / 2, disk_mb=1
    )


def paths(*cases: Case) -> tuple[str, ...]:
    return tuple(each.path for each in cases)


def shared(sources, estimate, sweeps=None) -> list[tuple[str, ...]]:
    return [paths(*batch) for batch in batches.batches(sources, estimate, sweeps or {})]


# Seeds of a condition that share a job, but not with another condition.
ALONE = taking(batches.BATCH_S)


def test_seeds_of_a_condition_are_together_and_those_of_another_source_are_not():
    sweep = by_path(*(case(seed) for seed in (1, 0)), case(0, fill_ratio=0.3))
    study = by_path(*(case(seed) for seed in (0, 1, 2, 3)), *(case(seed, facets=24) for seed in (0, 5)))
    found = shared([sweep, study], ALONE)
    assert found == [paths(case(0), case(1)), paths(case(0, facets=24), case(5, facets=24))]
    # A further condition changes nothing for those that were there.
    more = shared([sweep | by_path(case(0, speed_rpm=77), case(1, speed_rpm=77)), study], ALONE)
    assert set(found) < set(more)


def filled(*fills: float, **changed) -> list[Case]:
    return [case(0, fill_ratio=fill, **changed) for fill in fills]


def test_short_conditions_of_a_sweep_share_jobs_of_about_the_same_length_in_their_order():
    cases = filled(*(round(0.1 + 0.01 * step, 2) for step in range(16)))
    found = shared([by_path(*cases)], taking(batches.BATCH_S / 8))
    assert found == [paths(*cases[start : start + 4]) for start in range(0, 16, 4)]
    # Jobs as short as their start are not worth it.
    assert shared([by_path(*cases)], taking(batches.SHORTEST_S / 16)) == [paths(*cases)]
    # Longer conditions, fewer in a job.
    assert shared([by_path(*cases)], taking(batches.BATCH_S / 2)) == [paths(*cases[n : n + 2]) for n in range(0, 16, 2)]
    assert shared([by_path(*cases)], taking(batches.BATCH_S)) == []


def test_cases_of_two_sweeps_share_a_job_only_if_both_are_shorter_than_a_job_is_worth():
    first, second = filled(0.1, 0.2), filled(0.1, 0.2, speed_rpm=300)
    sweeps = {path: name for name, own in (("first", first), ("second", second)) for path in paths(*own)}
    found = shared([by_path(*first, *second)], taking(batches.SHORTEST_S / 2), sweeps)
    assert found == [paths(*first), paths(*second)]
    quick = taking(batches.SHORTEST_S / 8)
    assert shared([by_path(*first, *second)], quick, sweeps) == [paths(*first, *second)]
    # A long sweep beside them keeps its jobs.
    third = filled(*(round(0.1 + 0.01 * step, 2) for step in range(16)), speed_rpm=450)
    more = sweeps | dict.fromkeys(paths(*third), "third")
    found = shared([by_path(*first, *third, *second)], quick, more)
    assert found == [*shared([by_path(*third)], quick), paths(*first, *second)]


def test_a_case_that_is_asked_for_alone_is_a_job_of_its_own():
    cases = filled(0.1, 0.2, 0.3)
    assert shared([by_path(cases[0]), by_path(*cases)], taking(1)) == [paths(*cases[1:])]


def test_the_seeds_of_a_condition_that_take_too_long_together_are_several_jobs():
    cases = [case(seed) for seed in range(100)]
    found = shared([by_path(*cases)], taking(batches.LONGEST_S / 50))
    assert found == [paths(*cases[start : start + 5]) for start in range(0, 100, 5)]
    several, whole = batches.by_rule([tuple(cases[:5]), tuple(cases[5:])])
    assert whole == {} and several == [tuple(cases[:5]), tuple(cases[5:])]


def test_thousands_of_short_cases_are_jobs_of_a_bounded_number_and_length():
    cases = [case(seed, fill_ratio=round(0.1 + 0.001 * fill, 3)) for fill in range(100) for seed in range(60)]
    found = shared([by_path(*cases)], taking(5))
    assert sorted(path for job in found for path in job) == sorted(paths(*cases))
    assert 0.5 * batches.MANY <= len(found) <= 1.1 * batches.MANY
    # Where so few jobs would be too long, there are more.
    found = shared([by_path(*cases)], taking(30))
    assert max(map(len, found)) * 30 <= batches.LONGEST_S + 30


def test_conditions_with_all_their_seeds_in_a_job_need_no_rule_of_their_own():
    both, other = (case(0), case(1)), (case(0, fill_ratio=0.3), case(0, fill_ratio=0.2))
    assert batches.by_rule([both, other]) == ([other], {batches.condition_of(case(0)): (0, 1)})
    many = tuple(case(seed) for seed in range(batches.FEW_SEEDS + 1))
    assert batches.by_rule([many]) == ([many], {})


@pytest.mark.parametrize("estimate", [taking(batches.LONGEST_S), taking(1, threads=2)])
def test_long_cases_and_those_with_threads_are_jobs_of_their_own(estimate):
    assert shared([by_path(case(0), case(1))], estimate) == []


def test_a_disturbed_twin_is_a_job_of_its_own():
    twins = by_path(*(case(seed, disturbance_m=1e-9) for seed in (0, 1)))
    assert shared([twins], taking(1)) == []


def test_a_job_of_several_cases_requests_the_sum_of_their_times_and_the_largest_memory():
    parts = [
        Resources(runtime_min=11, memory_mb=700, threads=1, seconds=60, processor_s=30, disk_mb=1),
        Resources(runtime_min=16, memory_mb=900, threads=1, seconds=120, processor_s=70, disk_mb=2),
    ]
    assert resources_together(parts) == Resources(
        runtime_min=19, memory_mb=900, threads=1, seconds=180, processor_s=100, disk_mb=3
    )


@pytest.fixture
def finished(tmp_path):
    """Log and file of a finished case, and its origin."""
    log, result, source = tmp_path / "a.log", tmp_path / "summary.json", tmp_path / "jar.stl"
    source.write_text("a jar")
    origin = batches.origin_digest(["values"], [source])
    with job(str(log), "a case", origin):
        write_json({"power_W": 1.0}, result)
    return log, result, origin


def test_a_case_is_finished_if_its_files_are_there_and_of_the_same_origin(finished, tmp_path):
    log, result, origin = finished
    assert batches.is_finished(origin, log, [result])
    (tmp_path / "jar.stl").write_text("another jar")
    assert not batches.is_finished(batches.origin_digest(["values"], [tmp_path / "jar.stl"]), log, [result])
    assert not batches.is_finished(batches.origin_digest(["other"], []), log, [result])
    batches.make_again(True)
    assert not batches.is_finished(origin, log, [result])
    batches.make_again(False)
    assert batches.is_finished(origin, log, [result])
    result.unlink()
    assert not batches.is_finished(origin, log, [result])


def test_a_file_that_the_user_keeps_stays_finished_and_one_without_a_record_does_not(finished):
    log, result, origin = finished
    record = record_path(log)
    replace_entries(record, read_record(record))
    assert made_from(record) == origin
    record.unlink()
    assert not batches.is_finished(origin, log, [result])


def test_a_case_that_begins_again_is_not_finished(finished):
    log, result, origin = finished
    with pytest.raises(RuntimeError), job(str(log), "a case", origin):
        raise RuntimeError("killed, say")
    assert not batches.is_finished(origin, log, [result])


def test_files_of_finished_cases_survive_the_failure_of_another(finished):
    _, result, _ = finished
    content = result.read_text()
    batches.set_apart([result])
    assert not result.exists()
    batches.take_back([result])
    assert result.read_text() == content
    # A newer file wins.
    batches.set_apart([result])
    result.write_text("newer")
    batches.take_back([result])
    assert result.read_text() == "newer" and not list(result.parent.glob("*.finished"))


def test_the_logs_of_two_cases_in_a_process_do_not_mix(tmp_path):
    for name in ("a", "b"):
        with job(str(tmp_path / f"{name}.log"), name):
            logging.getLogger("py.warnings").warning("of %s", name)
    assert "of b" not in (tmp_path / "a.log").read_text()
    assert "of b" in (tmp_path / "b.log").read_text()
