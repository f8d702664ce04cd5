"""Figure: the charge of a tumbling mill at several speeds. Table: power with both intervals, toe, shoulder, rings."""

from millprint.config.mill import MillConfig
from millprint.config.validation import ValidationConfig
from millprint.figures.charge import plot_charge
from millprint.figures.style import save
from millprint.files import read_table, write_table
from millprint.job import job
from millprint.mill.bodies import build_bodies
from millprint.validation.tumbling import intervals

if "snakemake" in globals():
    name = snakemake.wildcards.setup
    with job(snakemake.log[0], f"plot the charge of {name}"):
        settings = type(getattr(ValidationConfig(), name))(**snakemake.params.settings)
        mill = MillConfig(**snakemake.params.mill)
        table = intervals(read_table(snakemake.input.runs), settings)
        write_table(table, snakemake.output.intervals)
        vessel = build_bodies(mill, settings.speed_rpm(settings.speeds[0]))[0].vessel
        unit = "rpm" if settings.critical_speed_rpm is None else "% of the critical speed"
        figure = plot_charge(read_table(snakemake.input.charge), table, vessel, mill.geometry.axis, unit)
        save(figure, snakemake.output.svg, snakemake.output.png)
