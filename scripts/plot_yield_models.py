"""Figures 5.2 to 5.4: predictions, intervals and SHAP values of the yield models."""

from millprint.figures.chapter5 import plot_attributions, plot_intervals, plot_test_predictions
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs, output) -> None:
    """Draw the three figures."""
    text = ["model", "strategy", "case"]
    predictions = read_table(inputs.predictions, numeric=["yield_percent", "predicted_percent"], text=text)
    save(plot_test_predictions(predictions), output.predictions_svg, output.predictions_png)
    save(plot_intervals(predictions), output.intervals_svg, output.intervals_png)
    attributions = read_table(inputs.shap, numeric=["feature_value", "shap_pp"], text=[*text, "feature"])
    save(plot_attributions(attributions), output.shap_svg, output.shap_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot yield models"):
        main(snakemake.input, snakemake.output)
