"""The scripts of rules: each says its settings, inputs and outputs, and runs with a mock of `snakemake`."""

import ast
import os
import re
from pathlib import Path
from unittest.mock import patch

import pytest

from tests.conftest import ROOT
from tests.mock import mock_snakemake, read_workflow, run_script

SMOKE = ROOT / "config/smoke.yaml"
# Files that a docstring may name together: figures.
DRAWN = re.compile(r"(.*_)?(figure|svg|png|pdf|gif)s?")


@pytest.fixture(scope="module", autouse=True)
def environment():
    """Reading the workflow sets the environment of jobs; other tests must not have it."""
    with patch.dict(os.environ):
        yield


@pytest.fixture(scope="module")
def rules():
    """The rules of the smoke run that have a script, of either engine."""
    read = [rule for given in ({}, {"dem": {"engine": "lammps"}}) for rule in read_workflow([SMOKE], given).rules]
    return [rule for rule in read if rule.script]


def test_every_adapter_says_its_settings_inputs_and_outputs(rules):
    assert len(rules) > 50
    for rule in rules:
        text = ast.get_docstring(ast.parse((ROOT / "scripts" / Path(rule.script).name).read_text())) or ""
        parts = re.findall(r"^(Settings|Inputs|Outputs): ", text, re.MULTILINE)
        assert parts == ["Settings", "Inputs", "Outputs"], f"{rule.script}: {parts}"
        said = text.partition("Outputs: ")[2]
        missing = [output for output, _ in rule.output.items() if f"`{output}`" not in said]
        assert all(map(DRAWN.fullmatch, missing)), f"{rule.name}: {missing}"


def test_every_script_of_scripts_is_that_of_a_rule(rules):
    used = {Path(rule.script).name for rule in rules}
    assert {path.name for path in (ROOT / "scripts").glob("*.py")} == used


@pytest.mark.parametrize(
    ("rule", "wildcards"), [("split_screening", {}), ("draw_mill", {"mill": "attritor"}), ("record_run", {})]
)
def test_an_adapter_runs_by_hand_with_a_mock(settings, monkeypatch, rule, wildcards):
    monkeypatch.chdir(settings)
    mocked = mock_snakemake(rule, [SMOKE], **wildcards)
    assert mocked.rule == rule and dict(mocked.wildcards.items()) == wildcards
    run_script(mocked)
    assert all(Path(file).stat().st_size for file in mocked.output)
    assert "done in" in Path(mocked.log[0]).read_text()
