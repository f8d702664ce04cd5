"""Figures of cross-validation, coverage, other regimes, and the next experiments."""

from millprint.figures.chapter5_trust import (
    plot_coverage,
    plot_evaluation,
    plot_proposals,
    plot_regimes,
    plot_retrospective,
)
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs, output) -> None:
    """Draw the figures."""
    text = ["model", "strategy", "scheme"]
    claims = read_table(inputs.claims, text=["id", "value"])
    scores = read_table(inputs.honest, numeric=["value"], text=[*text, "metric"])
    save(plot_evaluation(scores, claims), output.evaluation_svg, output.evaluation_png)
    coverage = read_table(inputs.coverage, numeric=["nominal", "covered", "width_pp"], text=[*text, "method"])
    save(plot_coverage(coverage), output.coverage_svg, output.coverage_png)
    retrospective = read_table(inputs.retrospective, numeric=["runs", "found"], text=["target", "strategy"])
    save(plot_retrospective(retrospective), output.retrospective_svg, output.retrospective_png)
    proposals = read_table(inputs.proposals, numeric=["predicted_percent"], text=["purpose"])
    save(plot_proposals(proposals), output.proposals_svg, output.proposals_png)
    regimes = read_table(inputs.regimes, numeric=["rmse_pp"], text=["model", "descriptors", "added"])
    save(plot_regimes(regimes), output.regimes_svg, output.regimes_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot yield trust"):
        main(snakemake.input, snakemake.output)
