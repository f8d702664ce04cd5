"""Each number of paper.md and README.md is that of a table of the project, written by a command."""

import re

import pytest
from tools.count_matches import EXAMPLE
from tools.run_tables import BLOCKS
from tools.store_verdicts import BLOCK, TEXTS, written

from tests.conftest import ROOT

WRITTEN = re.compile(r"<!-- example: python tools/count_matches.py -->.*?<!-- end -->", re.S)
NUMBER = r"(?<![\w.@-])\d[\d,]*(?:\.\d+)?(?![\w@])"


def text_of(document: str) -> str:
    """The text that people read: without blocks, the head of a paper, citations, code in a line and addresses.

    The example of a match is held by tests/unit/test_match_pages.py, its command too.
    """
    text = WRITTEN.sub(" ", BLOCK.sub(" ", (ROOT / document).read_text())).replace(EXAMPLE, " ")
    text = text.split("---", 2)[2] if text.startswith("---") else text
    for left_out in (r"\[@\w+\]|@\w+", r"(?<!`)`[^`\n]+`(?!`)", r"\]\([^)]*\)"):
        text = re.sub(left_out, " ", text)
    return " ".join(re.sub(r"Python \d\.\d+", " ", text).split())


def test_every_block_is_on_a_page_and_every_page_that_has_one_is_written():
    pages = [ROOT / "README.md", ROOT / "paper.md", *(ROOT / "docs").rglob("*.md")]
    found = {str(page.relative_to(ROOT)): {one["name"] for one in BLOCK.finditer(page.read_text())} for page in pages}
    assert {page for page, names in found.items() if names} <= set(TEXTS)
    assert set(BLOCKS) <= set().union(*found.values())


@pytest.mark.parametrize("document", TEXTS)
def test_a_text_says_what_the_stored_tables_have(document):
    assert (ROOT / document).read_text() == written(ROOT, document), "python tools/store_verdicts.py --texts"


@pytest.mark.parametrize("document", ["paper.md", "README.md"])
def test_no_number_is_typed_outside_of_what_the_command_writes(document):
    """Each is in a place that the command fills, so that a number that no table has is found."""
    lines = (ROOT / "config/data/stated_numbers.tsv").read_text().splitlines()
    texts = [line.split("\t")[1] for line in lines if line.startswith(f"{document}\t")]
    text = text_of(document)
    covered = {found.start(1) for one in texts for found in re.finditer(_pattern(one), text)}
    places = [found for found in re.finditer(NUMBER, text) if found.start() not in covered]
    assert not [text[max(0, one.start() - 30) : one.end() + 20] for one in places]


def _pattern(text: str) -> str:
    before, after = map(re.escape, text.split("{}"))
    return f"{before}-?({NUMBER}){after}"
