"""Draws the fingerprint of a mill on one page, and its energy spectra: over the fill ratio, and by each counting rule.

Settings: the mill, its contact set, mills.counting_rule and dose.spectra.counting_rules (the rule of the descriptors
first).
Inputs: `sheet`, `descriptors`, `curves`, `spectra` and `spectra_summary` of the mill's sweep; `limits` of its heat
balance.
Outputs: the page as `figure` and `pdf`; `spectra_figure`, `rules_figure`.
"""

from millprint.atlas.beside_simulation import atlas_rows
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, over_pairs, rules_apart, shown, temperature_rows, with_rows
from millprint.figures.dose_figures import plot_rules, plot_spectra
from millprint.figures.mill_sheet_figure import plot_sheet
from millprint.figures.style import save
from millprint.fingerprint.descriptors import read_descriptors
from millprint.run.files import read_table
from millprint.run.job import job
from millprint.view.frames import picture_mill


def draw_sheet(tables, output, mill: MillConfig, contact: ContactConfig) -> None:
    """Draw the page from the tables of the mill's sweep, with the row of the atlas where it knows the mill."""
    sheet, curves = read_table(tables.sheet), read_table(tables.curves)
    sheet = with_rows(sheet, temperature_rows(read_table(tables.limits), sheet))
    sheet = with_rows(sheet, atlas_rows(mill, contact, sheet))
    own = [of_sheet(read_spectra(path), sheet) for path in (tables.spectra, tables.spectra_summary)]
    page = plot_sheet(picture_mill(mill), sheet, read_descriptors(tables.descriptors), curves, *own)
    save(page, *output.figure, output.pdf)


def draw_spectra(tables, output, title: str, rules: list[str]) -> None:
    """Draw both figures. rules: names of counting rules, that of the descriptors first."""
    sheet = read_table(tables.sheet)
    spectra, read_off = read_spectra(tables.spectra), read_spectra(tables.spectra_summary)
    save(plot_spectra(shown(spectra, rules[0]), title), *output.spectra_figure)
    told = of_sheet(read_off, sheet, rules)
    figure = plot_rules(over_pairs(of_sheet(spectra, sheet, rules)), told, title, rules_apart(told))
    save(figure, *output.rules_figure)


if "snakemake" in globals():
    given, made, mill = snakemake.input, snakemake.output, MillConfig(**snakemake.params.mill)
    with job(snakemake.log[0], f"draw {mill.name}"):
        draw_sheet(given, made, mill, ContactConfig(**snakemake.params.contact))
        draw_spectra(given, made, mill.title, snakemake.params.rules)
