"""Version, licence and authors agree in all files that state them."""

import re
import runpy
import tomllib
from unittest import mock

import pytest
import yaml
from tools import check_release

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


# A link of Markdown: an exclamation mark before that of a picture, and where it leads.
LINK = re.compile(r"(!?)\[[^\]]*\]\(([^)\s]+)\)")


@pytest.mark.parametrize("repository", ["own/er", ""])
def test_a_release_has_the_addresses_of_the_repository_that_publishes_it(monkeypatch, repository):
    """Also on its first page, which a registry shows without the files that it leads to."""
    for name, value in {"SERVER_URL": "https://github.com", "REPOSITORY": repository, "REF_NAME": "v1.2.3"}.items():
        monkeypatch.setenv(f"GITHUB_{name}", value)
    monkeypatch.chdir(ROOT)
    with mock.patch("setuptools.setup") as setup:
        runpy.run_path("setup.py")
    given, place = setup.call_args.kwargs, f"https://github.com/{repository}" if repository else None
    assert given["project_urls"].get("Source") == place and {"urls", "readme"} <= set(PROJECT["dynamic"])
    own, released = (LINK.findall(text) for text in ((ROOT / "README.md").read_text(), given["long_description"]))
    assert len(own) == len(released) > 10
    for (picture, path), (_, address) in zip(own, released, strict=True):
        if place is None or "://" in path:
            assert address == path
        else:
            assert re.fullmatch(rf"{place}/{'raw' if picture else '(raw|blob)'}/v1.2.3/{re.escape(path)}", address)


def test_a_tag_is_refused_where_a_place_has_another_version(tmp_path, monkeypatch):
    for name in ("pyproject.toml", "CITATION.cff", "CHANGELOG.md"):
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    text = (ROOT / "CHANGELOG.md").read_text()
    (tmp_path / "CHANGELOG.md").write_text(text[text.index(f"## {PROJECT['version']} ") :])
    monkeypatch.setattr(check_release, "ROOT", tmp_path)
    assert check_release.faults(f"v{PROJECT['version']}") == []
    assert len(check_release.faults("v99.0.0")) == 3
    (tmp_path / "CHANGELOG.md").write_text(f"# Changes\n\n## Unreleased\n\n{text}")
    (fault,) = check_release.faults(f"v{PROJECT['version']}")
    assert "CHANGELOG.md is Unreleased" in fault


PAPER = (ROOT / "paper.md").read_text()


def test_the_paper_cites_what_its_bibliography_has_and_nothing_else():
    entries = re.findall(r"^@\w+\{(\w+),", (ROOT / "paper.bib").read_text(), re.MULTILINE)
    assert len(set(entries)) == len(entries)
    assert set(re.findall(r"@(\w+)", PAPER.split("---", 2)[2])) == set(entries)
