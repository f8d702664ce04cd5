"""The files of a finished run, for a crate that is written without Snakemake."""

import re
from collections.abc import Mapping
from pathlib import Path

from millprint.config.checks import CONTACT_FOLDER, MILL_FOLDER, load_workflow
from millprint.config.errors import ConfigError
from millprint.config.sources import Sources
from millprint.provenance.crate_files import AGAIN, CONFIGURATION, read_configuration
from millprint.provenance.inside import CRATE
from millprint.provenance.lineage import Job

PROJECT = Path(__file__).parents[3]
# The last line of a job's log, from millprint.run.job.
DONE = re.compile(r": done in [\d.]+ s$", re.MULTILINE)
# The log of a job with several simulations has a line for each, and each also has a separate log.
ALL_DONE = re.compile(r"(done: .+\n)+")


def check_finished(folder: Path) -> None:
    """Raise ConfigError with a line for each job without a last line: it failed, was killed or is still running."""
    logs = sorted((folder / "logs").rglob("*.log"))
    open_ends = [path for path in logs if not _is_finished(path.read_text(errors="replace"))]
    if open_ends:
        raise ConfigError("\n".join(f"{path}: this job did not finish; {AGAIN} until it has" for path in open_ends))


def _is_finished(text: str) -> bool:
    return bool(DONE.search(text) or ALL_DONE.fullmatch(text))


def targets_of(folder: Path, jobs: Mapping[str, Job], own_rule: str) -> list[str]:
    """Every file in a folder of results that a job made, except the files of `own_rule`."""
    made = [name for name, job in jobs.items() if job.rule != own_rule and Path(name).is_relative_to(folder)]
    return sorted(name for name in made if Path(name).is_file())


def recipe_of(folder: Path) -> tuple[list[str], list[str]]:
    """The files of mills and contact sets that a run names, and the files of the workflow, the main one first."""
    _, mills, contacts, _ = load_workflow(read_configuration(folder), [str(folder / CONFIGURATION)], Sources(_shipped))
    find = Sources(_shipped).find
    sources = [find(f"{MILL_FOLDER}/{name}.yaml") for name in mills]
    sources += [find(f"{CONTACT_FOLDER}/{name}.yaml") for name in contacts]
    workflow = Path("workflow") if Path("workflow/Snakefile").is_file() else PROJECT / "workflow"
    if not (workflow / "Snakefile").is_file():
        raise ConfigError(f"{folder / CRATE}: no workflow/Snakefile here; use the target `crate` of Snakemake instead")
    return sources, [str(workflow / "Snakefile"), *sorted(map(str, workflow.glob("rules/*.smk")))]


def _shipped(path: str) -> str | None:
    """The location of a file of this checkout; None if it has no such file."""
    return str(PROJECT / path) if (PROJECT / path).exists() else None
