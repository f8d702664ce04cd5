"""Tables as pages, the summary of the claims, and the table of runtimes."""

import re

import pandas as pd

from millprint.report.table_pages import Section, tables_page
from millprint.run.html_pages import embed_json
from millprint.thesis.claims.tabulate import INTERVAL_PARTS, JAR_COLUMNS
from millprint.thesis.report.claims_page import largest_deviations


def test_what_a_table_holds_cannot_become_markup():
    text = tables_page("A <b>", "P & Q", [Section("T", pd.DataFrame({"x<y": ["<script>alert(1)</script>"]}))])
    assert "<script>alert" not in text and "&lt;script&gt;alert" in text
    assert "x&lt;y" in text and "A &lt;b&gt;" in text and "P &amp; Q" in text
    assert 'aria-label="T"' in text and "http" not in re.sub("http-equiv", "", text)


def test_json_cannot_end_its_script():
    assert "</script>" not in embed_json({"name": "</script><b>"})


def claims(*rows) -> pd.DataFrame:
    columns = ["id", "locus", "quantity", "published", "unit", "reproduced", "deviation", "verdict", "explanation"]
    table = pd.DataFrame(
        [(name, "Table 1", "q", "1", "-", "2", deviation, verdict, "why") for name, deviation, verdict in rows],
        columns=columns,
    )
    return table.assign(
        nature="simulated",
        basis="stated",
        tolerance="15%",
        interval_verdict="",
        reason="",
        source="",
        **dict.fromkeys([*INTERVAL_PARTS, *JAR_COLUMNS], ""),
    )


def test_deviations_are_ranked_by_size_with_words_first():
    table = claims(("a", "12", "differs"), ("b", "-40", "differs"), ("c", "", "differs"), ("d", "90", "agrees"))
    assert largest_deviations(table)["id"].tolist() == ["c", "b", "a"]
    assert largest_deviations(table, 1)["id"].tolist() == ["c"]
