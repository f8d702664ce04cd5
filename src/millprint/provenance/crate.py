"""A Workflow Run RO-Crate of a run: inputs and outputs, software, people, times and licence.

The format is RO-Crate 1.1 (https://w3id.org/ro/crate/1.1) with the profile Workflow Run Crate 0.5
(https://w3id.org/ro/wfrun/workflow/0.5). The run is one action: its objects are the inputs and the configuration, its
results the files that jobs made on the way to the targets. The crate does not depend on when or where it is written.

Collects the records of a run, with or without Snakemake, and writes its crate next to its results.
"""

import mimetypes
import platform
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import metadata
from pathlib import Path, PurePosixPath
from typing import Any

import yaml
from rocrate.model.computationalworkflow import ComputationalWorkflow
from rocrate.model.contextentity import ContextEntity
from rocrate.model.dataset import Dataset
from rocrate.model.entity import Entity
from rocrate.model.file import File
from rocrate.rocrate import ROCrate

from millprint.card.card_files import CITATION
from millprint.config.checks import load_workflow
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES as INCLUDED
from millprint.config.load import CONTACT_FOLDER, MILL_FOLDER
from millprint.config.workflow import ProvenanceConfig
from millprint.provenance.lineage import CRATE, SOURCES, UNCHECKED, Job, Lineage, is_described, places, recorded, trace
from millprint.run.digest import digest
from millprint.run.files import whole_file, write_json
from millprint.run.job import progress
from millprint.run.machine import provenance

# The software's licence if neither CITATION.cff nor an installed package has it.
LICENCE = "MIT"


def read_citation() -> dict[str, Any]:
    """CITATION.cff of a checkout; for an installed library without it, the same keys from the metadata."""
    if CITATION.is_file():
        return yaml.safe_load(CITATION.read_text())
    own = metadata("millprint")
    return {
        "title": own["Name"],
        "version": own["Version"],
        "license": own["License-Expression"] or LICENCE,
        "abstract": own["Summary"] or "",
        "authors": [{"name": name.strip()} for name in (own["Author"] or "").split(",") if name.strip()],
    }


def author(entry: dict[str, str]) -> dict[str, Any]:
    """The entity of an author in CITATION.cff: a person with a family name, or a group without one."""
    if "family-names" in entry:
        name = " ".join(filter(None, [entry.get("given-names"), entry["family-names"]]))
        return person(name, entry.get("orcid", "").rpartition("/")[2], entry.get("affiliation", ""))
    return {"@id": _local("group", entry["name"]), "@type": "Organization", "name": entry["name"]}


def agent(settings: ProvenanceConfig) -> dict[str, Any] | None:
    """The entity of the person who ran the workflow; None if the configuration names nobody."""
    return person(settings.agent, settings.orcid, settings.affiliation) if settings.agent else None


def person(name: str, orcid: str, affiliation: str) -> dict[str, Any]:
    """The entity of a person, identified by an ORCID if there is one."""
    found = {"@id": f"https://orcid.org/{orcid}" if orcid else _local("person", name), "@type": "Person", "name": name}
    return {**found, "affiliation": affiliation} if affiliation else found


def licence(name: str) -> dict[str, Any]:
    """The entity of a licence, from its SPDX name or its address."""
    address = name if name.startswith("http") else f"https://spdx.org/licenses/{name}"
    words = f"Licence {name}: terms at {address}"
    return {"@id": address, "@type": "CreativeWork", "name": name, "description": words, "url": {"@id": address}}


def _local(kind: str, name: str) -> str:
    """An identifier inside the crate."""
    return f"#{kind}/{re.sub(r'[^A-Za-z0-9]+', '-', name).strip('-').lower()}"


PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": ("Process Run Crate", "0.5"),
    "https://w3id.org/ro/wfrun/workflow/0.5": ("Workflow Run Crate", "0.5"),
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": ("Workflow RO-Crate", "1.0"),
}
# The context of RO-Crate 1.1 does not define digests; this is the profile's term.
TERMS = {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}
WORKFLOW_TYPE = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
PARAMETER_TYPE = "https://bioschemas.org/profiles/FormalParameter/1.0-RELEASE"
COMPLETED = "http://schema.org/CompletedActionStatus"
# Media types of names that Python does not know.
FORMATS = {
    ".bib": "application/x-bibtex",
    ".h5": "application/x-hdf5",
    ".pt": "application/zip",
    ".rst": "text/x-rst",
    ".smk": "text/x-python",
    ".stl": "model/stl",
    ".tex": "application/x-tex",
    ".tsv": "text/tab-separated-values",
    ".vtkhdf": "application/x-hdf5",
    ".yaml": "application/yaml",
}


