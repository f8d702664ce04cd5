"""The record of the smoke run: valid for its profile, complete, and a copy of the results checked against it."""

import json
import shutil
import subprocess
import sys
from urllib.parse import unquote

import pytest

from millprint.provenance.lineage import check_folder
from tests.crates import faults_of
from tests.workflow.conftest import run_snakemake

SMOKE = ("--configfile", "config/smoke.yaml")
METADATA = "ro-crate-metadata.json"
# What nobody has told us: a person who runs, addresses of the authors and of the software, and a publisher. The last
# check compares a class of the vocabulary, not the software, with an address.
NOT_KNOWN = (
    "The Action SHOULD have an agent",
    "The organization SHOULD have a URL",
    "The Application SHOULD have a url",
    "The `publisher` property",
    "The README.md SHOULD",
    "The SoftwareApplication id SHOULD be an absolute URI",
)


@pytest.fixture(scope="module")
def crate(smoke_project) -> dict[str, dict]:
    content = json.loads((smoke_project / "results/ro-crate-metadata.json").read_text())
    return {entity["@id"]: entity for entity in content["@graph"]}


def test_the_crate_keeps_every_requirement_and_recommendation_but_for_what_nobody_knows(smoke_project, tmp_path):
    faults = faults_of(smoke_project / "results", tmp_path, "RECOMMENDED")
    assert [fault for fault in faults if not any(words in fault for words in NOT_KNOWN)] == []


def test_the_validator_finds_what_is_missing(smoke_project, tmp_path):
    """Without this, a validator that checks nothing would pass."""
    content = json.loads((smoke_project / "results/ro-crate-metadata.json").read_text())
    root, about = ({entity["@id"]: entity for entity in content["@graph"]}[name] for name in ("./", METADATA))
    del root["license"], root["mainEntity"], root["hasPart"]
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / METADATA).write_text(json.dumps(content | {"@graph": [about, root]}))
    faults = "\n".join(faults_of(tmp_path / "results", tmp_path))
    assert "license" in faults and "mainEntity" in faults


def test_every_result_and_every_table_of_the_configuration_is_in_it(smoke_project, crate):
    results = {unquote(entity["@id"]) for entity in crate["#run"]["result"]}
    assert {"report/claims.tsv", "report/gallery.html", "fingerprint/descriptors.tsv"} <= results
    assert sum(path.endswith("summary.json") for path in results) > 10
    read = {entity["@id"] for entity in crate["#run"]["object"]}
    assert {"report/run.yaml", "crate/config/smoke.yaml", "crate/config/mills/emax.yaml"} <= read
    assert {"crate/config/data/screening.tsv", "crate/config/contacts/steel.yaml"} <= read
    assert crate["#parameter/data.screening"]["workExample"]["@id"] == "crate/config/data/screening.tsv"
    rules = {entity["@id"] for entity in crate["crate/workflow/Snakefile"]["hasPart"]}
    assert {"crate/workflow/rules/dem.smk", "crate/workflow/rules/chapters.smk"} <= rules
    assert crate["#run"]["startTime"] < crate["#run"]["endTime"]


def test_the_results_and_a_copy_of_them_are_as_it_says(smoke_project, tmp_path):
    shutil.copytree(smoke_project / "results", tmp_path / "copied")
    count, faults = check_folder(tmp_path / "copied")
    # Other tests may have run further mills, which the crate does not know.
    assert count > 400 and {fault.what for fault in faults} <= {"additional"}
    (tmp_path / "copied/report/claims.tsv").unlink()
    assert "missing: report/claims.tsv" in "\n".join(map(str, check_folder(tmp_path / "copied")[1]))


def test_further_targets_come_into_it_by_the_command(smoke_project, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "millprint.cli", "crate"], cwd=smoke_project, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert check_folder(smoke_project / "results")[1] == []
    assert "Nothing to be done" in run_snakemake(smoke_project, "write_crate", *SMOKE).stdout
