"""The rules' scripts of chapter 2 from tables to claims, for the thesis and for another design."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import analyse_variance
import tabulate_experiments
from millprint.config.doe import DoeConfig
from millprint.run.files import read_table, write_table
from millprint.thesis.claims.tabulate import collect_findings
from millprint.thesis.doe.factorial_designs import design_table
from millprint.thesis.doe.written import analysis_paths, design_paths, write_analysis, write_design
from tests.conftest import ROOT
from tests.unit.claim_words import word_of
from tests.unit.doe_settings import SCREENING, settings

pytestmark = pytest.mark.slow

CLAIMS = ROOT / "config/data/claims.tsv"
WEAR = ROOT / "config/data/wear.tsv"


def run_chapter(results: Path, screening: Path, config: DoeConfig) -> list[str]:
    """Everything that the claims of chapter 2 read, under results/doe; returns the audit's departures."""
    doe = results / "doe"
    departures = write_design(str(screening), design_paths(doe), config)
    analysis = analysis_paths(doe)
    write_analysis(str(screening), analysis, config)
    outputs = {
        f"{name}_{kind}": str(doe / f"{name}.{kind}") for name in ("pareto", "residuals") for kind in ("svg", "png")
    }
    outputs["pareto"] = str(doe / "pareto.tsv")
    drawn = [analysis[name] for name in ("printed", "corrected", "residuals")]
    analyse_variance.draw(*drawn, str(CLAIMS), outputs, config.factors)
    return departures


def run_wet_lab(results: Path, config: DoeConfig, weighings: Path = WEAR) -> None:
    outputs = {name: str(results / f"doe/{name}.tsv") for name in ("half_life", "wear")}
    tabulate_experiments.compute_wet_lab(str(weighings), outputs)


def verdicts(results: Path) -> dict[str, str]:
    claims = read_table(CLAIMS, text=["id", "value", "tolerance"])
    own = claims[claims["id"].str.startswith("2.")]
    found = collect_findings(results, CLAIMS, "2.")
    assert set(found) == set(own["id"])
    return {row.id: word_of(row.value, row.tolerance, found[row.id]) for row in own.itertuples()}


@pytest.fixture(scope="module")
def thesis(tmp_path_factory) -> Path:
    results = tmp_path_factory.mktemp("thesis")
    departures = run_chapter(results, SCREENING, settings())
    assert departures[0].startswith("generator D = A + B + C, case 4")
    run_wet_lab(results, settings())
    return results


def test_every_claim_of_chapter_2_is_reproduced_but_for_errata_and_one_order(thesis):
    found = verdicts(thesis)
    errata = {name for name, word in found.items() if word == "erratum"}
    assert errata == {"2.anova.AB.df", "2.wear.1200.loss", "2.slower", "2.shorter.yield", "2.wear.below"}
    # The thesis ranks by F and names the order by p.
    assert {name for name, word in found.items() if word == "differs"} == {"2.pareto.order"}
    assert "open" not in found.values()


def test_the_errata_carry_the_numbers_that_show_them(thesis):
    found = collect_findings(thesis, CLAIMS, "2.")
    assert found["2.anova.AB.df"].value == 4
    said = str(found["2.anova.AB.df"].contradiction)
    assert "its own p of 0.011, with the 27 runs" in said and "leave 0 degrees" in said and "would be 0.0261" in said
    assert found["2.wear.1200.loss"].value == pytest.approx(0.33278, abs=1e-5)
    said = str(found["2.wear.1200.loss"].contradiction)
    assert "0.323 g" in said and "one of two printed numbers is off" in said
    assert found["2.slower"].value == pytest.approx(100 / 6)
    assert "17 points, and 18.9 % less" in str(found["2.shorter.yield"].contradiction)


@pytest.mark.parametrize(
    ("wear_g", "used_g", "expected"),
    [
        # It is 0.349 % of 97.06 g, which is printed as 0.34 where digits are cut off.
        ("0.339", "96.73", "agrees"),
        ("0.331", "96.73", "agrees"),
        ("0.325", "96.73", "differs"),
        ("0.323", "96.73", "erratum"),
    ],
)
def test_no_erratum_outlives_a_changed_input(thesis, tmp_path, wear_g, used_g, expected):
    text = (ROOT / "config/data/wear.tsv").read_text()
    (tmp_path / "wear.tsv").write_text(text.replace("96.73\t0.323", f"{used_g}\t{wear_g}"))
    shutil.copytree(thesis, tmp_path / "results")
    run_wet_lab(tmp_path / "results", settings(), tmp_path / "wear.tsv")
    assert verdicts(tmp_path / "results")["2.wear.1200.loss"] == expected


def test_the_claims_say_what_speed_is_tested_against(thesis):
    found = collect_findings(thesis, CLAIMS, "2.")
    told = found["2.anova.D.p"].explanation
    assert "the residual is A:D 20% + B:D 8% + C:D 72% (as designed) and nothing else" in told
    assert "so D is tested against its interactions" in told and "a range of 17 points" in told
    assert "tested against" not in found["2.anova.C.p"].explanation
    assert "type II after Holm p = 0.064" in found["2.anova.A.p"].explanation
    assert "of which the design has 2" in found["2.anova.AB.ss"].explanation
    assert found["2.pareto.first"].explanation.endswith("after Holm (type II) C and B stand")


