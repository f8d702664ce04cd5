"""Each number of paper.md and README.md is that of a table of the project, or of a run that is named with it."""

import io
import re

import pandas as pd
import pytest

from millprint.thesis.claims.tolerances import agrees
from tests.conftest import ROOT


def read(path: str, text: tuple[str, ...] = ()) -> pd.DataFrame:
    """A table of the project, its comments left out."""
    lines = [line for line in (ROOT / path).read_text().splitlines() if not line.startswith("#")]
    return pd.read_csv(io.StringIO("\n".join(lines)), sep="\t", dtype=dict.fromkeys(text, str))


COLUMNS = ("document", "text", "source", "rows", "column", "value", "run")
STATED = read("config/data/stated_numbers.tsv", COLUMNS).fillna("")
NUMBER = r"(?<![\w.@-])\d[\d,]*(?:\.\d+)?(?![\w@])"


def text_of(document: str) -> str:
    """The text that people read: without the head of a paper, citations, code in a line and addresses."""
    text = (ROOT / document).read_text()
    text = text.split("---", 2)[2] if text.startswith("---") else text
    for left_out in (r"\[@\w+\]|@\w+", r"(?<!`)`[^`\n]+`(?!`)", r"\]\([^)]*\)"):
        text = re.sub(left_out, " ", text)
    # The name of a processor, and of its instructions.
    text = re.sub(r"Zen \d|AVX-\d+", " ", text)
    # The comments of a block of commands are sentences too.
    return " ".join(text.replace("\n# ", "\n").split())


def first_number(value: object) -> float:
    """The number in a cell such as 44.7, <=15% or facets (50)."""
    return float(re.search(r"-?\d+(?:\.\d+)?(?:e-?\d+)?", str(value))[0])


def found(row: pd.Series) -> float:
    if not row["source"]:
        return float(row["value"])
    table = read(row["source"])
    if row["rows"]:
        table = table.query(row["rows"], engine="python")
    return float(len(table)) if row["column"] == "count" else first_number(table[row["column"]].iloc[0])


@pytest.mark.parametrize("place", STATED.index)
def test_a_stated_number_is_that_of_its_table_or_run(place):
    row = STATED.loc[place]
    before, number, after = re.fullmatch(r"(.*)\{(.*)\}(.*)", row["text"]).groups()
    assert before + number + after in text_of(row["document"])
    assert agrees(number.replace(",", ""), "printed", found(row))
    assert bool(row["source"]) != bool(row["value"] and row["run"])


@pytest.mark.parametrize("document", ["paper.md", "README.md"])
def test_no_number_stands_without_a_source(document):
    text, covered = text_of(document), set()
    for row in STATED[STATED["document"] == document].itertuples():
        before, number, after = re.fullmatch(r"(.*)\{(.*)\}(.*)", row.text).groups()
        covered |= {one.start() + len(before) for one in re.finditer(re.escape(before + number + after), text)}
    lacking = [
        text[max(0, one.start() - 30) : one.end() + 20]
        for one in re.finditer(NUMBER, text)
        if one.start() not in covered
    ]
    assert not lacking


def test_the_page_of_the_claims_counts_them_by_nature():
    page, claims = (ROOT / "docs/why/claims.md").read_text(), read("config/data/claims.tsv")
    counted = {name: int(count) for name, count in re.findall(r"^\| `(\w+)` \| .* \| (\d+) \|$", page, re.M)}
    assert counted == claims["nature"].value_counts().to_dict()
    assert f"the {len(claims)} rows of" in page and f"{(claims['basis'] == 'derived').sum()} claims (`basis`" in page


def test_what_the_page_names_as_not_standing_is_what_the_stored_verdicts_say():
    """What deviates on every machine; arithmetic is the same on all and is not stored."""
    stored = read("config/data/verdicts_elsewhere.tsv", ("id", "verdict", "reason"))
    stored = stored[~stored["reason"].str.startswith("erratum")]
    own = stored[stored["run"] == "thesis"].groupby("id")["verdict"]
    everywhere = {name for name, verdicts in own if (verdicts == "differs").all()}
    claims = read("config/data/claims.tsv", ("id",))
    arithmetic = set(claims.loc[claims["nature"] == "arithmetic", "id"])
    page = (ROOT / "docs/why/claims.md").read_text()
    named = page.split("## What does not stand", 1)[1].split("\n## ", 1)[0]
    assert set(re.findall(r"`(\d\.[\w.]+)`", named)) - arithmetic == everywhere
