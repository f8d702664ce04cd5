"""Draws the loss of a variant, and its roll-outs next to the simulations, for every test with moving balls."""

from millprint.figures.chapter6 import plot_dissipation, plot_distributions, plot_error_growth, plot_loss
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs: dict, outputs: dict[str, str], variant: str, tests: list[str]) -> None:
    """Draw a variant; input `trainings` has the dissipation of each of its trainings, `spread` all measures."""
    loss, trainings = read_table(inputs.pop("history")), list(inputs.pop("trainings"))
    spread = read_table(inputs.pop("spread"), text=["variant", "test"])
    others = [read_table(path, text=["test"]) for path in trainings[1:]]
    tables = {kind: read_table(path, text=["test"]) for kind, path in inputs.items()}
    tables = {kind: table[table["test"].isin(tests)] for kind, table in tables.items()}
    figures = {
        "loss": plot_loss(loss),
        "errors": plot_error_growth(tables["errors"]),
        "dissipation": plot_dissipation(tables["dissipation"], spread[spread["variant"] == variant], others),
        "distributions": plot_distributions(tables["distributions"]),
    }
    for name, figure in figures.items():
        save(figure, outputs[f"{name}_svg"], outputs[f"{name}_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"draw the surrogate {snakemake.wildcards.variant}"):
        files = dict(snakemake.input.items()), dict(snakemake.output.items())
        main(*files, snakemake.wildcards.variant, snakemake.params.tests)
