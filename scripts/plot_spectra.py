"""Draws energy spectra: collisions a second, power, and the share of the power above an energy."""

from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import shown
from millprint.figures.spectra import plot_spectra
from millprint.figures.style import save
from millprint.job import job


def main(spectra_path: str, output, title: str, rule_name: str, chosen: dict) -> None:
    """Draw the spectra of the chosen conditions, by one counting rule."""
    save(plot_spectra(shown(read_spectra(spectra_path), rule_name, **chosen), title), output.svg, output.png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot energy spectra"):
        main(
            snakemake.input.spectra,
            snakemake.output,
            snakemake.params.title,
            snakemake.params.rule,
            snakemake.params.chosen,
        )
