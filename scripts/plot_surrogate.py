"""Draws a variant's loss, and its roll-outs of every test beside the simulations."""

from millprint.figures.chapter6 import plot_dissipation, plot_distributions, plot_error_growth, plot_loss
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job
from millprint.surrogate.tables import join_tables


def main(inputs: dict[str, list[str]], outputs: dict[str, str]) -> None:
    tables = {kind: join_tables([read_table(path) for path in paths]) for kind, paths in inputs.items()}
    figures = {
        "loss": plot_loss(tables["history"]),
        "errors": plot_error_growth(tables["errors"]),
        "dissipation": plot_dissipation(tables["dissipation"], tables["metrics"]),
        "distributions": plot_distributions(tables["distributions"]),
    }
    for name, figure in figures.items():
        save(figure, outputs[f"{name}_svg"], outputs[f"{name}_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"draw the surrogate {snakemake.wildcards.variant}"):
        main({kind: list(paths) for kind, paths in snakemake.input.items()}, dict(snakemake.output.items()))
