"""Where the project's own files and its library are: beside this file, or in Snakemake's cache of a remote repository."""

from os import PathLike

# The folder of a local checkout; None where the workflow is a module from a remote repository.
PROJECT = Path(workflow.current_basedir).parents[1] if isinstance(workflow.current_basedir, PathLike) else None

ENVIRONMENT = workflow.current_basedir.join("../../envs/millprint.yaml")
RULES_OF_OTHERS = {each.name for each in workflow.rules}


def shipped(path: str) -> str | None:
    """Where a file of this project lies, from its path in the project; None where there is no such file."""
    if PROJECT is not None:
        return str(PROJECT / path) if (PROJECT / path).exists() else None
    try:
        return workflow.source_path(f"../../{path}")
    except (WorkflowError, OSError):
        return None


if PROJECT is not None:
    # The library beside this file comes before any that is installed.
    sys.path.insert(0, str(PROJECT / "scripts"))

try:
    from millprint.config.checks import load_workflow, stop_on_bad_input
except ModuleNotFoundError as error:
    raise WorkflowError(
        f"Python has no module {error.name}: install pydantic, and millprint where this workflow is remote "
        "(pip install git+URL), beside Snakemake; or use --sdm conda"
    ) from None

from millprint.config.sources import Sources
from millprint.config.strict_yaml import read_yaml
from millprint.errors import ConfigError
from millprint.input_check import check_once
from millprint.liveness import announce, end_with_run, hold, outlive_run
from millprint.machine import prepare_environment
from millprint.records import report_damaged

prepare_environment()
# Jobs end when the run that started them has ended, for Snakemake leaves them behind when it is killed; jobs of a
# cluster's queue outlive it. Only the environment is changed: to read this file must leave the disk as it is.
if workflow.remote_exec:
    outlive_run()
else:
    end_with_run()
    if workflow.is_main_process:
        announce()
