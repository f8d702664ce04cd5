"""Draws the energy spectra of a mill's sweep: over the fill ratio, and by each counting rule.

params: `title`, and counting `rules`. input: the tables `spectra`, `spectra_summary` and `sheet`. output: two figures,
each as SVG and PNG.
"""

from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, over_pairs, rules_apart, shown
from millprint.figures.spectra_figures import plot_rules, plot_spectra
from millprint.figures.style import save
from millprint.run.files import read_table
from millprint.run.job import job


def main(tables, output, title: str, rules: list[str]) -> None:
    """Draw both figures. rules: names of counting rules, that of the descriptors first."""
    sheet = read_table(tables.sheet)
    spectra, read_off = read_spectra(tables.spectra), read_spectra(tables.spectra_summary)
    save(plot_spectra(shown(spectra, rules[0]), title), output.spectra_svg, output.spectra_png)
    told = of_sheet(read_off, sheet, rules)
    figure = plot_rules(over_pairs(of_sheet(spectra, sheet, rules)), told, title, rules_apart(told))
    save(figure, output.rules_svg, output.rules_png)


if "snakemake" in globals():
    with job(snakemake.log[0], f"energy spectra of {snakemake.wildcards.mill}"):
        main(snakemake.input, snakemake.output, snakemake.params.title, snakemake.params.rules)
