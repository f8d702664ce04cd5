"""Figures of chapter 5: predictions, SHAP values, cross-validation, scores, regimes and sources.

Settings: none.
Inputs: the tables of the yield models, and `claims`.
Outputs: each figure as SVG and PNG.
"""

from millprint.figures.style import save
from millprint.run.files import read_table
from millprint.run.job import job
from millprint.run.tables import Text, read_measured
from millprint.thesis.figures.chapter5_figures import (
    plot_attributions,
    plot_coverage,
    plot_evaluation,
    plot_intervals,
    plot_permutations,
    plot_pit,
    plot_proposals,
    plot_regimes,
    plot_scores,
    plot_sources,
    plot_test_predictions,
)

# Columns that are text whatever a cell holds.
TEXT = ["model", "strategy"]

if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    with job(snakemake.log[0], "plot yields"):
        predictions = read_table(given.predictions, text=[*TEXT, "case"])
        save(plot_test_predictions(predictions), *made.predictions_figure)
        save(plot_intervals(predictions), *made.intervals_figure)
        save(plot_attributions(read_table(given.shap, text=[*TEXT, "case", "feature"])), *made.shap_figure)
        claims = read_measured(given.claims, [Text("id"), Text("value")])
        save(plot_evaluation(read_table(given.scores_by_scheme, text=TEXT), claims), *made.evaluation_figure)
        save(plot_coverage(read_table(given.coverage, text=TEXT)), *made.coverage_figure)
        save(plot_proposals(read_table(given.proposals)), *made.proposals_figure)
        save(plot_regimes(read_table(given.regimes, text=["added"])), *made.regimes_figure)
        save(plot_scores(read_table(given.scores, text=TEXT)), *made.scores_figure)
        save(plot_pit(read_table(given.pit, text=TEXT)), *made.pit_figure)
        save(plot_permutations(read_table(given.permutations)), *made.permutations_figure)
        sources = read_table(given.sources, text=[*TEXT, "source", "verdict", "reason"])
        points = read_table(given.sources_predictions, text=[*TEXT, "source"])
        save(plot_sources(sources, points), *made.sources_figure)
