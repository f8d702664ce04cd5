"""Configuration models refuse invalid values with a line for each fault; sweeps expand to named cases."""

import pytest

from millprint.config.checks import stop_on_bad_input
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.load import check_model, load_named
from millprint.config.sweep import DemConfig, SweepConfig, ball_count, expand_sweep
from tests.conftest import ROOT

DEM = {"time_step_s": 2e-6, "settle_s": 0.2, "discard_turns": 2, "window_s": 1.0}
SWEEP = {
    "name": "s",
    "contacts": ["steel"],
    "ball_diameters_mm": [10, 5],
    "fill_ratios": [0.1],
    "speeds_rpm": [600],
    "seeds": [0, 1],
}


def fault(content, model) -> str:
    with pytest.raises(ConfigError) as caught:
        check_model(content, model, "file.yaml")
    return str(caught.value)


def test_unknown_key_names_the_nearest_known_one():
    assert fault({**DEM, "setle_s": 1}, DemConfig) == "file.yaml: setle_s = 1: unknown key; did you mean settle_s?"


def test_a_value_out_of_bounds_names_the_bound():
    assert fault({**DEM, "window_s": -1}, DemConfig) == "file.yaml: window_s = -1: must be greater than 0"


def test_every_fault_has_its_line():
    assert len(fault({**DEM, "window_s": 0, "settle_s": "x"}, DemConfig).splitlines()) == 2


def test_two_counting_rules_of_one_name_are_refused():
    rules = [{"name": "a"}, {"name": "b"}, {"name": "a", "gap_turns": 0.01}]
    assert "two counting rules have the name a" in fault({**DEM, "counting_rules": rules}, DemConfig)


def test_a_sweep_over_the_step_varies_nothing_else():
    steps = {**SWEEP, "time_steps_s": [1e-6, 2e-6]}
    for other in ({"rayleigh_fraction": 0.1}, {"young_moduli_gpa": [2.0]}):
        assert f"time_steps_s and {next(iter(other))} cannot both be given" in fault({**steps, **other}, SweepConfig)
    assert "at least 1" in fault({**SWEEP, "time_steps_s": []}, SweepConfig)
    assert "a mill at rest" in fault({**steps, "speeds_rpm": [0]}, SweepConfig)


def test_steps_are_in_the_names_of_their_cases_and_bounds_go_with_them():
    sweep = SweepConfig(**SWEEP, time_steps_s=[9.5e-7, 2e-6], closure_max=0.02, rayleigh_fraction_max=0.4)
    cases = expand_sweep(sweep, DemConfig(**DEM), "emax")
    assert len(cases) == 8
    names = [case.name for case in cases[:4]]
    assert names == [f"d10_f0.10_n600_dt{step}_s{seed}" for step in ("9.5e-07", "2e-06") for seed in (0, 1)]
    assert {(case.closure_max, case.rayleigh_fraction_max) for case in cases} == {(0.02, 0.4)}


def test_the_name_in_a_file_must_be_the_files(tmp_path):
    text = (ROOT / "config/contacts/steel.yaml").read_text().replace("name: steel", "name: brass")
    (tmp_path / "steel.yaml").write_text(text)
    with pytest.raises(ConfigError, match=r"steel.yaml: name = 'brass'"):
        load_named(tmp_path, "steel", ContactConfig, "contact set")


def test_a_sweep_is_every_combination():
    cases = expand_sweep(SweepConfig(**SWEEP), DemConfig(**DEM), "emax")
    assert [case.path for case in cases] == [
        "emax/steel/d10_f0.10_n600_s0",
        "emax/steel/d10_f0.10_n600_s1",
        "emax/steel/d5_f0.10_n600_s0",
        "emax/steel/d5_f0.10_n600_s1",
    ]
    assert {case.window_s for case in cases} == {1.0}


@pytest.mark.parametrize(
    ("fill", "diameter", "count"), [(0.04, 10, 10), (0.10, 10, 24), (0.10, 5, 191), (0.40, 5, 764)]
)
def test_ball_counts_of_table_3_4(fill, diameter, count):
    assert ball_count(fill, 125e-6, diameter / 1000) == count


def test_a_refusal_is_printed_and_ends_the_program(capsys):
    with pytest.raises(SystemExit), stop_on_bad_input():
        raise ConfigError("first\nsecond")
    assert capsys.readouterr().err == "error: first\nerror: second\n"
