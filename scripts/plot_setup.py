"""Figure: what was measured in a set-up, over its predictions."""

from millprint.figures.style import save
from millprint.figures.validation import plot_setup
from millprint.files import read_table
from millprint.job import job
from millprint.validation.measured import measured_points, read_measurements
from millprint.validation.setups import SETUPS, setup_named

if "snakemake" in globals():
    name = snakemake.wildcards.setup
    with job(snakemake.log[0], f"plot set-up {name}"):
        points = measured_points(read_measurements(snakemake.input.measured, SETUPS))
        predictions = read_table(
            snakemake.input.predictions,
            numeric=["x", "predicted", "lower", "upper"],
            text=["id", "quantity", "unit", "model", "interval"],
            may_be_blank=["x", "lower", "upper"],
        )
        points, title = points[points["setup"] == name], setup_named(name).title
        save(plot_setup(predictions, points, title), snakemake.output.svg, snakemake.output.png)
        first = predictions[predictions["quantity"] == predictions["quantity"].iloc[0]]
        save(plot_setup(first, points, title), snakemake.output.first_svg, snakemake.output.first_png)
