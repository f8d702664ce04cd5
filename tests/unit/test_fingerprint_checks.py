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


def test_a_case_outside_the_curves_names_its_row(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "config", tmp_path / "config")
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "config/data/regimes.tsv"
    table.write_text(table.read_text().replace("\t0.17\t41", "\t0.55\t132", 1))
    assert any("column fill_ratio, row 3 = 0.55" in line for line in faults(lambda content: None))
