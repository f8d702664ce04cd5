"""Figures 3.7, 3.8, 3.11 and 3.12: descriptors and master curves of one contact set against fill ratio."""

from millprint.figures.chapter3 import plot_energies, plot_master_curves
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.curves import conditions_of
from millprint.fingerprint.descriptors import as_built
from millprint.fingerprint.published import published_curves, read_published
from millprint.job import job


def main(inputs, output, mill: str, contact: str) -> None:
    """Draw the conditions, means and smooth curves with their zones, and the values that the thesis prints."""
    descriptors = as_built(conditions_of(read_table(inputs.descriptors), mill, contact))
    published = published_curves(read_published(*inputs.published), contact)
    zones = read_table(inputs.zones)
    figure = plot_master_curves(
        descriptors,
        read_table(inputs.means),
        read_table(inputs.curves),
        published,
        zones[zones["contact"] == contact],
    )
    save(plot_energies(descriptors), output.energies_svg, output.energies_png)
    save(figure, output.curves_svg, output.curves_png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"plot master curves of {snakemake.wildcards.contact}"):
        main(snakemake.input, snakemake.output, snakemake.params.mill, snakemake.wildcards.contact)
