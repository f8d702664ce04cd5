"""After a finished fingerprint: a comment runs nothing again, a message no simulation, another law every one."""

import os

import pytest
import yaml

from millprint.run import kernel
from tests.unit.test_recipes import RECIPES
from tests.workflow.conftest import LINED_RUN, jobs_of, run_snakemake


@pytest.fixture
def plan(lined_project):
    """A function that edits files, returns the jobs that a run would have, and takes the edits back."""
    before = {}

    def planned(edits) -> dict[str, int]:
        for file, edit in edits.items():
            path = lined_project / file
            before[path] = path.read_text(), path.stat().st_mtime_ns
            path.write_text(edit(before[path][0]))
            assert path.read_text() != before[path][0]
        done = run_snakemake(lined_project, *LINED_RUN, "-n", timeout=300)
        assert done.returncode == 0, done.stdout[-4000:]
        assert bool(jobs_of(done.stdout)) != ("Nothing to be done" in done.stdout)
        return jobs_of(done.stdout)

    yield planned
    for path, (text, date) in before.items():
        path.write_text(text)
        os.utime(path, ns=(date, date))


def replaced(old: str, new: str):
    def edit(text: str) -> str:
        assert old in text, f"nothing to edit: {old}"
        return text.replace(old, new)

    return edit


def with_remarks(text: str) -> str:
    """A source with another comment and another docstring, if it has one."""
    return text.replace('"""', '"""Edited: ', 1) + "\n# a remark\n"


def test_comments_and_docstrings_in_every_file_run_nothing_again(lined_project, plan):
    files = [path for place in ("src", "scripts") for path in (lined_project / place).rglob("*.py")]
    assert len(files) > 200
    assert plan({str(path.relative_to(lined_project)): with_remarks for path in files}) == {}


def of_dem(**values):
    """An edit of a configuration that gives these values to keys of `dem`."""
    return lambda text: yaml.safe_dump(yaml.safe_load(text) | {"dem": yaml.safe_load(text)["dem"] | values})


def test_what_no_simulation_reads_leaves_every_one_done(plan):
    """Messages, progress, words, pictures, a new statistic, other counting, and tolerances that the runs keep."""
    rules = [
        {"name": name, "gap_turns": gap} for name, gap in (("gap_0_02", 0.02), ("lifetimes", 0), ("gap_0_05", 0.05))
    ]
    (statistic,) = RECIPES["observable"]["edits"]
    jobs = plan(
        {
            "src/millprint/dem/run.py": replaced('"simulated in %.1f s', '"took %.1f s'),
            "src/millprint/dem/packing.py": replaced(" in the vessel: {reason}", " in that vessel: {reason}"),
            "src/millprint/run/job.py": replaced("EVERY_S, FIRST_S = 30.0", "EVERY_S, FIRST_S = 60.0"),
            "scripts/run_dem_case.py": replaced("so that it is slower", "which is slower"),
            "src/millprint/figures/mill_sheet_figure.py": replaced(
                "import numpy as np", "import re\nimport numpy as np"
            ),
            f"src/millprint/{statistic['file']}": replaced(statistic["text"], statistic["becomes"]),
            "config/mills/lined.yaml": replaced("title: Drum with", "title: Mill with"),
            "config/contacts/lined.yaml": replaced("thesis Table", "Table"),
            "lined.yaml": of_dem(restart_interval_s=7.0, overlap_max=0.2, closure_max=0.1, counting_rules=rules),
        }
    )
    assert "run_dem_case" not in jobs and "describe_mill" in jobs


def test_a_tolerance_that_the_runs_do_not_keep_simulates_again(plan):
    assert plan({"lined.yaml": of_dem(closure_max=1e-9)})["run_dem_case"] == 19


def test_another_law_simulates_everything_again(lined_project, plan, monkeypatch):
    # The check before a run needs kernels of the mills only, which are those of the law before: nothing is compiled.
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(lined_project / ".numba_cache" / kernel.cache_folder().name))
    jobs = plan({"src/millprint/dem/law.py": replaced("STOP_SHARE = 1 / 24", "STOP_SHARE = 1 / 25")})
    # Six of its sweep, and one that its fingerprint does not see.
    assert jobs["run_dem_case"] == 19
    assert "describe_mill" in jobs
