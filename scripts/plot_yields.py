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


def draw_models(inputs, output) -> None:
    """Figures 5.2 to 5.4: predictions, intervals and SHAP values."""
    text = ["model", "strategy", "case"]
    predictions = read_table(inputs.predictions, numeric=["yield_percent", "predicted_percent"], text=text)
    save(plot_test_predictions(predictions), *output.predictions_figure)
    save(plot_intervals(predictions), *output.intervals_figure)
    attributions = read_table(inputs.shap, numeric=["feature_value", "shap_pp"], text=[*text, "feature"])
    save(plot_attributions(attributions), *output.shap_figure)


def draw_trust(inputs, output) -> None:
    """Cross-validation, coverage, other regimes, and the next experiments."""
    text = ["model", "strategy", "scheme"]
    claims = read_measured(inputs.claims, [Text("id"), Text("value")])
    scores = read_table(inputs.scores_by_scheme, numeric=["value", "repeats"], text=[*text, "metric"])
    save(plot_evaluation(scores, claims), *output.evaluation_figure)
    coverage = read_table(inputs.coverage, numeric=["nominal", "covered", "width_pp"], text=[*text, "method"])
    save(plot_coverage(coverage), *output.coverage_figure)
    proposals = read_table(inputs.proposals, numeric=["predicted_percent"], text=["purpose"])
    save(plot_proposals(proposals), *output.proposals_figure)
    regimes = read_table(inputs.regimes, numeric=["rmse_pp"], text=["model", "descriptors", "added"])
    save(plot_regimes(regimes), *output.regimes_figure)


def draw_scores(inputs, output) -> None:
    """Proper scores, calibration and the permutation test."""
    text = ["model", "strategy", "scheme"]
    scores = read_table(inputs.scores, numeric=["value", "error", "repeats"], text=[*text, "score"])
    save(plot_scores(scores), *output.scores_figure)
    pit = read_table(inputs.pit, numeric=["from", "to", "share", "expected", "repeats"], text=text)
    save(plot_pit(pit), *output.pit_figure)
    permutations = read_table(inputs.permutations, numeric=["permutation", "r2"])
    save(plot_permutations(permutations), *output.permutations_figure)


def draw_sources(inputs, output) -> None:
    """What transfers between sources of yields."""
    texts = ["source", "model", "strategy"]
    table = read_table(inputs.sources, text=[*texts, "verdict", "reason"])
    points = read_table(inputs.sources_predictions, numeric=["yield_percent", "predicted_percent"], text=texts)
    save(plot_sources(table, points), *output.sources_figure)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot yields"):
        for draw in (draw_models, draw_trust, draw_scores, draw_sources):
            draw(snakemake.input, snakemake.output)
