"""Draws the geometry of a mill, and its motion as a row of pictures.

Settings: the mill.
Inputs: `sources`: the files of its geometry and motion.
Outputs: the drawings; the points of both as `geometry_tsv` and `motion_tsv`.
"""

from millprint.config.mill import MillConfig
from millprint.figures.mill_pictures import plot_geometry, plot_motion
from millprint.figures.style import save
from millprint.run.job import job
from millprint.view.mill_picture import picture_mill


def main(mill: MillConfig, paths: list[str]) -> None:
    """paths: SVG and PNG of the geometry, then of the motion, then the points of both as TSV."""
    geometry_svg, geometry_png, motion_svg, motion_png, geometry_tsv, motion_tsv = paths
    picture = picture_mill(mill)
    save(plot_geometry(picture), geometry_svg, geometry_png, tsv=geometry_tsv)
    save(plot_motion(picture), motion_svg, motion_png, tsv=motion_tsv)


if "snakemake" in globals():
    mill = MillConfig(**snakemake.params.mill)
    with job(snakemake.log[0], f"draw {mill.name}"):
        main(mill, list(snakemake.output))
