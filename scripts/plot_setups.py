"""Figures: what was measured in each set-up, over its predictions."""

import pandas as pd

from millprint.figures.style import save
from millprint.figures.validation import plot_setup
from millprint.files import read_table
from millprint.job import job
from millprint.validation.measured import measured_points, read_measurements
from millprint.validation.setups import SETUPS, setup_named


def main(
    name: str, predictions_path: str, points: pd.DataFrame, svg: str, png: str, first_svg: str, first_png: str
) -> None:
    """Draw every quantity of a set-up and, for a page, its first alone. points: what was measured in all set-ups."""
    predictions = read_table(
        predictions_path,
        numeric=["x", "predicted", "lower", "upper"],
        text=["id", "quantity", "unit", "model", "interval"],
        may_be_blank=["x", "lower", "upper"],
    )
    own, title = points[points["setup"] == name], setup_named(name).title
    save(plot_setup(predictions, own, title), svg, png)
    first = predictions[predictions["quantity"] == predictions["quantity"].iloc[0]]
    save(plot_setup(first, own, title), first_svg, first_png)


if "snakemake" in globals():
    given, made = snakemake.input, snakemake.output
    with job(snakemake.log[0], "plot set-ups") as log:
        points = measured_points(read_measurements(given.measured, SETUPS))
        figures = zip(given.predictions, made.svgs, made.pngs, made.first_svgs, made.first_pngs, strict=True)
        for name, (predictions, *paths) in zip(snakemake.params.setups, figures, strict=True):
            main(name, predictions, points, *paths)
            log.info("drawn: %s", name)
