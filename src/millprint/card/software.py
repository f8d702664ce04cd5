"""The software that computed a card: name, version, authors, and its citation."""

from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

import yaml

from millprint.card.card_model import Software
from millprint.run.machine import commit, package_versions

# Packages that a card's numbers depend on.
PACKAGES = ("numpy", "numba", "scipy", "pandas")
CITATION = Path(__file__).parents[3] / "CITATION.cff"


def citation() -> dict[str, str]:
    """Title, version and authors of this software, from CITATION.cff in a checkout, or from the installed package."""
    if CITATION.is_file():
        own = yaml.safe_load(CITATION.read_text())
        return {
            "title": own["title"],
            "version": str(own["version"]),
            "authors": " and ".join(author["name"] for author in own["authors"]),
        }
    try:
        own = metadata("millprint")
    except PackageNotFoundError:
        return {"title": "millprint", "version": "unknown", "authors": "millprint developers"}
    return {"title": own["Name"], "version": own["Version"], "authors": own["Author"]}


def software() -> Software:
    """Name, version and commit of this software, and the versions of the packages that its numbers depend on."""
    own, versions = citation(), package_versions()
    return Software(
        name=own["title"],
        version=own["version"],
        commit=commit(),
        packages={name: versions[name] for name in PACKAGES},
    )
