"""Short cases that share a job: which ones, and how long it may take."""

from millprint.dem.batches import BATCH_S, CONDITION_S, short_batches
from tests.unit.test_seeds import by_path, case, taking

FILLS = [0.05 + 0.01 * number for number in range(7)]


def of_fills(seeds=(0,), **changed):
    return by_path(*(case(seed, fill_ratio=fill, **changed) for fill in FILLS for seed in seeds))


def test_short_cases_share_jobs_up_to_a_time_and_all_seeds_of_a_condition_are_in_one():
    cases = of_fills(seeds=(0, 1))
    found = short_batches({"sweeps": cases}, taking(10))
    # Three conditions of two seeds fill a job; the seventh condition would be alone in one.
    assert {name: len(batch) for name, batch in found.items()} == {"sweeps_1": 6, "sweeps_2": 6}
    for batch in found.values():
        assert 10 * len(batch) <= BATCH_S
        assert {each.fill_ratio for each in batch if each.seed == 0} == {each.fill_ratio for each in batch if each.seed}


def test_a_condition_that_is_long_or_alone_is_in_no_list():
    cases = of_fills()
    assert short_batches({"sweeps": cases}, taking(CONDITION_S + 1)) == {}
    assert short_batches({"sweeps": cases}, taking(1, threads=2)) == {}
    assert short_batches({"sweeps": by_path(case(0), case(1))}, taking(1)) == {}
    twins = by_path(case(0), case(0, disturbance_m=1e-9), case(0, fill_ratio=0.3))
    (batch,) = short_batches({"sweeps": twins}, taking(1)).values()
    assert all(not each.disturbance_m for each in batch) and len(batch) == 2


def test_cases_of_different_sources_share_no_job_and_a_case_is_in_one_only():
    sweeps, mill = of_fills(), of_fills() | of_fills(speed_rpm=300)
    found = short_batches({"sweeps": sweeps, "mill": mill}, taking(1))
    assert [each.path for each in found["sweeps_1"]] == list(sweeps)
    assert [each.path for each in found["mill_1"]] == [path for path in mill if path not in sweeps]


def test_cases_of_several_mills_and_contact_sets_may_share_a_job():
    found = short_batches({"box": by_path(case(0, mill="spex"), case(0, contact="steel"))}, taking(1))
    assert {(each.mill, each.contact) for each in found["box_1"]} == {("spex", "calibrated"), ("emax", "steel")}
