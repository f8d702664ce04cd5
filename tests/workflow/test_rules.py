"""Rules are written, not generated: their names, their messages and the graph depend on the configuration at most."""

import csv
import io
import re

import pytest

from tests.workflow.conftest import ROOT, ask_snakemake, copy_planetary, jobs_of

SMOKE = ("--configfile", "config/smoke.yaml")
# Files of targets that a run may have made before; none of them may decide what another run does.
MADE_BEFORE = (
    "results/surrogate/ablations.tsv",
    "results/fingerprint/fit_search.tsv",
    "results/dose/wear_coefficient.json",
    "results/mills/mixer/fingerprint.json",
)


def asked(*arguments: str) -> str:
    """What Snakemake prints in this project."""
    done = ask_snakemake(ROOT, *arguments)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout + done.stderr


@pytest.mark.parametrize("configuration", [(), SMOKE])
def test_every_simulation_is_a_job_of_one_rule_that_selectors_name(project, configuration):
    summary = ask_snakemake(project, *configuration, "--summary").stdout
    rows = csv.DictReader(io.StringIO(summary), delimiter="\t")
    runs = {row["output_file"]: row["rule"] for row in rows if re.fullmatch(r"results/dem/.*/run.h5", row["output_file"])}
    assert len(runs) > 30 and set(runs.values()) == {"run_dem_case"}
    plan = ask_snakemake(project, *configuration, "-n", "--until", "run_dem_case")
    assert jobs_of(plan.stdout + plan.stderr) == {"compile_kernels": 1, "run_dem_case": len(runs)}


def test_no_configuration_changes_the_names_of_rules():
    assert asked("--list-rules").splitlines()[-100:] == asked("--list-rules", *SMOKE).splitlines()[-100:]


def test_no_message_of_a_job_lists_files(project):
    for target in ("everything", "mills", "ablations", "fit", "uncertainty", "mill_wear"):
        plan = ask_snakemake(project, "-n", target)
        messages = re.findall(r"^Job \d+: (.*)$", plan.stdout + plan.stderr, re.MULTILINE)
        assert len(messages) == sum(jobs_of(plan.stdout + plan.stderr).values()), target
        assert max(map(len, messages)) <= 200, max(messages, key=len)


def test_what_lies_on_the_disk_does_not_change_the_plan(project):
    plans = []
    for _ in range(2):
        for targets in (["everything"], ["mills", "uncertainty"]):
            done = ask_snakemake(project, "-n", *targets)
            assert done.returncode == 0, done.stderr[-3000:]
            plans.append(jobs_of(done.stdout + done.stderr))
        for file in MADE_BEFORE:
            (project / file).parent.mkdir(parents=True, exist_ok=True)
            (project / file).write_text("{}\n")
    assert plans[:2] == plans[2:]


OPTIONS = ("--config", "fit={in_all: true}", "surrogate={ablations_in_all: true}", "mills={explored: [planetary]}")


def test_the_configuration_adds_the_search_the_ablations_and_further_mills_to_the_whole(project):
    done = ask_snakemake(project, "-n", *OPTIONS)
    jobs = jobs_of(done.stdout + done.stderr)
    assert jobs["fit_jar"] == jobs["measure_shape"] == jobs["tabulate_ablations"] == jobs["plot_ablations"] == 1
    assert jobs["describe_mill"] == 2
    without = ask_snakemake(project, "-n")
    assert not {"fit_jar", "measure_shape", "tabulate_ablations"} & jobs_of(without.stdout + without.stderr).keys()


MODULE = """
config = {{
    "mill": "mine",
    "contacts": ["calibrated"],
    "sweep": {{"speeds_rpm": [300, 500], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3]}},
    "results": "milling",
}}


module millprint:
    snakefile: {snakefile!r}
    config: config


use rule * from millprint as mill_*


use rule run_dem_case from millprint as mill_run_dem_case with:
    message:
        "Ours: {{wildcards.case}}"
"""


def test_a_module_overrides_every_simulation(tmp_path):
    (tmp_path / "config/mills").mkdir(parents=True)
    copy_planetary(tmp_path / "config/mills")
    (tmp_path / "Snakefile").write_text(MODULE.format(snakefile=str(ROOT / "workflow/Snakefile")))
    plan = ask_snakemake(tmp_path, "-n", "mill_fingerprint")
    assert plan.returncode == 0, plan.stderr[-3000:]
    text = plan.stdout + plan.stderr
    assert jobs_of(text)["mill_run_dem_case"] == len(re.findall(r"^Job \d+: Ours: ", text, re.MULTILINE)) == 6