def test_with_another_yield_in_one_run_the_sums_deviate(thesis, tmp_path, monkeypatch):
    # No claim reads a figure.
    monkeypatch.setattr(analyse_variance, "save", lambda *arguments: None)
    frame = pd.read_csv(SCREENING, sep="\t", comment="#", dtype=str)
    frame.loc[10, "yield_percent"] = "60"
    frame.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    run_chapter(tmp_path, tmp_path / "runs.tsv", settings())
    run_wet_lab(tmp_path, settings())
    found = verdicts(tmp_path)
    assert found["2.anova.A.ss"] == "differs"
    assert found["2.anova.AB.p"] == "differs"
    # Its degrees of freedom rest on the printed p, which is not that of these yields.
    assert found["2.anova.AB.df"] == "differs"
    assert found["2.screening_runs"] == "agrees"


def test_the_interaction_figures_and_the_literature_are_drawn_as_svg_and_png(thesis, tmp_path):
    figures = settings().interactions
    svgs, pngs = ([tmp_path / f"{figure.name}.{kind}" for figure in figures] for kind in ("svg", "png"))
    names = [figure.name for figure in figures]
    analyse_variance.draw_interactions(str(thesis / "doe/interactions.tsv"), names, svgs, pngs, settings().factors)
    for figure, svg, png in zip(figures, svgs, pngs, strict=True):
        text = svg.read_text()
        # Text is kept as text: both factors' labels, with their units, can be read in the file.
        for symbol in figure.panels[0]:
            assert settings().factor(symbol).label in text
        assert png.read_bytes().startswith(b"\x89PNG")
    names = {
        "unreported": "u.tsv",
        "missingness": "m.tsv",
        "checks": "c.tsv",
        "svg": "l.svg",
        "png": "l.png",
        "tsv": "l.tsv",
    }
    names |= {"missingness_svg": "m.svg", "missingness_png": "m.png"}
    tabulate_experiments.tabulate_literature(
        str(ROOT / "config/data/literature.tsv"),
        str(ROOT / "config/data/literature_yields.tsv"),
        {name: str(tmp_path / file) for name, file in names.items()},
    )
    assert "ball diameter" in (tmp_path / "m.svg").read_text()
    assert "Rotational speed (rpm)" in (tmp_path / "l.svg").read_text()


def test_another_design_of_two_levels_runs_through_the_same_scripts(tmp_path):
    names = ["speed_rpm", "time_h", "fill", "diameter_mm"]
    config = settings(
        factors=[
            {"symbol": symbol, "column": name, "label": name, "levels": [1, 2]}
            for symbol, name in zip("KLMN", names, strict=True)
        ],
        generators=["N = K + L + M"],
        model=["K", "L", "M", "N", "K:L"],
        interactions=[{"name": "pair", "title": "pair", "panels": [["K", "L"]]}],
    )
    design = design_table(config)
    noise = np.random.default_rng(3).normal(size=8)
    runs = design[["case", *names]].assign(yield_percent=40 + 20 * design["L"] + noise)
    runs.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    assert run_chapter(tmp_path, tmp_path / "runs.tsv", config) == []
    table = read_table(tmp_path / "doe/anova_printed.tsv", text=["source", "term"]).set_index("term")
    assert table["F"].idxmax() == "L"
    assert table.loc["K:L", "source"] == "KL, MN"
    assert table.loc["L", "sum_of_squares"] == pytest.approx(table.loc["LL", "sum_of_squares"])
    assert not any("inf" in path.read_text().split() for path in (tmp_path / "doe").glob("*.tsv"))


def test_the_share_of_time_is_an_erratum_only_beside_the_printed_sums(thesis, tmp_path):
    """Table 2.5 leaves time 38 % of the sum of squares at most, where Sec. 5.2.5 says 50 %."""
    results = tmp_path / "results"
    shutil.copytree(thesis, results)
    table = pd.DataFrame({"measure": ["levels", "line"], "share": [0.368, 0.354]})
    write_table(table, results / "yield/time_variance.tsv")
    claim = read_table(CLAIMS, text=["id", "value", "tolerance"]).set_index("id").loc["5.time_variance"]

    def judged() -> str:
        finding = collect_findings(results, CLAIMS, "5.time")["5.time_variance"]
        return word_of(claim["value"], claim["tolerance"], finding)

    assert judged() == "erratum"
    anova = read_table(results / "doe/anova_printed.tsv")
    anova.loc[anova["term"] == "C", "sum_of_squares"] = 0.5
    write_table(anova, results / "doe/anova_printed.tsv")
    assert judged() == "differs"
    write_table(table.assign(share=0.51), results / "yield/time_variance.tsv")
    assert judged() == "agrees"
