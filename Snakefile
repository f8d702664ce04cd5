"""millprint: the thesis, or somebody else's mill, from raw data to a verdict on every claim."""

import sys
from pathlib import Path

from snakemake.utils import min_version

min_version("9.0")

sys.path.insert(0, str(Path(workflow.basedir) / "scripts"))

from millprint.config.checks import load_workflow, stop_on_bad_input
from millprint.config.strict_yaml import read_yaml
from millprint.digest import library_digest
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
    # Jobs read this file too; what holds before the first job need not be checked in every one.
    if workflow.is_main_process:
        from millprint.preflight import check_before_running

        check_before_running(CONFIG, MILLS, CONTACTS, CASES, CONFIG_FILES[-1])


include: "workflow/rules/faults.smk"
include: "workflow/rules/common.smk"
include: "workflow/rules/doe.smk"
include: "workflow/rules/dem.smk"
include: "workflow/rules/convergence.smk"
include: "workflow/rules/view.smk"
include: "workflow/rules/calibration.smk"
include: "workflow/rules/fingerprint.smk"
include: "workflow/rules/partition.smk"
include: "workflow/rules/yields.smk"
include: "workflow/rules/surrogate.smk"


STAGE_OUTPUTS = [
    *DOE_OUTPUTS,
    *CONVERGENCE_OUTPUTS,
    *VIEW_OUTPUTS,
    *CALIBRATION_OUTPUTS,
    *FINGERPRINT_OUTPUTS,
    *PARTITION_OUTPUTS,
    *YIELD_OUTPUTS,
    *SURROGATE_OUTPUTS,
]


include: "workflow/rules/report.smk"


localrules:
    all,
    chapter2,
    chapter3,
    chapter4,
    chapter5,
    chapter6,


rule all:
    default_target: True
    input:
        STAGE_OUTPUTS,
        rules.build_report.output,


rule chapter2:
    input:
        DOE_OUTPUTS,


rule chapter3:
    input:
        CALIBRATION_OUTPUTS,
        FINGERPRINT_OUTPUTS,
        CONVERGENCE_OUTPUTS,
        VIEW_OUTPUTS,


rule chapter4:
    input:
        PARTITION_OUTPUTS,


rule chapter5:
    input:
        YIELD_OUTPUTS,


rule chapter6:
    input:
        SURROGATE_OUTPUTS,
