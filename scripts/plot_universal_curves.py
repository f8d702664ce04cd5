"""Figure 3.14: the universal master curves of all contact sets, and the exponents of the scaling by regression."""

from millprint.figures.chapter3 import plot_exponents, plot_universal_curves
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.curves import universal_descriptors
from millprint.fingerprint.descriptors import as_built
from millprint.job import job


def main(inputs, output, mill: str, contacts: list[str]) -> None:
    """Draw the conditions of one mill after the universal scaling, and its exponents with the run's counting rule."""
    descriptors = as_built(read_table(inputs.descriptors))
    descriptors = descriptors[(descriptors["mill"] == mill) & descriptors["contact"].isin(contacts)]
    save(
        plot_universal_curves(universal_descriptors(descriptors), read_table(inputs.universal)), output.svg, output.png
    )
    exponents = read_table(inputs.exponents)
    own = exponents["contact"].isin(contacts) & (exponents["counting_rule"] == descriptors["counting_rule"].iloc[0])
    save(plot_exponents(exponents[own].dropna(subset="exponent")), output.exponents_svg, output.exponents_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot universal curves"):
        main(snakemake.input, snakemake.output, snakemake.params.mill, snakemake.params.contacts)
