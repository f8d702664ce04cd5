"""Temperatures of balls, powder and jar of every simulated condition of a mill: tables and figures.

Settings: dose.heat; the title of the mill.
Inputs: `summaries` and their `runs`.
Outputs: `sources`, `parameters`, `temperatures`, `limits`, `flash`, and the figure.
"""

from collections.abc import Sequence

from millprint.config.dose import HeatConfig
from millprint.dose.flash import flash_table
from millprint.dose.heat_balance import HeatTables, heat_tables, read_sources, source_table
from millprint.figures.dose_figures import plot_heat
from millprint.figures.style import save
from millprint.run.files import write_table
from millprint.run.job import job, progress


def main(files: Sequence[tuple[str, str]], output, *, mill: str, title: str, settings: HeatConfig) -> HeatTables:
    """Write tables and figure. files: pairs of summary and run.h5."""
    sources = read_sources(files)
    with progress(len(sources), f"heat balance of {mill}", "condition") as bar:
        tables = heat_tables(settings, mill, sources, bar.update)
    flash = flash_table(files, settings.flash)
    write_table(source_table(sources), output.sources)
    write_table(tables.parameters, output.parameters)
    write_table(tables.temperatures, output.temperatures)
    write_table(tables.limits, output.limits)
    write_table(flash, output.flash)
    save(plot_heat(tables.temperatures, tables.limits, title), *output.figure)
    return tables


if "snakemake" in globals():
    given, mill = snakemake.input, snakemake.wildcards.mill
    files = list(zip(given.summaries, given.runs, strict=True))
    with job(snakemake.log[0], f"heat balance of {mill}") as logger:
        settings = HeatConfig(**snakemake.params.settings)
        found = main(files, snakemake.output, mill=mill, title=snakemake.params.title, settings=settings)
        for line in found.limits.to_dict("records"):
            logger.info(
                "%s, %s: %.3g W, balls %.3g to %.3g degC after long milling, energy balance open by %.1e",
                mill, line["condition"], line["total_W"], line["balls_steady_degC_lower"],
                line["balls_steady_degC_upper"], line["balance_error"],
            )  # fmt: skip
