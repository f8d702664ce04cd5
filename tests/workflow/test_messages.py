"""What people read at the end of a run, after a failure, and before a run."""

import csv
import io
import re
import subprocess
import sys
import time

import yaml

from millprint.run.plan import endings
from tests.workflow.conftest import active_environment, ask_snakemake, error_lines, run_snakemake
from tests.workflow.test_reading import state_of

SMOKE = ("--configfile", "config/smoke.yaml")
TARGET = "results/doe/half_life.tsv"


def test_the_file_to_look_at_first_is_one_that_the_target_makes(project):
    """For every target of the thesis; those of a folder have files in it."""
    done = ask_snakemake(project, "--summary", "--", *endings())
    assert done.returncode == 0, done.stderr[-2000:]
    table = done.stdout[done.stdout.index("output_file\t") :]
    made = {row["output_file"] for row in csv.DictReader(io.StringIO(table), delimiter="\t")}
    for name, ending in endings().items():
        look = ending.look.format(results="results", mill="emax", contact="calibrated", given="")
        assert look in made or any(file.startswith(f"{look}/") for file in made), name


def test_a_run_ends_with_what_was_made_and_a_failed_one_with_the_log_and_what_to_try(project):
    script = project / "scripts/tabulate_experiments.py"
    text = script.read_text()
    fault = 'from millprint.config.errors import ConfigError\n        raise ConfigError("screening.tsv: no balls")\n'
    faulty = text.replace("        for line in write_design(", f"        {fault}        for line in write_design(")
    assert faulty != text
    script.write_text(faulty)
    failed = run_snakemake(project, *SMOKE, "--", TARGET)
    assert failed.returncode == 1
    assert "failed: 1 job; " in failed.stdout
    # A job of several files is named by its first.
    assert "  tabulate_experiments for results/doe/design.tsv\n" in failed.stdout
    assert "    log: results/logs/doe/tabulate_experiments.log: screening.tsv: no balls\n" in failed.stdout
    assert "try:    fix what the log says" in failed.stdout
    assert "made:  " not in failed.stdout
    script.write_text(text)
    done = run_snakemake(project, *SMOKE, "--", TARGET)
    assert done.returncode == 0, done.stdout[-4000:]
    # Snakemake's timers of a minute do not hold it.
    assert time.time() - (project / TARGET).stat().st_mtime < 30
    assert f"made:  {TARGET}\n" in done.stdout
    # A line for each job, without lists of files.
    assert "Reason" not in done.stdout and "MD5" not in done.stdout and "  1 of 1 jobs are done\n" in done.stdout
    assert "failed:" not in done.stdout
    assert "\r" not in done.stdout
    # Where nothing was made, nothing is said about it.
    assert "made:  " not in run_snakemake(project, *SMOKE, "--", TARGET).stdout


def test_a_dry_run_of_the_thesis_is_short_and_an_unknown_target_is_one_line(project):
    said = ask_snakemake(project, "--dry-run", "--cores", "2").stdout
    assert said.count("\n") < 200 and "Simulating " in said and "results/dem/kernels.json" not in said
    unknown = run_snakemake(project, "fingerprnt")
    assert unknown.returncode == 1
    assert error_lines(unknown.stdout) == ["error: fingerprnt: unknown target; did you mean fingerprint?"]


def test_a_plan_says_what_a_run_would_do_and_changes_nothing(project):
    before = state_of(project)
    command = [sys.executable, "-m", "millprint.cli", "plan", "--cores", "2", *SMOKE, "--", "chapter3", TARGET]
    done = subprocess.run(command, cwd=project, env=active_environment(), capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    # Snakemake's own table of the jobs, once, and the estimate.
    assert done.stdout.count("Job stats:") + done.stderr.count("Job stats:") == 1
    for words in (
        "\nsimulations  ",
        "\ntime         about ",
        "\nmemory       up to ",
        "\ndisk         about ",
        "\nwall         emax: ",
    ):
        assert words in f"\n{done.stdout}"
    assert state_of(project) == before


def test_a_plan_counts_what_each_simulation_takes(tmp_path):
    """Of the same jobs, with windows of 10 and of 300 turns; the mill stands before or after an option."""
    said = []
    for turns, words in ((10, ("mine.yaml", "--cores", "1")), (300, ("--cores", "1", "mine.yaml"))):
        sweep = {"speeds_rpm": [400], "ball_diameters_mm": [5], "fill_ratios": [0.2, 0.3, 0.4], "window_turns": turns}
        run = {"mill": "planetary", "contacts": ["steel"], "sweep": sweep}
        (tmp_path / "mine.yaml").write_text(yaml.safe_dump(run))
        command = [sys.executable, "-m", "millprint.cli", "plan", *words]
        done = subprocess.run(command, cwd=tmp_path, env=active_environment(), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr[-2000:]
        about, longest = re.search(r"time +about (.+) on 1 core; .*the longest job, (\w+),", done.stdout).groups()
        parts = re.findall(r"(\d+) (h|min|s)", about)
        said.append((sum(int(number) * {"h": 3600, "min": 60, "s": 1}[unit] for number, unit in parts), longest))
    (short_s, _), (long_s, longest) = said
    assert longest == "run_dem_case" and long_s > 5 * short_s