@dataclass(frozen=True)
class KnownFile:
    """A file of the crate: its path there, its size [bytes] and its SHA-256 digest."""

    path: str
    size: int
    sha256: str


@dataclass(frozen=True)
class Run:
    """What a crate describes of a run.

    config: the merged configuration; lineage: the jobs; results, others: files that the run made, and files that other
    targets left; inputs: files that it read, by their path in the project; snakefiles: the files of the workflow, the
    main one first; configuration: the file with the merged configuration; citation: the content of CITATION.cff;
    versions: of Python and packages by name; commit, system: of the software and the machine.
    """

    config: Mapping[str, Any]
    lineage: Lineage
    results: tuple[KnownFile, ...]
    others: tuple[KnownFile, ...]
    inputs: Mapping[str, KnownFile]
    snakefiles: tuple[KnownFile, ...]
    configuration: str
    citation: Mapping[str, Any]
    versions: Mapping[str, str]
    commit: str
    system: str


def crate_of(run: Run) -> dict[str, Any]:
    """The content of ro-crate-metadata.json."""
    crate = ROCrate(version="1.1")
    crate.metadata.extra_terms.update(TERMS)
    workflow = _add_workflow(crate, run)
    files = {file.path: _add_file(crate, file) for file in [*run.results, *run.inputs.values()]}
    for file in run.others:
        _add_file(crate, file)["description"] = "Made by another target, or by an earlier run"
    for folder, words in UNCHECKED.items():
        crate.add(Dataset(crate, dest_path=f"{folder}/", properties={"name": folder, "description": words}))
    inputs = [_add_input(crate, run, path, files[file.path]) for path, file in sorted(run.inputs.items())]
    configured = _parameter(crate, "configuration", "File", files[run.configuration])
    values = [_add_value(crate, key, value) for key, value in _plain_values(run.config)]
    workflow["input"] = [configured, *(one["exampleOfWork"] for one in [*inputs, *values] if "exampleOfWork" in one)]
    person = agent(ProvenanceConfig(**run.config.get("provenance", {})))
    action = _add(
        crate,
        {
            "@id": "#run",
            "@type": "CreateAction",
            "name": f"Run {run.config['name']} of {run.citation['title']}",
            "description": f"Snakemake made {len(run.results)} files of the results for mill {run.config['mill']}; "
            f"{run.system}. Times are the begin of the first job and the end of the last one.",
            "startTime": run.lineage.begin.isoformat(),
            "endTime": run.lineage.end.isoformat(),
            "actionStatus": COMPLETED,
        },
    )
    action["instrument"] = workflow
    action["object"] = [files[run.configuration], *inputs, *values]
    action["result"] = [files[file.path] for file in run.results if file.path != run.configuration]
    if person:
        action["agent"] = _add(crate, person)
    _describe_root(crate, run, action)
    return crate.metadata.generate()


def _describe_root(crate: ROCrate, run: Run, action: Entity) -> None:
    """Name, description, date, licence, authors and profiles of the folder."""
    root = crate.root_dataset
    given = run.config.get("provenance", {}).get("licence", "")
    root["name"] = f"Results of the run {run.config['name']} of {run.citation['title']}"
    root["description"] = (
        f"Files of the run {run.config['name']}: mill {run.config['mill']}, contact sets "
        f"{', '.join(run.config['contacts'])}. Copies of its inputs are in crate/."
    )
    root["datePublished"] = run.lineage.end.date().isoformat()
    root["license"] = _add(crate, licence(given or run.citation["license"]))
    root["author"] = action.get("agent") or _authors(crate, run)
    root["mentions"] = action
    root["conformsTo"] = [
        _add(crate, {"@id": uri, "@type": "CreativeWork", "name": name, "version": version})
        for uri, (name, version) in PROFILES.items()
    ]


def _add_workflow(crate: ROCrate, run: Run) -> Entity:
    """The workflow with its language, licence, authors, version, and the software that it needs."""
    main, *included = run.snakefiles
    cited = run.citation
    workflow = crate.add_workflow(
        dest_path=main.path,
        main=True,
        lang="snakemake",
        lang_version=run.versions["snakemake"],
        cls=ComputationalWorkflow,
        properties={"name": cited["title"], **_details(main)},
    )
    workflow["conformsTo"] = _add(
        crate, {"@id": WORKFLOW_TYPE, "@type": "CreativeWork", "name": "ComputationalWorkflow"}
    )
    workflow["version"] = f"{cited['version']}, commit {run.commit}"
    workflow["description"] = " ".join(cited.get("abstract", "").split())
    workflow["license"] = _add(crate, licence(cited["license"]))
    workflow["author"] = _authors(crate, run)
    if "repository-code" in cited:
        workflow["codeRepository"] = workflow["url"] = cited["repository-code"]
    workflow["hasPart"] = [_add_file(crate, file) for file in included]
    workflow["softwareRequirements"] = [_add(crate, _software(name, version)) for name, version in run.versions.items()]
    return workflow


