"""Figures 3.5 and 3.6: the dissipation of single revolutions."""

from millprint.figures.chapter3 import plot_cycle_densities, plot_cycle_means
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.descriptors import NOTHING
from millprint.fingerprint.published import published_cycles, read_published
from millprint.job import job


def main(inputs, output, mill: str, contacts: list[str], fill_ratio: float) -> None:
    """Draw one mill's revolutions at the fill ratio of Table 3.5."""
    densities, cycles = read_table(inputs.densities), read_table(inputs.cycles)
    shown = (
        (cycles["mill"] == mill)
        & (cycles["varied"] == NOTHING)
        & cycles["contact"].isin(contacts)
        & cycles["fill_ratio"].sub(fill_ratio).abs().lt(1e-9)
    )
    published = published_cycles(read_published(*inputs.published))
    published = published[published["fill_ratio"].sub(fill_ratio).abs().lt(1e-9)]
    kept = densities[(densities["mill"] == mill) & densities["contact"].isin(contacts)]
    save(plot_cycle_densities(kept), output.densities_svg, output.densities_png)
    save(plot_cycle_means(cycles[shown], published), output.means_svg, output.means_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot cycles"):
        own = snakemake.params
        main(snakemake.input, snakemake.output, own.mill, own.contacts, own.cycle_fill_ratio)
