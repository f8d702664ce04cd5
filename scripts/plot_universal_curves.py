"""Figure 3.14: the universal master curves of all contact sets."""

from millprint.figures.chapter3 import plot_universal_curves
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.curves import universal_descriptors
from millprint.job import job


def main(inputs, output, mill: str, contacts: list[str]) -> None:
    """Draw one mill's conditions after the universal scaling."""
    descriptors = read_table(inputs.descriptors)
    descriptors = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    save(
        plot_universal_curves(universal_descriptors(descriptors), read_table(inputs.universal)), output.svg, output.png
    )


if "snakemake" in globals():
    with job(snakemake.log[0], "plot universal curves"):
        main(snakemake.input, snakemake.output, snakemake.params.mill, snakemake.params.contacts)
