"""Draws the geometry of a mill, and its motion as a row of pictures."""

from millprint.config.mill import MillConfig
from millprint.figures.mills import plot_geometry, plot_motion
from millprint.figures.style import save
from millprint.job import job
from millprint.view.mill_picture import picture_mill

if "snakemake" in globals():
    with job(snakemake.log[0], f"draw {snakemake.params.mill['name']}"):
        picture = picture_mill(MillConfig(**snakemake.params.mill))
        save(plot_geometry(picture), snakemake.output.geometry_svg, snakemake.output.geometry_png)
        save(plot_motion(picture), snakemake.output.motion_svg, snakemake.output.motion_png)
