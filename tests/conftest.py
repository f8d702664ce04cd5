"""Puts the library on the path, as the Snakefile does for the scripts."""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.browser import Browser, open_browser

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

# What the thesis prints, as text, by the id of the claim.
with open(ROOT / "config/data/claims.tsv") as file:
    PRINTED = {row["id"]: row["value"] for row in csv.DictReader(file, delimiter="\t")}


@pytest.fixture(scope="module")
def browser(tmp_path_factory) -> Iterator[Browser]:
    """A browser for all tests of a file, whose pages share nothing."""
    with open_browser(tmp_path_factory.mktemp("browser")) as browser:
        yield browser
