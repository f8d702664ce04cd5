"""Finds the files of this project and its library: in the local checkout, or in Snakemake's cache of a remote one."""

import shlex
from os import PathLike

# The folder of a local checkout; None if the workflow is a module from a remote repository.
PROJECT = Path(workflow.current_basedir).parents[1] if isinstance(workflow.current_basedir, PathLike) else None

# Snakemake writes sys.executable as it is into a line for the shell, but the path of this folder may have spaces. Inside
# another workflow it may have been quoted before.
PYTHON = sys.executable if Path(sys.executable).exists() else shlex.split(sys.executable)[0]
sys.executable = shlex.quote(PYTHON)

ENVIRONMENT = workflow.current_basedir.join("../../envs/millprint.yaml")
RULES_OF_OTHERS = list(workflow.rules)


def shipped(path: str) -> str | None:
    """The location of a file of this project, given its path in the project; None if it does not exist."""
    if PROJECT is not None:
        return str(PROJECT / path) if (PROJECT / path).exists() else None
    try:
        return workflow.source_path(f"../../{path}")
    except (WorkflowError, OSError):
        return None


if PROJECT is not None:
    # The library of this checkout takes precedence over an installed one.
    sys.path.insert(0, str(PROJECT / "src"))

try:
    from millprint.config.checks import CONFIG_FILE, base_of, load_workflow, stop_on_bad_input
except ModuleNotFoundError as error:
    raise WorkflowError(
        f"Python has no module {error.name}: in the environment of Snakemake, install pydantic and, for a remote "
        "workflow, millprint (pip install git+URL); or use --sdm conda"
    ) from None

from millprint.config.load import Sources, read_yaml
from millprint.config.identity import contact_identity, dem_identity, identity, mill_identity, shared_identity
from millprint.run.plan import OneLineAJob, failure_lines, given_run, stop_timers_at_the_end, success_lines
from millprint.config.errors import ConfigError
from millprint.cases import server
from millprint.checks.check_once import DryRunCheck, check_once
from millprint.config.workflow import check_jobs
from millprint.run.plan import OTHER_S, Job, check_disk
from millprint.run.machine import prepare_environment
from millprint.run.digest import program_digest, report_damaged, simulation_digest

SOURCES = Sources(shipped)

# Only environment variables are set here: reading this file must change nothing on disk.
prepare_environment()
