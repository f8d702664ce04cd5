"""Tabulates the ablations of appendix A next to the statements of the thesis, and draws them.

Settings: surrogate.ablations: what each changes, its trainings, and the length of its roll-out.
Inputs: `metrics` of every training, `histories` of the loss, `claims`.
Outputs: `ablations`, `svg`, `png`.
"""

import logging

from millprint.figures.style import save
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.run.tables import read_printed
from millprint.thesis.figures.chapter6_figures import plot_ablations
from millprint.thesis.surrogate.measure_tables import ablation_table, join_tables, scatter_in_words

logger = logging.getLogger("millprint")


def main(
    metrics: list[str], histories: dict[str, str], claims: str, output: str, changes: dict, length_s: dict,
    trainings: dict[str, list[str]],
) -> None:  # fmt: skip
    """Write a row for each ablation, with the interval over its trainings or those of the baseline."""
    rows = join_tables([read_table(path, text=["variant", "test", "measure"]) for path in metrics])
    losses = {variant: read_table(path, numeric=["elapsed_s"]) for variant, path in histories.items()}
    table = ablation_table(rows, losses, changes, length_s, read_printed(claims), trainings)
    write_table(table, output)
    logger.info("%s", scatter_in_words(table) or "the baseline was trained once, so nothing tells chance apart")


def draw(table: str, svg: str, png: str) -> None:
    """Draw every ablation, from the written table."""
    ablations = read_table(table, numeric=["stable"], text=["variant", "says"])
    save(plot_ablations(ablations, scatter_in_words(ablations)), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate the ablations"):
        main(
            list(snakemake.input.metrics),
            dict(zip(snakemake.params.changes, snakemake.input.histories, strict=True)),
            snakemake.input.claims,
            snakemake.output.ablations,
            snakemake.params.changes,
            snakemake.params.length_s,
            snakemake.params.trainings,
        )
        draw(snakemake.output.ablations, snakemake.output.svg, snakemake.output.png)
