"""The lineage of a file, the crate of a run, and a check of a copy of it."""

import json
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest

from millprint.config.errors import ConfigError
from millprint.provenance.lineage import ADDITIONAL, CHANGED, MISSING, Job, check_folder, places, read_jobs, trace
from tests.refusals import refusal, refusals
from tests.unit.made_run import CONFIG, JOBS, MILL, RUN, describe_run, keep_record, make_run, write

FIGURE = "doe/mean yield.svg"


@pytest.fixture
def run(tmp_path, monkeypatch) -> Path:
    """The folder of a finished run, which is also the current one."""
    monkeypatch.chdir(tmp_path)
    make_run()
    return tmp_path


def entities(folder: str = "results") -> dict[str, dict]:
    graph = json.loads(Path(folder, "ro-crate-metadata.json").read_text())["@graph"]
    found = {entity["@id"]: entity for entity in graph}
    assert len(found) == len(graph), "two entities have one identifier"
    return found


def faults(folder="results") -> list[tuple[str, str]]:
    return [(fault.what, fault.path) for fault in check_folder(Path(folder))[1]]


def test_a_lineage_holds_what_the_targets_need_and_nothing_else():
    jobs = {
        "c": Job("join", ("a", "b"), 30.0, 41.2),
        "a": Job("make", ("source",), 10.0, 20.0),
        "b": Job("make", ("a", "other"), 20.0, 30.0),
        "d": Job("else", ("unused",), 1.0, 99.0),
    }
    found = trace(["c"], jobs)
    assert (found.made, found.sources) == (("a", "b", "c"), ("other", "source"))
    assert (found.begin, found.end) == (datetime.fromtimestamp(10, UTC), datetime.fromtimestamp(41, UTC))
    with pytest.raises(ConfigError, match=r"^e: Snakemake has no record"):
        trace(["c", "e"], jobs)


def test_records_with_names_longer_than_a_file_name_are_found(run):
    path = f"results/{'long/' * 80}file.tsv"
    keep_record(path, {"rule": "make", "input": ["a"], "starttime": 1.0, "endtime": 2.0})
    write(".snakemake/metadata/bm90IGpzb24=", "not JSON")
    write(".snakemake/metadata/#", "{}")
    jobs = read_jobs()
    assert set(jobs) == {*JOBS, path}
    assert jobs[path] == Job("make", ("a",), 1.0, 2.0)


def test_the_configuration_names_who_runs_and_the_licence_of_the_results(run):
    said = {"agent": "A. Miller", "orcid": "0000-0002-1825-0097", "affiliation": "A mill", "licence": "CC-BY-4.0"}
    make_run({**CONFIG, "provenance": said})
    describe_run()
    found = entities()
    (person,) = [entity for entity in found.values() if entity["@type"] == "Person"]
    assert person == {
        "@id": "https://orcid.org/0000-0002-1825-0097", "@type": "Person", "name": "A. Miller", "affiliation": "A mill"
    }  # fmt: skip
    assert found["#run"]["agent"]["@id"] == found["./"]["author"]["@id"] == person["@id"]
    assert found["./"]["license"]["@id"] == "https://spdx.org/licenses/CC-BY-4.0"
    # That of the software stays.
    assert found["crate/workflow/Snakefile"]["license"]["@id"] == "https://spdx.org/licenses/MIT"


def test_the_same_run_is_described_by_the_same_bytes_anywhere(run, tmp_path_factory, monkeypatch):
    describe_run()
    first = Path("results/ro-crate-metadata.json").read_bytes()
    other = tmp_path_factory.mktemp("elsewhere")
    shutil.copytree(run, other, dirs_exist_ok=True)
    monkeypatch.chdir(other)
    describe_run()
    assert Path("results/ro-crate-metadata.json").read_bytes() == first
    assert str(run).encode() not in first


@pytest.mark.parametrize(
    ("harm", "line"),
    [
        (lambda: Path(RUN).unlink(), "results: no run has finished here: report/run.yaml is missing"),
        (lambda: Path("results/doe/runs.tsv").unlink(), "results/doe/runs.tsv: the file is missing; run the same"),
        (lambda: Path(MILL).unlink(), f"{MILL}: the file is missing"),
        (lambda: shutil.rmtree(".snakemake"), "results/doe/mean yield.svg: Snakemake has no record of the job"),
        (lambda: write("results/doe/runs.tsv", "other"), "results/doe/runs.tsv: changed since its job wrote it"),
    ],
)
def test_a_run_that_is_not_finished_or_was_changed_is_refused_in_one_line(run, harm, line):
    harm()
    said = refusal(describe_run)
    assert said.startswith(line)
    assert not Path("results/ro-crate-metadata.json").exists()


def test_a_copy_is_checked_file_by_file(run, tmp_path_factory):
    describe_run()
    copy = tmp_path_factory.mktemp("archive") / "copied"
    shutil.copytree("results", copy)
    assert check_folder(copy) == (6, [])
    # What every further run writes anew.
    write(f"{copy}/logs/doe/plot_runs.log", "later")
    write(f"{copy}/report/report.html", "later")
    assert faults(copy) == []
    changed = bytearray((copy / "doe/runs.tsv").read_bytes())
    changed[3] ^= 1
    (copy / "doe/runs.tsv").write_bytes(changed)
    (copy / FIGURE).unlink()
    write(f"{copy}/doe/notes.txt", "mine")
    with open(copy / "crate" / MILL, "a") as file:
        file.write("more")
    assert faults(copy) == [
        (CHANGED, f"crate/{MILL}"),
        (MISSING, FIGURE),
        (CHANGED, "doe/runs.tsv"),
        (ADDITIONAL, "doe/notes.txt"),
    ]


@pytest.mark.parametrize(("text", "line"), refusals("a_folder_without_a_crate_is_refused_in_one_line"))
def test_a_folder_without_a_crate_is_refused_in_one_line(tmp_path, text, line):
    if text:
        (tmp_path / "ro-crate-metadata.json").write_text(text)
    assert line in refusal(check_folder, tmp_path)


def test_a_crate_cannot_name_files_outside_of_its_folder(tmp_path):
    crate = {"@graph": [{"@id": "../secret", "sha256": "a", "contentSize": "1"}]}
    (tmp_path / "ro-crate-metadata.json").write_text(json.dumps(crate))
    assert faults(tmp_path) == [(CHANGED, "../secret")]


def test_copies_of_inputs_lie_at_their_place_in_the_project_wherever_that_is():
    found = places(["config/data/a.tsv", "/home/me/millprint/config/data/b.tsv", "../tables/my runs.tsv"])
    assert found["config/data/a.tsv"] == "crate/config/data/a.tsv"
    assert found["/home/me/millprint/config/data/b.tsv"] == "crate/config/data/b.tsv"
    assert found["../tables/my runs.tsv"].startswith("crate/outside/")
    assert found["../tables/my runs.tsv"].endswith("/my_runs.tsv")
    with pytest.raises(ValueError, match="same place"):
        places(["config/a.tsv", "/elsewhere/config/a.tsv"])
