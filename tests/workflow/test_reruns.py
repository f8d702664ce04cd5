"""After a finished fingerprint: a comment runs nothing again, a message no simulation, another law every one."""

import pytest
import yaml

from tests.workflow.conftest import copy_project, jobs_of, run_snakemake, share_kernels
from tests.workflow.test_mills import LINED

SWEEP = {**LINED["sweep"], "ball_diameters_mm": [11]}
ASKED = (
    "results/mills/lined/fingerprint.pdf",
    "--configfile",
    "config/smoke.yaml",
    "--config",
    "mill=lined",
    "mills={rayleigh_fraction: 0.1}",
)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A project with the finished fingerprint of a drum with lifters."""
    project = copy_project(tmp_path_factory.mktemp("reruns") / "millprint")
    share_kernels(project)
    (project / "config/mills/lined.yaml").write_text(yaml.safe_dump({**LINED, "sweep": SWEEP}))
    done = run_snakemake(project, *ASKED, timeout=900)
    assert done.returncode == 0, done.stdout[-4000:]
    return project


@pytest.fixture
def plan(finished):
    """A function that edits files, returns the jobs that a run would have, and takes the edits back."""
    before = {}

    def planned(edits) -> dict[str, int]:
        for file, edit in edits.items():
            path = finished / file
            before[path] = path.read_text()
            path.write_text(edit(before[path]))
            assert path.read_text() != before[path]
        done = run_snakemake(finished, *ASKED, "-n", timeout=300)
        assert done.returncode == 0, done.stdout[-4000:]
        assert bool(jobs_of(done.stdout)) != ("Nothing to be done" in done.stdout)
        return jobs_of(done.stdout)

    yield planned
    for path, text in before.items():
        path.write_text(text)


def simulated(jobs) -> int:
    return sum(number for rule, number in jobs.items() if rule.startswith(("run_dem", "run_long")))


def replaced(old: str, new: str):
    return lambda text: text.replace(old, new)


def with_remarks(text: str) -> str:
    """A source with another comment and another docstring, if it has one."""
    return text.replace('"""', '"""Edited: ', 1) + "\n# a remark\n"


def test_comments_and_docstrings_in_every_file_run_nothing_again(finished, plan):
    files = [path for place in ("src", "scripts") for path in (finished / place).rglob("*.py")]
    assert len(files) > 300
    assert plan({str(path.relative_to(finished)): with_remarks for path in files}) == {}


def test_messages_and_progress_leave_every_simulation_done(plan):
    jobs = plan(
        {
            "src/millprint/dem/run.py": replaced('"simulated in %.1f s', '"took %.1f s'),
            "src/millprint/dem/packing.py": replaced("lower the fill ratio", "use fewer balls"),
            "src/millprint/run/progress.py": replaced("EVERY_S, FIRST_S = 30.0", "EVERY_S, FIRST_S = 60.0"),
            "src/millprint/run/job.py": replaced(": begin", ": starts"),
            "scripts/run_dem_case.py": replaced("so that it is slower", "which is slower"),
            "src/millprint/figures/mill_sheet_figure.py": replaced("import", "import re\nimport"),
        }
    )
    assert simulated(jobs) == 0


def test_another_law_simulates_everything_again(plan):
    jobs = plan({"src/millprint/dem/law.py": replaced("STOP_SHARE = 0.25", "STOP_SHARE = 0.2")})
    assert simulated(jobs) >= 1
    assert "describe_mill" in jobs


def test_another_version_of_the_physics_simulates_everything_again(plan):
    assert simulated(plan({"src/millprint/dem/__init__.py": replaced("PHYSICS = 1", "PHYSICS = 2")})) >= 1
