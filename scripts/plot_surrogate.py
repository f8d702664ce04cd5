"""Draws the loss of a variant, and its roll-outs next to the simulations, for every test with moving balls."""

from millprint.figures.chapter6 import plot_dissipation, plot_distributions, plot_error_growth, plot_loss
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs: dict[str, str], outputs: dict[str, str], tests: list[str]) -> None:
    loss = read_table(inputs.pop("history"))
    tables = {kind: read_table(path, text=["test"]) for kind, path in inputs.items()}
    tables = {kind: table[table["test"].isin(tests)] for kind, table in tables.items()}
    figures = {
        "loss": plot_loss(loss),
        "errors": plot_error_growth(tables["errors"]),
        "dissipation": plot_dissipation(tables["dissipation"], tables["metrics"]),
        "distributions": plot_distributions(tables["distributions"]),
    }
    for name, figure in figures.items():
        save(figure, outputs[f"{name}_svg"], outputs[f"{name}_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"draw the surrogate {snakemake.wildcards.variant}"):
        main(dict(snakemake.input.items()), dict(snakemake.output.items()), snakemake.params.tests)
