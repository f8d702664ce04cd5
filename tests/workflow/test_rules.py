"""Rules are written, not generated: only the configuration decides the graph, and it changes no name of a rule."""

import csv
import io
import re

from tests.workflow.conftest import ROOT, ask_snakemake, jobs_of

SMOKE = ("--configfile", "config/smoke.yaml")
TARGETS = ("all", "mills", "mill_wear", "ablations", "fit", "uncertainty")
# Files of targets that a run may have made before; none of them decides what another run does.
MADE_BEFORE = (
    "results/surrogate/ablations.tsv",
    "results/fingerprint/fit_search.tsv",
    "results/dose/wear_coefficient.json",
    "results/mills/mixer/fingerprint.json",
)
# What the configuration can add to a whole run.
ADDED = ("--config", "also=[fit, ablations]")


def asked(folder, *arguments: str) -> str:
    """What Snakemake prints in a folder; an error is a failure."""
    done = ask_snakemake(folder, *arguments)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout + done.stderr


def test_every_simulation_is_a_job_of_one_rule_that_selectors_name(project):
    rows = csv.DictReader(io.StringIO(ask_snakemake(project, *SMOKE, "--summary").stdout), delimiter="\t")
    runs = [row["rule"] for row in rows if re.fullmatch(r"results/dem/.*/run.h5", row["output_file"])]
    assert len(runs) > 20 and set(runs) == {"run_dem_case"}
    # So that a plan shows what a job would get.
    rules = project / "workflow/rules/dem.smk"
    text = rules.read_text()
    rules.write_text(text.replace('"Simulating {wildcards', '"{threads} threads, {resources.mem_mb} MB: {wildcards'))
    assert rules.read_text() != text
    given = ("--set-resources", "run_dem_case:mem_mb=4321", "--set-threads", "run_dem_case=3")
    plan = asked(project, *SMOKE, "-n", "--cores", "4", *given, "--until", "run_dem_case")
    assert jobs_of(plan) == {"compile_kernels": 1, "run_dem_case": len(runs)}
    assert len(re.findall(r"^ *Job \d+: 3 threads, 4321 MB: ", plan, re.MULTILINE)) == len(runs)


def test_what_lies_on_the_disk_changes_no_plan_and_no_message_lists_files(project):
    plan = asked(project, *SMOKE, "-n", *TARGETS)
    messages = re.findall(r"^ *Job \d+: (.*)$", plan, re.MULTILINE)
    assert len(messages) > 100 and max(map(len, messages)) <= 200, max(messages, key=len)
    for file in MADE_BEFORE:
        (project / file).parent.mkdir(parents=True, exist_ok=True)
        (project / file).write_text("{}\n")
    assert jobs_of(asked(project, *SMOKE, "-n", *TARGETS)) == jobs_of(plan)


def test_the_configuration_adds_the_search_and_the_ablations_to_the_whole():
    jobs = jobs_of(asked(ROOT, "-n", "--forceall", *ADDED))
    assert jobs["fit"] == jobs["measure_shape"] == jobs["ablations"] == 1
