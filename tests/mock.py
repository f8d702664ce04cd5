"""A job's `snakemake` without a run, as energy-system workflows have it: to run or debug an adapter by hand.

    python -m tests.mock RULE NAME=VALUE ... --configfile config/smoke.yaml

runs the script of a rule in this process, with your breakpoints; NAME=VALUE are its wildcards, and the configuration is
that of the working folder if none is given. Its inputs must be there. In Python, `mock_snakemake("describe_mill",
mill="spex")` gives the object with input, output, params, wildcards, threads, resources, log and config of that job.
"""

import runpy
import sys
from collections.abc import Sequence
from pathlib import Path

# First, as the other modules import each other.
from snakemake.api import (
    ConfigSettings,
    DAGSettings,
    DeploymentSettings,
    GroupSettings,
    OutputSettings,
    ResourceSettings,
    StorageSettings,
    Workflow,
    WorkflowSettings,
)
from snakemake.dag import DAG
from snakemake.jobs import Job
from snakemake.logging import LoggerManager, logger
from snakemake.script import Snakemake

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "scripts"


def read_workflow(config_files: Sequence[str | Path] = (), config: dict | None = None) -> Workflow:
    """The workflow as Snakemake reads it, in the working folder. config: as of --config."""
    workflow = Workflow(
        config_settings=ConfigSettings(configfiles=[Path(file) for file in config_files], config=config or {}),
        resource_settings=ResourceSettings(cores=1),
        workflow_settings=WorkflowSettings(),
        logger_manager=LoggerManager(logger, OutputSettings()),
        deployment_settings=DeploymentSettings(),
        storage_settings=StorageSettings(),
        output_settings=OutputSettings(),
        dag_settings=DAGSettings(),
        group_settings=GroupSettings(),
        storage_provider_settings={},
    )
    workflow.include(ROOT / "workflow/Snakefile", overwrite_default_target=True)
    return workflow


def mock_snakemake(
    rule: str, config_files: Sequence[str | Path] = (), config: dict | None = None, **wildcards: str
) -> Snakemake:
    """The object `snakemake` that the script of a rule gets in a job with these wildcards."""
    workflow = read_workflow(config_files, config)
    own = workflow.get_rule(rule)
    job = Job(own, DAG(workflow, rules=[own]), wildcards)
    given, script = (job.input, job.output, job.params, job.wildcards), SCRIPTS / Path(own.script).name
    return Snakemake(*given, 1, job.resources, job.log, workflow.config, rule, None, str(script))


def run_script(snakemake: Snakemake) -> None:
    """Run the script of a mocked job, as Snakemake does."""
    runpy.run_path(snakemake.scriptdir, {"snakemake": snakemake})


def main(arguments: Sequence[str]) -> None:
    """RULE NAME=VALUE ..., then, after `--configfile`, configuration files."""
    words, _, files = " ".join(arguments).partition(" --configfile ")
    rule, *named = words.split()
    run_script(mock_snakemake(rule, files.split(), **dict(word.split("=", 1) for word in named)))


if __name__ == "__main__":
    main(sys.argv[1:])
