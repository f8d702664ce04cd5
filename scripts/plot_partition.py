"""Figures 4.3 to 4.5: yield, specific yield and converted mass per watt against fill ratio."""

from millprint.figures.chapter4 import plot_mass_per_watt, plot_specific_yield, plot_yield
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def main(inputs, output) -> None:
    """Draw the cases of chapter 4."""
    cases, judged = read_table(inputs.table_4_2), read_table(inputs.table_4_4)
    cases = cases[cases["curves"] == "published"]
    published, ours = (judged[judged["curves"] == name] for name in ("published", "ours"))
    save(plot_yield(cases, read_table(inputs.slopes)), output.yield_svg, output.yield_png)
    save(plot_specific_yield(published, ours), output.specific_svg, output.specific_png)
    save(plot_mass_per_watt(published, ours), output.mass_svg, output.mass_png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot partition"):
        main(snakemake.input, snakemake.output)
