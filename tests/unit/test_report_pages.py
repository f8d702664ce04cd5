"""Tables as pages, the summary of the claims, and the table of runtimes."""

import re
from types import SimpleNamespace

import pandas as pd
import pytest
from docutils.core import publish_parts
from jinja2 import Environment

from millprint.run.files import write_table
from millprint.run.html_pages import embed_json
from millprint.run.machine import commit, provenance
from millprint.thesis.claims.evidence import Finding, source_in
from millprint.thesis.claims.tabulate import INTERVAL_PARTS, JAR_COLUMNS, read_claims, tabulate_claims
from millprint.thesis.report.claims_page import (
    claims_page,
    front_text,
    largest_deviations,
    sum_stages,
    tabulate_runtimes,
)
from millprint.thesis.report.table_pages import Section, tables_page
from tests.browser import DESKTOP, PHONE, needs_browser
from tests.conftest import ROOT


def cells(**columns):
    """The rows of a table of these columns."""
    return Section("A table", pd.DataFrame(columns)).rows


def test_numbers_are_rounded_for_the_eye_and_kept_for_sorting():
    ((cell,), _) = cells(power_W=[0.123456789, 2.0])
    assert (cell.text, cell.value) == ("0.1235", 0.123456789)


def test_a_column_read_as_text_keeps_its_digits_and_sorts_as_numbers():
    ((first,), (second,)) = cells(published=["0.30", "12"])
    assert (first.text, first.value, second.value) == ("0.30", 0.3, 12.0)


@pytest.mark.parametrize("values", [["0.30", "yes"], [True, False], ["0.30/0.045"]])
def test_a_column_with_a_word_is_text(values):
    assert not any(cell.number for (cell,) in cells(value=values))


def test_empty_cells_are_empty():
    assert [cell.text for (cell,) in cells(value=[float("nan"), 1.5])] == ["", "1.5"]
    assert [cell.text for (cell,) in cells(value=["", "word"])] == ["", "word"]
    assert [cell.text for (cell,) in cells(value=[None, "word"])] == ["", "word"]


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


@needs_browser
@pytest.mark.parametrize("width", [DESKTOP, PHONE])
def test_no_claim_is_wider_than_the_page_and_a_fold_has_its_source(tmp_path, browser, width):
    """Every claim of the thesis, each with an interval, both verdicts, an explanation and a source."""
    source = source_in("fingerprint/descriptors.tsv", "normal_energy_J", "mill == 'emax' and fill_ratio == 0.08")
    path = ROOT / "config/data/claims.tsv"
    findings = dict.fromkeys(read_claims(path)["id"], Finding(None, "of 24 revolutions", sources=(source,)))
    table = tabulate_claims(path, findings).assign(reproduced="0.00012345", deviation="-87.1", verdict="agrees")
    table = table.assign(lower="0.000112345", upper="0.000134567", interval_from="simulations", repeats="200")
    table = table.assign(interval_verdict="wider than the tolerance")
    (tmp_path / "claims.html").write_text(claims_page("test", table, findings, tmp_path))
    with browser.page(width, 1200) as page:
        page.open(tmp_path / "claims.html")
        spill = """
          const table = document.querySelector(".cards");
          return [table.scrollWidth - table.parentElement.clientWidth, table.querySelector("details").innerText];"""
        wider, closed = page.run(spill)
        assert wider <= 0 and closed == "source" and page.measure()["beyond"] <= 0
        assert page.measure()["smallest"] >= 10
        page.run('document.querySelectorAll("details").forEach((fold) => { fold.open = true; });')
        wider, shown = page.run(spill)
        assert wider <= 0 and "tolerance: printed; from fingerprint/descriptors.tsv" in shown
        left = page.run("""
          const search = document.querySelector("input[type=search]");
          search.value = "descriptors.tsv 3.size"; search.dispatchEvent(new Event("input"));
          const rows = [...document.querySelectorAll("tbody tr")];
          return rows.filter((row) => !row.hidden).map((row) => row.cells[0].textContent);""")
        assert left == ["3.size.steel.t", "3.size.calibrated.n"]
        page.run('document.querySelectorAll("tbody tr:nth-child(n + 6)").forEach((row) => row.remove());')
        assert page.accessibility_faults() == [] and page.errors == []


def test_runtimes_are_those_of_benchmarks_and_else_of_logs(tmp_path):
    (tmp_path / "benchmarks/dem/emax").mkdir(parents=True)
    (tmp_path / "logs/dem/emax").mkdir(parents=True)
    (tmp_path / "benchmarks/dem/emax/a.tsv").write_text("s\th:m:s\tmax_rss\tcpu_time\n61.5\t0:01:01\t200.5\t60.0\n")
    (tmp_path / "logs/dem/emax/a.log").write_text("2026-01-01 INFO run: begin\n2026-01-01 INFO run: done in 59.0 s\n")
    (tmp_path / "logs/dem/plot.log").write_text("x: done in 1.0 s\nINFO plot: done in 2.5 s\n")
    (tmp_path / "logs/dem/failed.log").write_text("INFO plot: begin\nERROR plot: failed\n")
    table = tabulate_runtimes(tmp_path / "benchmarks", tmp_path / "logs")
    assert table["job"].tolist() == ["emax/a", "plot"]
    assert table["wall_s"].tolist() == [61.5, 2.5]
    assert table["memory_MB"].tolist()[0] == 200.5 and table["processor_s"].isna().tolist() == [False, True]
    (stage,) = sum_stages(table).to_dict("records")
    assert stage["jobs"] == 2 and stage["longest_job"] == "emax/a"
    assert stage["wall_min"] == pytest.approx(64 / 60) and stage["processor_min"] == pytest.approx(1)


def test_a_folder_without_a_repository_has_no_commit(tmp_path):
    assert commit(tmp_path) == "unknown"
    assert {"commit", "Python", "system", "numpy", "torch"} <= set(provenance())