def _authors(crate: ROCrate, run: Run) -> Entity | list[Entity]:
    """The authors of the software; JSON-LD writes a single author without a list."""
    authors = [_add(crate, author(entry)) for entry in run.citation["authors"]]
    return authors[0] if len(authors) == 1 else authors


def _software(name: str, version: str) -> dict[str, Any]:
    """The entity of a package of the Python Package Index, or of Python."""
    # The part of a version after + names a local build, which is not in the index.
    page = f"https://pypi.org/project/{name}/{version.split('+')[0]}/"
    address = f"https://docs.python.org/release/{version}/" if name == "Python" else page
    return {"@id": address, "@type": "SoftwareApplication", "name": name, "softwareVersion": version, "url": address}


def _details(file: KnownFile) -> dict[str, Any]:
    """Name, size, digest and format of a file."""
    suffix = Path(file.path).suffix
    # Files without a suffix are Snakefiles.
    known = (
        FORMATS.get(suffix)
        or mimetypes.types_map.get(suffix)
        or ("application/octet-stream" if suffix else "text/plain")
    )
    return {"name": Path(file.path).name, "contentSize": str(file.size), "sha256": file.sha256, "encodingFormat": known}


def _add_file(crate: ROCrate, file: KnownFile) -> Entity:
    return crate.add(File(crate, dest_path=file.path, properties=_details(file)))


def _add(crate: ROCrate, entity: Mapping[str, Any]) -> Entity:
    """Add a contextual entity, unless the crate already has it."""
    found = crate.get(entity["@id"])
    return found or crate.add(ContextEntity(crate, entity["@id"], properties=dict(entity)))


def _parameter(crate: ROCrate, key: str, kind: str, example: Entity) -> Entity:
    """A parameter of the workflow, with the key of its configuration, and the value in this run."""
    entity = _add(
        crate,
        {
            "@id": f"#parameter/{key}",
            "@type": "FormalParameter",
            "name": key,
            "additionalType": kind,
            "conformsTo": {"@id": PARAMETER_TYPE},
        },
    )
    entity["workExample"] = example
    example["exampleOfWork"] = entity
    return entity


def _add_input(crate: ROCrate, run: Run, path: str, file: Entity) -> Entity:
    """Add an input, with the key of the configuration that names it, if there is one."""
    keys = [key for key, value in _flat(run.config) if value == path]
    if keys:
        _parameter(crate, keys[0], "File", file)
    return file


def _add_value(crate: ROCrate, key: str, value: str) -> Entity:
    """A value of the configuration."""
    words = {"@id": f"#value/{key}", "@type": "PropertyValue", "name": key, "value": value}
    entity = _add(crate, words)
    _parameter(crate, key, "Text", entity)
    return entity


def _plain_values(config: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The keys of the top level with a text or a list of texts. All others are in the file of the configuration."""
    texts = {key: [value] if isinstance(value, str) else value for key, value in config.items()}
    return [
        (key, ", ".join(value))
        for key, value in texts.items()
        if isinstance(value, list) and value and all(isinstance(item, str) for item in value)
    ]


def _flat(content: Any, place: str = "") -> Iterable[tuple[str, Any]]:
    """Dotted key and value of everything in a configuration that is not a mapping or a list."""
    pairs = content.items() if isinstance(content, Mapping) else enumerate(content)
    for key, value in pairs:
        dotted = f"{place}.{key}".lstrip(".")
        if isinstance(value, Mapping | list | tuple):
            yield from _flat(value, dotted)
        else:
            yield dotted, value


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
    _, mills, contacts, _ = load_workflow(read_configuration(folder), [str(folder / CONFIGURATION)], INCLUDED)
    sources = [INCLUDED.find(f"{MILL_FOLDER}/{name}.yaml") for name in mills]
    sources += [INCLUDED.find(f"{CONTACT_FOLDER}/{name}.yaml") for name in contacts]
    main = Path(INCLUDED.find("workflow/Snakefile"))
    return sources, [str(main), *sorted(map(str, main.parent.glob("rules/*.smk")))]
