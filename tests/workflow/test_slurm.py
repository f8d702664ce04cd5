"""A part of the smoke workflow on a real SLURM; skipped if no daemon answers (.ci/slurm starts one)."""

import os
import re
import shutil
import subprocess

import pytest
import yaml

from millprint.run.files import read_json
from tests.conftest import ROOT
from tests.workflow.conftest import copy_project, run_snakemake

PROFILE = "profiles/slurm"
# The options for a site without accounting.
SITE = ("--slurm-status-command", "squeue", "--slurm-no-account", "--latency-wait", "10")
CASES = [f"results/dem/emax/calibrated/d10_f{fill}_n600_s0/summary.json" for fill in ("0.06", "0.10", "0.17")]
MODELS = [f"results/yield/models/{name}_primary.json" for name in ("linear", "gpr")]


def partition() -> str | None:
    """A partition with a node that accepts jobs; None if no SLURM answers."""
    if not shutil.which("sbatch") or not shutil.which("sinfo"):
        return None
    done = subprocess.run(["sinfo", "-h", "-o", "%R %T"], capture_output=True, text=True)
    found = [line.split()[0] for line in done.stdout.splitlines() if line.split()[1] in ("idle", "mixed", "allocated")]
    return found[0] if done.returncode == 0 and found else None


def test_the_profile_names_only_existing_rules():
    profile = yaml.safe_load((ROOT / PROFILE / "config.yaml").read_text())
    text = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    rules = set(re.findall(r"^\s*(?:use rule \w+ as|rule) (\w+)", text, re.MULTILINE))
    assert set(profile["set-resources"]) | set(profile["set-threads"]) <= rules
    assert set(profile["groups"]) <= rules
    # Short simulations choose their group by their case.
    assert '"simulations"' in text
    assert set(profile["group-components"]) == {"simulations", *profile["groups"].values()}
    # `retries` in a rule would override the profile and the option --retries.
    assert profile["retries"] > 0 and "retries:" not in text


def test_every_rule_that_runs_on_the_cluster_has_a_benchmark():
    """Each rule that is not local writes a benchmark to a folder of its own name."""
    text = "".join(path.read_text() for path in (ROOT / "workflow/rules").glob("*.smk"))
    for name, body in re.findall(r"^rule (\w+):\n((?:    .*\n|\n)+)", text, re.MULTILINE):
        if "script:" in body and "localrule" not in body:
            # That of a simulation is in the values of its case.
            assert f'f"{{BENCHMARKS}}/{name}/' in (text if name == "run_dem_case" else body), name


def test_smoke_jobs_run_through_slurm(tmp_path):
    place = partition()
    if place is None:
        pytest.skip("no SLURM daemon answers `sinfo` with a node: `sudo .ci/slurm` starts one on this machine")
    project = copy_project(tmp_path / "millprint")
    arguments = (
        *("--profile", PROFILE, *SITE),
        *("--default-resources", f"slurm_partition={place}", "runtime=30", "mem_mb=1000"),
        *("--configfile", "config/smoke.yaml", "--", *CASES, *MODELS),
    )
    done = run_snakemake(project, *arguments, timeout=1500)
    assert done.returncode == 0, done.stdout[-4000:]
    submitted = re.findall(r"submitted with SLURM jobid (\d+)", done.stdout)
    # One job for the kernels, one for all simulations, one for the yield models.
    assert len(submitted) == 3, done.stdout
    assert "/group_simulations_run_dem_case/" in done.stdout
    assert all(abs(read_json(project / case)["closure"]) < 0.005 for case in CASES)
    assert "Nothing to be done" in run_snakemake(project, *arguments).stdout


LONG_RUN = """
name: long
mill: emax
results: results
dem: {restart_interval_s: 5}
sweeps:
  - {name: long, contacts: [calibrated], ball_diameters_mm: [10], fill_ratios: [0.1], speeds_rpm: [600], seeds: [0],
     settle_s: 0.1, discard_s: 0.1, window_s: 600}
"""


@pytest.mark.cluster
@pytest.mark.skipif("MILLPRINT_SLURM" not in os.environ, reason="takes five minutes: `make slurm` runs it")
def test_a_simulation_that_exceeds_its_time_limit_continues_in_a_second_attempt(tmp_path):
    place = partition()
    assert place is not None, "no SLURM daemon answers `sinfo` with a node: `sudo .ci/slurm` starts one on this machine"
    project = copy_project(tmp_path / "millprint")
    (project / "config/config.yaml").write_text(LONG_RUN)
    case = "results/dem/emax/calibrated/d10_f0.10_n600_s0"
    done = run_snakemake(
        project,
        *("--profile", PROFILE, *SITE, "--default-resources", f"slurm_partition={place}", "runtime=30", "mem_mb=1000"),
        # One minute for the first attempt, as SLURM counts in minutes; twenty for the second: a machine may be busy.
        *("--set-resources", "run_dem_case:runtime=19*attempt-18", "--", f"{case}/summary.json"),
        timeout=1500,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    assert "Trying to restart job" in done.stdout
    log = (project / "results/logs/dem/emax/calibrated/d10_f0.10_n600_s0.log").read_text()
    # The log is that of the last attempt.
    assert "continuing from" in log, log
    assert abs(read_json(project / case / "summary.json")["closure"]) < 0.005
