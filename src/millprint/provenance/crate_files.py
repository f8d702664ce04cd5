"""Collects the records of a run, with or without Snakemake, and writes its crate next to its results."""

import platform
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Any

import yaml

from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.sources import CONTACT_FOLDER, MILL_FOLDER, Sources
from millprint.provenance.crate import KnownFile, Run, crate_of, read_citation
from millprint.provenance.inside import CRATE, SOURCES, is_described, places, recorded
from millprint.provenance.lineage import Job, trace
from millprint.run.files import whole_file, write_json
from millprint.run.machine import provenance
from millprint.run.output_digests import digest
from millprint.run.progress import progress

CONFIGURATION = "report/run.yaml"
AGAIN = "run the same command again"
# Keys of `provenance()` that are not versions.
NO_VERSIONS = ("commit", "system")


def write_crate(
    results: str, targets: Sequence[str], sources: Sequence[str], snakefiles: Sequence[str], jobs: Mapping[str, Job]
) -> int:
    """Write RESULTS/ro-crate-metadata.json and copies of the inputs in RESULTS/crate; returns how many files it lists.

    targets: the requested files; sources: files of the configuration that are not an input of any job; snakefiles: the
    files of the workflow, the main one first; jobs: the jobs of all outputs, by path. Raises ConfigError, with a line
    for each fault, for an unfinished run and for a file that has changed since its job.
    """
    folder = Path(results)
    config = read_configuration(folder)
    lineage = trace(targets, jobs)
    lost = [name for name in lineage.sources if Path(name).is_relative_to(folder)]
    missing = [name for name in (*lineage.made, *lineage.sources, *sources) if not Path(name).exists()]
    if lost or missing:
        reasons = {**dict.fromkeys(lost, "no job has made it"), **dict.fromkeys(missing, "the file is missing")}
        raise ConfigError("\n".join(f"{name}: {what}; {AGAIN}" for name, what in reasons.items()))
    records = recorded(folder)
    beside = {name for name in records if Path(name).is_relative_to(folder) and Path(name).is_file()}
    own = [name for name in lineage.made if Path(name).is_relative_to(folder)]
    known = _digest_all(folder, sorted(beside.union(own)), records)
    copies = _copy({*lineage.sources, *sources, *snakefiles}, folder)
    about = provenance()
    versions = {"Python": platform.python_version(), **{key: about[key] for key in about if key not in NO_VERSIONS}}
    run = Run(
        config=config,
        lineage=lineage,
        results=tuple(known[name] for name in own if name in known),
        others=tuple(file for name, file in known.items() if name not in own),
        inputs={name: copies[name] for name in {*lineage.sources, *sources}},
        snakefiles=tuple(copies[name] for name in snakefiles),
        configuration=CONFIGURATION,
        citation=read_citation(),
        versions=versions,
        commit=about["commit"],
        system=about["system"],
    )
    write_json(crate_of(run), folder / CRATE)
    return len(known) + len(copies)


def read_configuration(folder: Path) -> dict[str, Any]:
    """The merged configuration of the run whose results are in a folder. Raises ConfigError if there is none."""
    path = folder / CONFIGURATION
    if not path.is_file():
        raise ConfigError(
            f"{folder}: no run has finished here: {CONFIGURATION} is missing; give the folder of its results"
        )
    return yaml.safe_load(path.read_text())


def _digest_all(folder: Path, names: Sequence[str], records: Mapping[str, str]) -> dict[str, KnownFile]:
    """Size and digest of the described files. Raises ConfigError for files whose content differs from the record."""
    found, faults = {}, []
    with progress(len(names), "digests", "file") as bar:
        for name in names:
            inside = PurePosixPath(Path(name).relative_to(folder).as_posix())
            if is_described(inside) and inside.parts[0] != SOURCES:
                found[name] = KnownFile(str(inside), Path(name).stat().st_size, digest(name))
                if records.get(name, found[name].sha256) != found[name].sha256:
                    faults.append(f"{name}: changed since its job wrote it; `make verify` says what to do")
            bar.update()
    if faults:
        raise ConfigError("\n".join(faults))
    return found


def _copy(sources: set[str], folder: Path) -> dict[str, KnownFile]:
    """Copy the sources into the crate, replacing an earlier crate's copies; returns each by its path."""
    shutil.rmtree(folder / SOURCES, ignore_errors=True)
    copies = {}
    for source, place in sorted(places(sources).items()):
        with whole_file(folder / place) as partial:
            shutil.copyfile(source, partial)
        copies[source] = KnownFile(place, (folder / place).stat().st_size, digest(folder / place))
    return copies


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
