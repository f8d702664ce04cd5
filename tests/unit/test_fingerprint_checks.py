"""Contradictions between the sections fingerprint and partition, sweeps and data are refused before a run."""

import shutil
from pathlib import Path

import pytest
import yaml

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


def test_a_case_outside_the_curves_names_its_row(tmp_path, monkeypatch):
    shutil.copytree(ROOT / "config", tmp_path / "config")
    monkeypatch.chdir(tmp_path)
    table = tmp_path / "config/data/regimes.tsv"
    table.write_text(table.read_text().replace("\t0.17\t41", "\t0.55\t132", 1))
    assert any("column fill_ratio, row 3 = 0.55" in line for line in faults(lambda content: None))
