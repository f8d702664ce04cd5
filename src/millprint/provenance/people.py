"""Who wrote the software and who ran it, and under which licences, as entities of an RO-Crate."""

import re
from importlib.metadata import PackageNotFoundError, metadata
from typing import Any

import yaml

from millprint.card.software import CITATION
from millprint.config.provenance import ProvenanceConfig

# The software's licence if neither CITATION.cff nor an installed package has it.
LICENCE = "MIT"


def read_citation() -> dict[str, Any]:
    """CITATION.cff of a checkout; for an installed library without it, the same keys from the metadata."""
    if CITATION.is_file():
        return yaml.safe_load(CITATION.read_text())
    try:
        own = metadata("millprint")
    except PackageNotFoundError:
        return {"title": "millprint", "version": "unknown", "license": LICENCE, "authors": []}
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
