"""Version, licence and authors agree in all files that state them."""

import re
import runpy
import tomllib
from unittest import mock

import pytest
import yaml

from tests.conftest import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_citation_and_licence_agree_with_the_project():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0" and {"message", "title", "authors"} <= set(citation)
    assert (citation["title"], citation["version"]) == (PROJECT["name"], PROJECT["version"])
    latest = re.search(r"^## (\S+) \((\S+)\)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert latest and latest.groups() == (PROJECT["version"], str(citation["date-released"]))
    assert f'tag="v{PROJECT["version"]}"' in (ROOT / "docs/how_to/module.md").read_text()
    assert citation["license"] == PROJECT["license"] == "MIT"
    authors = [author["name"] for author in PROJECT["authors"]]
    assert [author["name"] for author in citation["authors"]] == authors
    assert f"{authors[0]}\n" in (ROOT / "LICENSE").read_text()


@pytest.mark.parametrize(("repository", "source"), [("own/er", "https://github.com/own/er"), ("", None)])
def test_a_release_has_the_addresses_of_the_repository_that_publishes_it(monkeypatch, repository, source):
    monkeypatch.setenv("GITHUB_SERVER_URL", "https://github.com")
    monkeypatch.setenv("GITHUB_REPOSITORY", repository)
    with mock.patch("setuptools.setup") as setup:
        runpy.run_path(str(ROOT / "setup.py"))
    assert setup.call_args.kwargs["project_urls"].get("Source") == source and "urls" in PROJECT["dynamic"]


PAPER = (ROOT / "paper.md").read_text()


def test_the_paper_cites_what_its_bibliography_has_and_nothing_else():
    entries = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper.bib").read_text(), re.MULTILINE)
    assert len(set(entries)) == len(entries)
    assert set(re.findall(r"@(\w+)", PAPER.split("---", 2)[2])) == set(entries)
