"""A configuration of twenty lines: its meaning, its optional parts, and the refusals of faults in it."""

import copy
import re
import shutil

import pytest
import yaml

from millprint.cases.of_mill import mill_cases
from millprint.cases.table import has_chapters
from millprint.checks.before_running import check_before_running
from millprint.config.checks import load_workflow
from millprint.fingerprint.sweep_checks import fingerprint_faults
from millprint.thesis.chapter_checks import chapter_faults, curve_faults
from tests.conftest import ROOT, configuration
from tests.refusals import refusal, refusals

HANDBOOK = (ROOT / "docs/how_to/configuration.md").read_text()
TWENTY_LINES = re.search(r"^```yaml\n(name: my_mill.*?)^```", HANDBOOK, re.M | re.S)[1]
FILE = "my.yaml"
CHAPTER_SECTIONS = ("data", "doe", "calibration", "partition", "yields", "surrogate")
CHAPTER_KEYS = ("cycle_fill_ratio", "maps", "inverse")


@pytest.fixture(autouse=True)
def in_a_project(tmp_path, monkeypatch):
    """A folder with the mills and contact sets of the project, and the user's own file."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    (tmp_path / FILE).write_text(TWENTY_LINES)
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def own() -> dict:
    return yaml.safe_load(TWENTY_LINES)


@pytest.fixture
def thesis() -> dict:
    return configuration()


def fault(content: dict) -> str:
    return refusal(load_workflow, content, [FILE])


def test_the_handbooks_twenty_lines_are_whole_and_have_no_chapters(own):
    assert len(TWENTY_LINES.splitlines()) <= 20
    config, mills, contacts, cases = load_workflow(own, [FILE])
    assert config.chapters is None and not has_chapters(config, cases) and cases == {}
    assert list(contacts) == ["calibrated"]
    paths = [case.path for case in mill_cases(mills["planetary"], config.mills)]
    assert paths == [
        f"planetary/calibrated/d10_f{fill}_n{speed}_s{seed}"
        for speed in (300, 500)
        for fill in ("0.10", "0.20", "0.30")
        for seed in (0, 1, 2)
    ]
    assert [*fingerprint_faults(config, FILE), *curve_faults(config, cases, FILE)] == []


def test_the_twenty_lines_pass_every_check_before_the_first_job(own):
    # One mill in the box, since each one's balls are packed by the check.
    own["mills"]["box"] = ["planetary"]
    check_before_running(*load_workflow(own, [FILE]), FILE, chapter_faults)


def test_only_the_mill_is_required():
    config, mills, _, cases = load_workflow({"mill": "spex"}, [FILE])
    assert (config.name, config.results, config.contacts, config.sweeps) == ("run", "results", ["calibrated"], [])
    assert config.mills.named == config.mills.box and config.mills.contact == "calibrated"
    # Without a sweep in the configuration the mill keeps its own.
    assert mills["spex"].sweep == load_workflow({"mill": "emax"}, [FILE])[1]["spex"].sweep
    assert [*fingerprint_faults(config, FILE), *curve_faults(config, cases, FILE)] == []
    assert fault({}).endswith("mill: this key is missing")


def test_balls_are_those_of_the_first_contact_set_by_default(own):
    assert load_workflow({**own, "contacts": ["steel", "calibrated"]}, [FILE])[0].mills.contact == "steel"
    own["mills"]["contact"] = "steel"
    config, mills, contacts, _ = load_workflow(own, [FILE])
    assert list(contacts) == ["calibrated", "steel"]
    assert {case.contact for case in mill_cases(mills["planetary"], config.mills)} == {"steel"}


@pytest.mark.parametrize(("change", "parts"), refusals("a_fault_in_the_own_file_is_one_line"))
def test_a_fault_in_the_own_file_is_one_line(own, change, parts):
    content = {**own, **change}
    assert all(part in fault(content) for part in parts)


def without(content: dict, key: str) -> dict:
    """The configuration without one thing that the chapters need."""
    content = copy.deepcopy(content)
    (content["fingerprint"] if key in CHAPTER_KEYS else content).pop(key)
    return content


@pytest.mark.parametrize("key", [*CHAPTER_SECTIONS, *CHAPTER_KEYS])
def test_chapters_without_one_of_their_sections_are_refused_in_one_line(thesis, key):
    named = f"fingerprint.{key}" if key in CHAPTER_KEYS else key
    line = fault(without(thesis, key))
    assert line.startswith(f"{FILE}: ")
    assert f"belong to the thesis, whose chapters need all of their sections, or none; {named} is missing" in line


@pytest.mark.parametrize("key", [*CHAPTER_SECTIONS, "fit", "claims"])
def test_a_key_of_the_thesis_beside_a_mill_is_named_in_one_line(own, key):
    """However little of it there is, and with whatever faults."""
    for value in ({"draws": 7}, {"no_such_key": 1}):
        assert fault({**own, key: value}).startswith(f"{FILE}: {key} belongs to the thesis")
    own["fingerprint"] = {"maps": None, "inverse": {}}
    assert fault(own).startswith(f"{FILE}: fingerprint.inverse belongs to the thesis")


def test_a_thesis_without_its_chapters_has_simulations_and_no_more(thesis):
    for key in CHAPTER_SECTIONS:
        thesis = without(thesis, key)
    for key in CHAPTER_KEYS:
        thesis = without(thesis, key)
    del thesis["fit"]
    config, _, _, cases = load_workflow(thesis, [FILE])
    assert cases and not has_chapters(config, cases)
    assert [*fingerprint_faults(config, FILE), *curve_faults(config, cases, FILE)] == []


def test_chapters_need_simulations_of_their_mill(thesis):
    thesis["sweeps"] = []
    config, _, _, cases = load_workflow(thesis, [FILE])
    assert config.chapters and not has_chapters(config, cases)
