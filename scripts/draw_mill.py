"""Draws a mill: its geometry, and its motion as a row of pictures.

Settings: the mill.
Inputs: `sources`: the files of its geometry and motion.
Outputs: the drawings, and the points of both as `geometry_tsv` and `motion_tsv`.
"""

from millprint.config.mill import MillConfig
from millprint.figures.mill_sheet_figure import plot_geometry, plot_motion
from millprint.figures.style import save
from millprint.run.job import job
from millprint.view.frames import picture_mill

if "snakemake" in globals():
    made, mill = snakemake.output, MillConfig(**snakemake.params.mill)
    with job(snakemake.log[0], f"draw {mill.name}"):
        picture = picture_mill(mill)
        save(plot_geometry(picture), *made.geometry_figure, tsv=made.geometry_tsv)
        save(plot_motion(picture), *made.motion_figure, tsv=made.motion_tsv)
