"""Tables as pages, the summary of the claims, and the table of runtimes."""

import re
from types import SimpleNamespace

import pandas as pd
from docutils.core import publish_parts
from jinja2 import Environment

from millprint.run.files import write_table
from millprint.run.html_pages import embed_json
from millprint.thesis.claims.evidence import Finding, source_in
from millprint.thesis.claims.tabulate import INTERVAL_PARTS, JAR_COLUMNS
from millprint.thesis.report.claims_page import (
    claims_page,
    front_text,
    largest_deviations,
)
from millprint.thesis.report.table_pages import Section, tables_page
from tests.conftest import ROOT


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


def test_the_first_page_of_the_report_says_which_conclusions_stand(tmp_path):
    """As Snakemake renders it, and without the claims of a run that has none."""
    rows = [("chapter 2", "Speed |decides|.", "differs", "2 of 3 claims differ", 3)]
    rows += [("chapter 2", "Time does.", "agrees", "of 2 claims 2 agree", 2)]
    rows += [("appendix A", "All is needed.", "open", "not run", 0)]
    conclusions = pd.DataFrame(rows, columns=["chapter", "conclusion", "it_holds", "reason", "claims"])
    (tmp_path / "report").mkdir()
    falls, first = ["Chapter 2: not so: 5_x is 2 for 1_."], {"appendix A": "None |beats|."}
    (tmp_path / "report/conclusions.rst").write_text(front_text(conclusions, falls, first))
    text = (ROOT / "workflow/report/workflow.rst").read_text()
    config = SimpleNamespace(config={"name": "test", "mill": "emax", "results": str(tmp_path)})

    def page(*categories: str) -> str:
        named = [SimpleNamespace(name=name) for name in categories]
        template = Environment(trim_blocks=True, lstrip_blocks=True).from_string(text)
        return publish_parts(template.render(snakemake=config, categories=named, files={}), writer="html")["body"]

    shown = re.sub("<.*?>", "", page("Claims", "Explorer"))
    assert "Chapter 2, 2 conclusions; hold: 1, do not hold: 1." in shown
    assert "Appendix A: None |beats|. 1 conclusions; are open: 1." in shown
    assert "Hold: Time does (of 2 claims 2 agree)." in shown and "Do not hold: Speed |decides| (2 of 3" in shown
    assert "5_x is 2 for 1_." in shown and "problem" not in shown.lower()
    assert "2 conclusions" not in re.sub("<.*?>", "", page("Explorer"))


def test_a_claim_links_to_its_source_and_text_stays_text(tmp_path):
    """To the page that shows the table, to the file if no page does, and to nothing that the run did not write."""
    write_table(pd.DataFrame({"term": ["A"]}), tmp_path / "doe/anova_printed.tsv")
    write_table(pd.DataFrame({"F": [1.0]}), tmp_path / "doe/pareto.tsv")
    table = claims(("2.a", "0", "agrees"), ("2.b", "50", "differs")).assign(quantity="<i>q</i>")
    table = table.assign(
        reproduced="1.5", lower=["1.4", ""], upper=["1.6", ""], interval_from=["trainings", ""], repeats=["5", ""]
    ).assign(jars_lower=["1.2", ""], jars_upper=["2.1", ""], jars_meeting=["3 of 8", ""])
    paths = ("doe/anova_printed.tsv", "doe/pareto.tsv", "doe/wear.tsv")
    sources = tuple(source_in(path, "p_value", "term == 'A'") for path in paths)
    text = claims_page("test", table, {"2.a": Finding(1, sources=sources), "2.b": Finding(2)}, tmp_path)
    assert re.findall('<a href="(.*?)">(.*?)</a>', text) == [
        ("tables_2.html#analysis-of-variance-as-in-table-2-5", "doe/anova_printed.tsv"),
        ("../doe/pareto.tsv", "doe/pareto.tsv"),
    ]
    assert "doe/wear.tsv [term == &#39;A&#39;] p_value (rule tabulate_experiments, millprint.thesis.doe" in text
    assert "&lt;i&gt;q&lt;/i&gt;" in text and "<i>q" not in text
    assert "5 of trainings); other jars 1.2 to 2.1, 3 of 8" in text and text.count("other jars 1") == 1
    assert "1.5 (1.4 to 1.6, 5 of trainings)" in text and "1.5 (" not in text.replace("1.5 (1.4 to 1.6", "")
    assert "why<details><summary>source</summary>tolerance: 15%; from <a" in text
    assert "tolerance: 15%; from no file</details>" in text
