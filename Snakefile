"""millprint: the thesis, or somebody else's mill, from raw data to a verdict on every claim."""

import sys
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")

sys.path.insert(0, str(Path(workflow.basedir) / "scripts"))

from millprint.config.checks import load_workflow, stop_on_bad_input
from millprint.config.strict_yaml import read_yaml
from millprint.digest import library_digest
from millprint.fingerprint.preflight import has_chapters
from millprint.liveness import is_within_run
from millprint.machine import prepare_environment

prepare_environment()

with stop_on_bad_input():
    # Snakemake's own reader takes the last of two equal keys, and any number of aliases.
    read_yaml("config/config.yaml")


configfile: "config/config.yaml"


report: "workflow/report/workflow.rst"


CONFIG_FILES = [str(file) for file in (*workflow.configfiles, *workflow.overwrite_configfiles)]

with stop_on_bad_input():
    for file in CONFIG_FILES:
        read_yaml(file)
    CONFIG, MILLS, CONTACTS, CASES = load_workflow(config, CONFIG_FILES)
    CHAPTERS = has_chapters(CONFIG, CASES)
    # Jobs read this file too, and the Snakemake within one that builds the report; what holds before the first job need
    # not be checked in every one.
    if workflow.is_main_process and not is_within_run():
        from millprint.preflight import check_before_running

        check_before_running(CONFIG, MILLS, CONTACTS, CASES, CONFIG_FILES[-1])


include: "workflow/rules/faults.smk"
include: "workflow/rules/common.smk"
include: "workflow/rules/doe.smk"
include: "workflow/rules/dem.smk"
include: "workflow/rules/mills.smk"


# The chapters are about the mill of the sweeps; a run of another mill has its fingerprint.
if CHAPTERS:

    include: "workflow/rules/chapters.smk"


onstart:
    # Snakemake 9 looks at all waiting jobs once a second, and for every job that has ended once a second more: after 300
    # jobs that is a third of a core. It serves a limit of jobs begun a second, which one machine does not need.
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


localrules:
    all,


rule all:
    default_target: True
    input:
        [*STAGE_OUTPUTS, *rules.build_report.output] if CHAPTERS else FINGERPRINTED,
