"""The pages of docs/: they build without a warning, every link leads somewhere, and no page needs a network."""

import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import urlparse

import pytest

from tests.browser import PHONE, needs_browser
from tests.conftest import ROOT
from tests.workflow.conftest import active_environment

# The options are those of `make docs`.
OPTIONS = re.search(r"sphinx-build (.*) docs docs/_build$", (ROOT / "Makefile").read_text(), re.MULTILINE)[1].split()
# Where a page gets something from, apart from links that a reader follows.
FETCHED, ADDRESS = re.compile(r"<(?:script|img|link|source|iframe)\b[^>]*>"), re.compile(r"\b(?:src|href)=\"([^\"]+)\"")


def build(source: Path, target: Path) -> subprocess.CompletedProcess:
    """Build the pages of `source` as `make docs` does."""
    command = [sys.executable, "-m", "sphinx", *OPTIONS, str(source), str(target)]
    return subprocess.run(command, cwd=ROOT, env=active_environment(), capture_output=True, text=True, timeout=900)


@pytest.fixture(scope="session")
def site(tmp_path_factory) -> Path:
    """The built pages."""
    folder = tmp_path_factory.mktemp("docs")
    done = build(ROOT / "docs", folder)
    assert done.returncode == 0, done.stderr[-4000:]
    return folder


def is_outside(address: str) -> bool:
    """Whether an address names another site."""
    return bool(urlparse(address).scheme or urlparse(address).netloc)


def test_no_page_fetches_anything_from_another_site(site):
    """Dead links within the pages stop the build."""
    text = "".join(page.read_text(encoding="utf-8") for page in sorted(site.rglob("*.html")))
    fetched = {address for tag in FETCHED.findall(text) for address in ADDRESS.findall(tag)}
    assert len(fetched) > 20
    assert not [each for each in fetched if is_outside(each) and not each.startswith("data:")]
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(@import|url\()\s*[\"']?(https?:)?//", sheet.read_text(encoding="utf-8")), sheet


def test_links_of_the_repository_lead_somewhere():
    """In README.md and the other pages that are read in the repository itself."""
    for name in ("README.md", "CONTRIBUTING.md", "config/README.md", "workflow/outputs.md"):
        text = (ROOT / name).read_text()
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            path, _, anchor = link.partition("#")
            if is_outside(link):
                continue
            target = (ROOT / name).parent / path if path else ROOT / name
            assert target.exists(), f"{name}: {link}"
            if anchor:
                headings = re.findall(r"^#+ (.*)$", target.read_text(), re.MULTILINE)
                slugs = {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}
                assert anchor in slugs, f"{name}: {link}"


FAULTS = {
    "[keys](../config/no_such_file.md)": "no such file of the project",
    "[hour](no_such_page.md)": "cross-reference target not found",
    "[below](#no-such-heading)": "no-such-heading",
    "$\\nosuchcommand{x}$": "unknown command in the equation",
    "$\\frac{1}{$": "no equation",
}


def test_faults_of_a_page_stop_the_build(tmp_path):
    pages = tmp_path / "docs"
    pages.mkdir()
    for name in ("conf.py", "extensions", "static"):
        (pages / name).symlink_to(ROOT / "docs" / name)
    (pages / "index.md").write_text("# Faults\n\n" + "\n\n".join(FAULTS))
    done = build(pages, tmp_path / "built")
    assert done.returncode != 0
    for fault, message in FAULTS.items():
        assert message in done.stderr, f"{fault}: {done.stderr}"


def test_equations_are_mathml(site):
    text = (site / "why/contact.html").read_text()
    assert "<mfrac>" in text and 'display="inline"' in text and 'display="block"' in text
    assert not re.search(r"<script[^>]*mathjax", text, re.IGNORECASE)


@needs_browser
@pytest.mark.parametrize("name", ["index", "first_hour", "how_to/card"])
def test_page_is_accessible_and_needs_no_network(site, browser, name):
    with browser.page() as page:
        page.open(site / f"{name}.html")
        assert page.accessibility_faults() == []
        page.resize(PHONE, 800)
        assert page.measure()["beyond"] <= 0
        assert page.errors == [] and page.outside_requests() == []
