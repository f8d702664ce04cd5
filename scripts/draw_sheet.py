"""Draws the fingerprint of a mill on one page, and the energy spectra of its sweep."""

from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, over_pairs, rules_apart, shown
from millprint.figures.mill_sheet import plot_sheet
from millprint.figures.spectra import plot_rules, plot_spectra
from millprint.figures.style import save
from millprint.files import read_table
from millprint.fingerprint.descriptors import read_descriptors
from millprint.job import job
from millprint.view.mill_picture import picture_mill


def main(tables, output: dict[str, str], mill: MillConfig, rules: list[str]) -> None:
    """Draw the page, and spectra over the fill ratio and by each counting rule."""
    sheet, curves = (read_table(tables[name]) for name in ("sheet", "curves"))
    spectra, read_off = (read_spectra(tables[name]) for name in ("spectra", "spectra_summary"))
    own = (of_sheet(spectra, sheet), of_sheet(read_off, sheet))
    page = plot_sheet(picture_mill(mill), sheet, read_descriptors(tables.descriptors), curves, *own)
    save(page, *(output[kind] for kind in ("svg", "png", "pdf")))
    save(plot_spectra(shown(spectra, rules[0]), mill.title), output["spectra_svg"], output["spectra_png"])
    told = of_sheet(read_off, sheet, rules)
    figure = plot_rules(over_pairs(of_sheet(spectra, sheet, rules)), told, mill.title, rules_apart(told))
    save(figure, output["rules_svg"], output["rules_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], f"fingerprint sheet of {snakemake.params.mill['name']}"):
        main(
            snakemake.input,
            dict(snakemake.output.items()),
            MillConfig(**snakemake.params.mill),
            snakemake.params.rules,
        )
