"""Draws energy spectra: collisions a second, power, and the share of the power above an energy."""

from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import shown
from millprint.figures.spectra import plot_spectra
from millprint.figures.style import save
from millprint.job import job


def main(spectra_path: str, svg: str, png: str, title: str, rule_name: str, chosen: dict) -> None:
    """Draw the spectra of the chosen conditions, by one counting rule."""
    save(plot_spectra(shown(read_spectra(spectra_path), rule_name, **chosen), title), svg, png)


if "snakemake" in globals():
    own, output = snakemake.params, snakemake.output
    with job(snakemake.log[0], "plot energy spectra"):
        for spectra, svg, png, title in zip(snakemake.input.spectra, output.svgs, output.pngs, own.titles, strict=True):
            main(spectra, svg, png, title, own.rule, own.chosen)
