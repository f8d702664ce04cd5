"""Every table of chapter 2 that follows from the screening and the weighings is the stored one, to its last column."""

import pytest

import analyse_variance
import tabulate_experiments
from millprint.thesis.doe.residuals import analysis_paths, design_paths, write_analysis, write_design
from tests.conftest import ROOT
from tests.stored_tables import compare_tables
from tests.unit.doe_settings import SCREENING, settings


@pytest.mark.slow
def test_the_tables_of_chapter_2_are_the_stored_ones(tmp_path):
    doe, data = tmp_path / "doe", ROOT / "config/data"
    write_design(str(SCREENING), design_paths(doe), settings())
    analysis = analysis_paths(doe)
    write_analysis(str(SCREENING), analysis, settings())
    figures = ("pareto", "residuals")
    outputs = {f"{name}_figure": [str(doe / f"{name}.{kind}") for kind in ("svg", "png")] for name in figures}
    outputs["pareto"] = str(doe / "pareto.tsv")
    drawn = [analysis[name] for name in ("printed", "corrected", "residuals")]
    analyse_variance.draw(*drawn, str(data / "claims.tsv"), outputs, settings().factors)
    paths = {name: str(doe / f"{name}.tsv") for name in ("half_life", "wear")}
    tabulate_experiments.compute_wet_lab(str(data / "wear.tsv"), paths)
    assert compare_tables(tmp_path) == 15
