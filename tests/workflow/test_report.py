"""The report of the smoke run in a real browser: nothing fetched, tables that sort, readable on a phone."""

import importlib
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape

from millprint.estimate.judge import VERDICTS
from millprint.provenance.lineage import read_jobs
from millprint.run.files import read_json, read_table
from millprint.run.machine import commit
from millprint.run.outputs import captioned, listed_tables
from tests.browser import DESKTOP, PHONE, needs_browser
from tests.workflow.conftest import run_snakemake

PAGES = ["summary", "claims", "runtimes", "explorer", "gallery", *(f"tables_{chapter}" for chapter in listed_tables())]

# The validation is a target of its own, and so is its page.
ELSEWHERE = {"tables_Validation": "validation/tables.html"}
CHECKED_BY_AXE = ("summary", "claims", "runtimes", "explorer", "gallery")


@pytest.fixture(scope="module")
def report(smoke_project):
    return smoke_project / "results/report"


def page_path(report, name: str):
    """Where a page is."""
    return report.parent / ELSEWHERE.get(name, f"report/{name}.html")


@pytest.fixture
def page(browser):
    with browser.page() as page:
        yield page
        assert page.errors == []


def _show(name: str) -> str:
    """JavaScript that opens the result whose path ends with `name` in Snakemake's report."""
    return f"""
      const path = Object.keys(results).find((key) => key.endsWith({name!r}));
      const kind = {{ "text/html": "html" }}[results[path].mime_type] ?? "img";
      app.setView({{ content: kind, contentPath: results[path].data_uri, resultPath: path }});
      await new Promise((done) => setTimeout(done, 1000));"""


@needs_browser
@pytest.mark.parametrize(
    ("name", "width"),
    # All pages of tables are alike, and a phone is the harder of the two.
    [(name, width) for name in PAGES for width in (DESKTOP, PHONE) if width == PHONE or name in CHECKED_BY_AXE],
)
def test_a_page_is_readable_and_fetches_nothing(report, page, tmp_path, name, width):
    page.resize(width, 1200)
    path = page_path(report, name)
    # The browser also shows a page for a file that does not exist.
    assert path.is_file()
    page.open(path)
    picture = page.picture(tmp_path / f"{name}_{width}.png")
    assert np.asarray(picture.convert("L")).std() > 5
    measured = page.measure()
    assert measured["beyond"] <= 0 and measured["smallest"] >= 10
    # On a phone, tables of numbers scroll sideways, sentences do not.
    spill = 'return [...document.querySelectorAll(".cards")].map((e) => e.scrollWidth - e.parentElement.clientWidth);'
    assert all(wider <= 0 for wider in page.run(spill))
    assert page.outside_requests() == []
    # Also for those who hear the page, or use it by keyboard. All tables are alike, and axe is slow with long ones.
    if name in CHECKED_BY_AXE:
        page.run('document.querySelectorAll("tbody tr:nth-child(n + 6)").forEach((row) => row.remove());')
        assert page.accessibility_faults() == []


@needs_browser
@pytest.mark.parametrize(("width", "height"), [(DESKTOP, 900), (PHONE, 1200)])
def test_the_report_opens_offline_and_shows_its_results(report, page, tmp_path, width, height):
    page.resize(width, height)
    page.open(report / "report.html")
    start = np.asarray(page.picture(tmp_path / f"report_{width}.png"))
    seen = [start]
    for name in ("master_curves_calibrated.svg", "motion_animated.png", "mill.png", "summary.html", "explorer.html"):
        page.run(_show(name))
        seen.append(np.asarray(page.picture(tmp_path / f"report_{name}_{width}.png")))
    assert all((one != other).mean() > 0.02 for one, other in pairwise(seen))
    assert page.run("return document.documentElement.scrollWidth - innerWidth;") <= 0
    assert page.outside_requests() == []


@needs_browser
def test_figures_animations_tables_and_captions_are_in_the_report(report, page):
    page.open(report / "report.html")
    content = page.run(
        "return { names: Object.keys(results), captions: Object.values(results).map((r) => r.caption) };"
    )
    assert {"mill.png", "motion_animated.png", "summary.html", "claims.html", "explorer.html", "runtimes.html"} <= {
        name.rsplit("/", 1)[1] for name in content["names"]
    }
    words = [len(re.sub("<[^>]+>", " ", caption).split()) for caption in content["captions"]]
    assert len(words) > 40 and min(words) >= 12
    # A job of several figures has no words of their paths: the caption is a whole sentence without them too.
    assert [caption for caption in content["captions"] if re.search("  | : |_[.]", caption)] == []


