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


def draw_geometry(output, mill: MillConfig) -> None:
    """Draw geometry and motion, and write the points of both."""
    picture = picture_mill(mill)
    save(plot_geometry(picture), *output.geometry_figure, tsv=output.geometry_tsv)
    save(plot_motion(picture), *output.motion_figure, tsv=output.motion_tsv)


if "snakemake" in globals():
    mill = MillConfig(**snakemake.params.mill)
    with job(snakemake.log[0], f"draw {mill.name}"):
        draw_geometry(snakemake.output, mill)
