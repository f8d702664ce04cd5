"""Figure of the measured and the predicted wear of the balls."""

from millprint.dose.sliding import CONDITION
from millprint.figures.dose import plot_wear
from millprint.figures.style import save
from millprint.files import read_json, read_table
from millprint.job import job


def main(fit: str, wear: str, coefficient: str, output, material: str) -> None:
    """Draw the figure."""
    weighings = read_table(fit, text=["role", "loads_from"])
    predicted = read_table(wear, text=[*CONDITION[:2], "material"])
    save(plot_wear(weighings, predicted, material, read_json(coefficient)["verdict"]), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot wear"):
        main(
            snakemake.input.fit,
            snakemake.input.wear,
            snakemake.input.coefficient,
            snakemake.output,
            snakemake.params.material,
        )
