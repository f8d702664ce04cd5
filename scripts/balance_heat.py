"""Temperatures of balls, powder and jar of every simulated condition of a mill: tables and figures.

Settings: dose.heat; title and unit of speed of the mill.
Inputs: `summaries` and their `runs`.
Outputs: `sources`, `parameters`, `temperatures`, `limits`, `flash`, and the figure.
"""

from millprint.config.dose import HeatConfig
from millprint.dose.flash import flash_table
from millprint.dose.heat_balance import heat_tables, read_sources, source_table
from millprint.figures.dose_figures import plot_heat
from millprint.figures.style import save
from millprint.run.files import write_table
from millprint.run.job import job, progress

if "snakemake" in globals():
    given, made, mill = snakemake.input, snakemake.output, snakemake.wildcards.mill
    with job(snakemake.log[0], f"heat balance of {mill}") as logger:
        settings, files = HeatConfig(**snakemake.params.settings), list(zip(given.summaries, given.runs, strict=True))
        sources = read_sources(files)
        with progress(len(sources), f"heat balance of {mill}", "condition") as bar:
            tables = heat_tables(settings, mill, sources, bar.update)
        write_table(source_table(sources), made.sources)
        write_table(tables.parameters, made.parameters)
        write_table(tables.temperatures, made.temperatures)
        write_table(tables.limits, made.limits)
        write_table(flash_table(files, settings.flash), made.flash)
        save(
            plot_heat(tables.temperatures, tables.limits, snakemake.params.title, snakemake.params.speed_unit),
            *made.figure,
        )
        for line in tables.limits.to_dict("records"):
            logger.info(
                "%s, %s: %.3g W, balls %.3g to %.3g degC after long milling, energy balance open by %.1e",
                mill, line["condition"], line["total_W"], line["balls_steady_degC_lower"],
                line["balls_steady_degC_upper"], line["balance_error"],
            )  # fmt: skip
