"""Figures of proper scores, calibration and the permutation test."""

from millprint.figures.chapter5_scores import plot_permutations, plot_pit, plot_scores
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs, output) -> None:
    """Draw the figures."""
    text = ["model", "strategy", "scheme"]
    scores = read_table(inputs.scores, numeric=["value", "error"], text=[*text, "score"])
    save(plot_scores(scores), output.scores_svg, output.scores_png)
    pit = read_table(inputs.pit, numeric=["from", "to", "share", "expected"], text=text)
    save(plot_pit(pit), output.pit_svg, output.pit_png)
    permutations = read_table(inputs.permutations, numeric=["permutation", "r2"])
    save(plot_permutations(permutations), output.permutations_svg, output.permutations_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot yield scores"):
        main(snakemake.input, snakemake.output)
