"""Contradictions between the sections fingerprint and partition, sweeps and data are refused before a run."""

import shutil
from pathlib import Path

import pytest
import yaml

from millprint.cases.table import described_cases, mapped_cases
from millprint.config.checks import load_workflow
from millprint.fingerprint.sweep_checks import fingerprint_faults
from millprint.thesis.chapter_checks import curve_faults

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def in_the_root(monkeypatch):
    monkeypatch.chdir(ROOT)


def load(change=lambda content: None):
    content = yaml.safe_load(Path("config/config.yaml").read_text())
    change(content)
    config, _, _, cases = load_workflow(content, ["config/config.yaml"])
    return config, cases


def faults(change) -> list[str]:
    config, cases = load(change)
    return [*fingerprint_faults(config, "config.yaml"), *curve_faults(config, cases, "config.yaml")]


def test_the_configuration_of_the_thesis_has_no_fault():
    config, cases = load()
    assert [*fingerprint_faults(config, "config.yaml"), *curve_faults(config, cases, "config.yaml")] == []
    described = described_cases(config, cases).values()
    assert all(case.young_modulus_gpa is None and case.time_step_s is None for case in described)
    assert list(mapped_cases(config, cases, "steel")) == [0.04, 0.10, 0.40]


def test_amplitude_and_density_are_described_only_for_the_mill_of_the_run():
    config, cases = load()
    described = described_cases(config, cases)
    changed = [case for case in described.values() if case.amplitude_mm or case.density_kg_m3]
    assert {case.amplitude_mm for case in changed} == {None, 14, 20, 24}
    assert {case.density_kg_m3 for case in changed} == {None, 3900, 15000}
    other, cases = load(lambda content: content.update(mill="emax_post"))
    assert not [case for case in described_cases(other, cases).values() if case.amplitude_mm or case.density_kg_m3]
    assert not set(mapped_cases(config, cases, "steel").values()) & {case.path for case in changed}


def set_rule(content):
    content["fingerprint"]["counting_rule"] = "gap_0_05"


def set_threshold(content):
    content["fingerprint"]["counting_rule"] = "gap_0_03_over_1N"


def set_further_rule(content):
    content["convergence"]["counting_rules"] = ["lifetime"]


def set_contact(content):
    content["contacts"] = ["steel"]


def set_design_fill(content):
    content["partition"]["fill_ratios"] = [0.10, 0.02]


def set_other_mill(content):
    like = {"fingerprint": "config/config.yaml", "speed_rpm": 600, "ball_diameter_mm": 10, "fill_ratio": 0.1}
    content["fingerprint"]["inverse"]["targets"] = [{"name": "other", "like": like}]


def set_map_speed(content):
    content["fingerprint"]["maps"]["speed_rpm"] = 777


def few_fills(content):
    for sweep in content["sweeps"]:
        sweep["fill_ratios"] = [0.08, 0.10]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (set_rule, "fingerprint.counting_rule = gap_0_05: must be one of dem.counting_rules (lifetimes, gap_0_01,"),
        (set_threshold, "fingerprint.counting_rule = gap_0_03_over_1N: has a threshold"),
        (set_further_rule, "convergence.counting_rules = lifetime: must be one of dem.counting_rules"),
        (set_contact, "partition.contact = calibrated: must be one of contacts (steel)"),
        (
            set_design_fill,
            "partition.fill_ratios = 0.02: must lie within the simulated fill ratios of calibrated, 0.04",
        ),
        (set_other_mill, "fingerprint.inverse.targets.other.like: config/config.yaml: not a fingerprint"),
        (set_map_speed, "fingerprint.maps: no case of calibrated"),
        (few_fills, "contact set calibrated has 2 fill ratio(s)"),
    ],
)
def test_a_fault_is_one_line_with_file_key_and_value(change, message):
    found = faults(change)
    assert any(message in line for line in found)
    assert all(line.startswith(("config.yaml: ", "config/data/")) and "\n" not in line for line in found)


def test_a_case_outside_the_curves_names_its_row(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "config", tmp_path / "config")
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "config/data/regimes.tsv"
    table.write_text(table.read_text().replace("\t0.17\t41", "\t0.55\t132", 1))
    assert any("column fill_ratio, row 3 = 0.55" in line for line in faults(lambda content: None))
