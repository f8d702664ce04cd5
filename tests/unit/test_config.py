"""Configuration models refuse invalid values with a line for each fault; sweeps expand to named cases."""

import pytest

from millprint.config.checks import stop_on_bad_input
from millprint.config.errors import ConfigError
from millprint.config.sweep import DemConfig, SweepConfig, ball_count, expand_sweep

DEM = {"time_step_s": 2e-6, "settle_s": 0.2, "discard_turns": 2, "window_s": 1.0}
SWEEP = {
    "name": "s",
    "contacts": ["steel"],
    "ball_diameters_mm": [10, 5],
    "fill_ratios": [0.1],
    "speeds_rpm": [600],
    "seeds": [0, 1],
}


def test_steps_are_in_the_names_of_their_cases_and_bounds_go_with_them():
    sweep = SweepConfig(**SWEEP, time_steps_s=[9.5e-7, 2e-6], closure_max=0.02, rayleigh_fraction_max=0.4)
    cases = expand_sweep(sweep, DemConfig(**DEM), "emax")
    assert len(cases) == 8
    names = [case.name for case in cases[:4]]
    assert names == [f"d10_f0.10_n600_dt{step}_s{seed}" for step in ("9.5e-07", "2e-06") for seed in (0, 1)]
    assert {(case.closure_max, case.rayleigh_fraction_max) for case in cases} == {(0.02, 0.4)}


def test_charges_that_differ_by_a_ball_have_two_names():
    fills = [0.10, 0.0018, 0.001784, 0.001819, 0.3, 0.30006]
    cases = expand_sweep(SweepConfig(**SWEEP | {"fill_ratios": fills, "seeds": [0]}), DemConfig(**DEM), "emax")
    assert len({case.path for case in cases}) == len(cases) == 2 * len(fills)


@pytest.mark.parametrize(
    ("fill", "diameter", "count"), [(0.04, 10, 10), (0.10, 10, 24), (0.10, 5, 191), (0.40, 5, 764)]
)
def test_ball_counts_of_table_3_4(fill, diameter, count):
    assert ball_count(fill, 125e-6, diameter / 1000) == count


def test_a_refusal_is_printed_and_ends_the_program(capsys):
    with pytest.raises(SystemExit), stop_on_bad_input():
        raise ConfigError("first\nsecond")
    assert capsys.readouterr().err == "error: first\nerror: second\n"
