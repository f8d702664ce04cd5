"""Uses of the workflow: with few libraries, from another folder, as a module, and with unknown names."""

import re
import subprocess
import sys

import pytest

from tests.refusals import refusals
from tests.workflow import drawn_mill
from tests.workflow.conftest import ROOT, ask_snakemake, copy_project, jobs_of, share_checks

# Reading the Snakefile may import Snakemake, what that imports, pydantic and yaml, but none of these.
HEAVY = "numpy pandas scipy numba h5py trimesh molmass matplotlib statsmodels sklearn xgboost shap torch vtk tqdm"


def test_reading_the_snakefile_imports_little(project):
    """Snakemake runs in a process in which millprint cannot import these; the plugins of Snakemake can."""
    blocked = f"""
import builtins, sys
plain = builtins.__import__
def checked(name, globals=None, *others, **named):
    importer = (globals or {{}}).get("__name__") or ""
    if importer.split(".")[0] == "millprint" and name.split(".")[0] in {HEAVY.split()!r}:
        raise ModuleNotFoundError(f"reading the Snakefile imports {{name}} in {{importer}}", name=name)
    return plain(name, globals, *others, **named)
builtins.__import__ = checked
from snakemake.cli import main
main(sys.argv[1:])
"""
    done = subprocess.run(
        [sys.executable, "-c", blocked, "-n", "--quiet", "all", "--configfile", "config/smoke.yaml"],
        cwd=project, capture_output=True, text=True, timeout=180,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize(("target", "parts"), refusals("an_unknown_name_is_refused_in_one_line"))
def test_an_unknown_name_is_refused_in_one_line(project, target, parts):
    done = ask_snakemake(project, "-n", target)
    (line,) = [line for line in done.stderr.splitlines() if "error" in line.lower()]
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert all(part in line for part in parts), line


MODULE = """
config = {{
    "mill": "mine",
    "contacts": ["calibrated"],
    "sweep": {{"speeds_rpm": [300, 500], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3]}},
    "results": "milling",
}}


module millprint:
    snakefile: {snakefile}
    config: config
    prefix: {prefix!r}


use rule * from millprint as mill_*


use rule run_dem_case from millprint as mill_run_dem_case with:
    resources:
        mem_mb=4321,
    message:
        "Ours: {{resources.mem_mb}} MB for {{wildcards.case}}"


rule all:
    input:
        "{prefix}milling/mills/mine/geometry.png",
    default_target: True
"""


def make_module(folder, snakefile: str, prefix: str = "") -> None:
    """A project of another workflow, with a mill of its own from a drawing."""
    (folder / "config/mills").mkdir(parents=True)
    drawn_mill.make(folder)
    (folder / "Snakefile").write_text(MODULE.format(snakefile=snakefile, prefix=prefix))


def test_another_workflow_uses_this_one_as_a_module_and_overrides_its_simulations(tmp_path):
    prefix = "sub/"
    make_module(tmp_path / "project", repr(str(ROOT / "workflow/Snakefile")), prefix)
    done = ask_snakemake(tmp_path / "project", "-n", "mill_fingerprint", "mill_explorer")
    plan = done.stdout + done.stderr
    assert done.returncode == 0, plan[-3000:]
    assert jobs_of(plan)["mill_describe_mill"] == jobs_of(plan)["mill_explore_mill"] == 1
    # Two speeds, one ball, three fill ratios, and eight that the fingerprint does not see.
    assert len(set(re.findall(rf" {prefix}milling/dem/(\S+)/summary.json", plan))) == 26
    assert len(re.findall(r"^ *Job \d+: Ours: 4321 MB for ", plan, re.MULTILINE)) == 26


def test_a_module_comes_from_a_remote_repository(tmp_path, monkeypatch):
    """On GitHub; git is configured to find that address on this machine."""
    clone, folder = copy_project(tmp_path / "remote"), tmp_path / "project"
    for command in (
        ["init", "-q"],
        ["add", "."],
        ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qm", "all"],
        ["tag", "v1"],
    ):
        subprocess.run(["git", *command], cwd=clone, check=True)
    settings = tmp_path / "gitconfig"
    settings.write_text(f'[url "file://{clone}"]\n\tinsteadOf = https://github.com/someone/millprint\n')
    monkeypatch.setenv("GIT_CONFIG_GLOBAL", str(settings))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    # The library is installed in the environment of Snakemake.
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))
    make_module(folder, 'github("someone/millprint", path="workflow/Snakefile", tag="v1")')
    done = ask_snakemake(folder, "--cores", "2")
    assert done.returncode == 0, done.stderr[-3000:]
    assert (folder / "milling/mills/mine/geometry.png").stat().st_size > 0
    assert not (folder / "results").exists()


def test_the_thesis_runs_in_another_folder_whose_name_a_shell_would_take_apart(tmp_path):
    folder = tmp_path / "Mühle 3 (Büro)"
    folder.mkdir()
    (folder / ".venv").symlink_to(sys.prefix)
    share_checks(folder)
    arguments = ("--snakefile", str(ROOT / "workflow/Snakefile"), "--directory", str(folder), "--cores", "1")
    command = [str(folder / ".venv/bin/python"), "-m", "snakemake", *arguments, "results/doe/design.tsv"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=180)
    assert done.returncode == 0, done.stderr[-3000:]
    assert (folder / "results/doe/design.tsv").stat().st_size > 0