@needs_browser
def test_a_table_sorts_and_filters(report, page):
    page.open(report / "claims.html")
    found = page.run("""
      const table = document.querySelector("table.sorts");
      const names = [...table.tHead.rows[0].cells].map((cell) => cell.textContent);
      const column = names.indexOf("deviation");
      const click = () => table.tHead.rows[0].cells[column].querySelector("button").click();
      const values = () => [...table.tBodies[0].rows].map((row) => row.cells[column].textContent);
      click(); const rising = values(); const says = table.tHead.rows[0].cells[column].getAttribute("aria-sort");
      click(); const falling = values();
      const search = document.querySelector("input[type=search]");
      search.value = "differs 3.curve"; search.dispatchEvent(new Event("input"));
      const left = [...table.tBodies[0].rows].filter((row) => !row.hidden).map((row) => row.cells[0].textContent);
      return { rising, falling, says, left, said: document.querySelector("output").textContent };""")
    rising = [float(text) for text in found["rising"] if text]
    assert rising == sorted(rising) and len(rising) > 50 and found["says"] == "ascending"
    assert [float(text) for text in found["falling"] if text] == rising[::-1]
    # Cells without a number come last in both orders.
    assert found["rising"][-1] == "" and found["falling"][-1] == ""
    assert found["left"] and all(name.startswith("3.curve") for name in found["left"])
    assert found["said"].startswith(f"{len(found['left'])} of ")


@pytest.mark.parametrize("chapter", listed_tables())
def test_every_table_of_the_catalogue_is_shown(report, chapter):
    text = page_path(report, f"tables_{chapter}").read_text()
    assert re.findall("<h2>(.*?)</h2>", text) == [escape(listed.title) for listed in listed_tables()[chapter]]


def test_the_summary_counts_what_the_table_of_claims_holds(report):
    claims = read_table(report / "claims.tsv", text=["id", "verdict"])
    counts = read_table(report / "claims_by_chapter.tsv", text=["chapter"]).set_index("chapter")
    assert counts["claims"].sum() == len(claims)
    assert counts.index.tolist() == [f"chapter {n}" for n in range(2, 7)] + ["appendix A"]
    for verdict, group in claims.groupby("verdict"):
        assert counts[verdict].sum() == len(group)
    text = (report / "summary.html").read_text()
    for row in counts.to_dict("records"):
        said = ", ".join(f"{row[name]} {name}" for name in VERDICTS if row[name])
        assert said in text


def sources_of(claims: pd.DataFrame) -> pd.DataFrame:
    """A row for each source of each claim: id, verdict, path, rows, columns, rule, function."""
    form = r"(?P<path>\S+)(?: \[(?P<rows>.+)\])? (?P<columns>.+) \(rule (?P<rule>\w+), (?P<function>millprint[\w.]+)\)"
    each = claims.assign(source=claims["source"].str.split("; ")).explode("source", ignore_index=True)
    parts = each["source"].str.fullmatch(form)
    assert parts.all(), each["source"][~parts].tolist()
    return each[["id", "verdict"]].join(each["source"].str.extract(form))


def test_every_claim_leads_to_rows_that_exist_and_to_the_rule_that_wrote_them(report):
    """The summary of Snakemake says which rule makes which file."""
    sources = sources_of(read_table(report / "claims.tsv", text=["id", "verdict", "source"]))
    listed = read_table("config/data/claims.tsv", text=["id"])["id"]
    assert sorted(sources["id"].unique()) == sorted(listed)
    summary = run_snakemake(report.parents[1], "--summary", "--configfile", "config/smoke.yaml").stdout
    rules = dict(re.findall(r"^results/(\S+)\t[^\t]*\t(\w+)\t", summary, re.MULTILINE))
    for source in sources[sources["verdict"] != "open"].itertuples():
        module, name = source.function.rsplit(".", 1)
        assert callable(getattr(importlib.import_module(module), name))
        if source.rule == "write_pages":
            assert (report.parents[1] / source.path).is_file()
            continue
        assert rules[source.path] == source.rule, source
        path = report.parent / source.path
        table = pd.DataFrame([read_json(path)]) if path.suffix == ".json" else read_table(path)
        assert len(table.query(source.rows, engine="python") if isinstance(source.rows, str) else table), source
        assert set(source.columns.split(", ")) <= set(table), source


def test_the_links_of_the_claims_lead_to_files_and_sections(report):
    links = re.findall('<a href="(.*?)">', (report / "claims.html").read_text())
    assert len(links) > 200
    for link in set(links):
        path, _, section = link.partition("#")
        assert (report / path).is_file(), link
        assert not section or f'id="{section}"' in (report / path).read_text(), link


def test_the_gallery_has_every_figure_of_the_report_with_the_tables_that_its_rule_read_or_wrote(report, monkeypatch):
    monkeypatch.chdir(report.parents[1])
    text, jobs = (report / "gallery.html").read_text(), read_jobs()
    shown = re.findall(r'<a class="picture" href="\.\./(.*?)">', text)
    summary = (report / "report.html").read_text()
    drawn = {Path(path).name for path in shown}
    assert len(shown) > 60 and {"mill.png", "motion_animated.png"} <= drawn
    assert {Path(path).name for path in re.findall(r'"results/([^"]*\.svg)": \{', summary)} <= drawn
    for path in shown:
        own = jobs[f"results/{path}"]
        for table in captioned(path).data:
            assert f'href="../{table}"' in text and (report.parent / table).is_file()
            name = f"results/{table}"
            assert name in own.inputs or jobs[name].rule == own.rule, f"{path} is not drawn from {table}"
    assert f"at commit <code>{commit()}</code>" in text or "at commit <code>unknown</code>" in text
