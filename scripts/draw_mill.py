"""Draws the geometry of each of some mills, and its motion as a row of pictures."""

from millprint.config.mill import MillConfig
from millprint.figures.mill_pictures import plot_geometry, plot_motion
from millprint.figures.style import save
from millprint.job import job
from millprint.view.mill_picture import picture_mill


def main(mill: MillConfig, paths: list[str]) -> None:
    """paths: SVG and PNG of the geometry, then of the motion, then the points of both as TSV."""
    geometry_svg, geometry_png, motion_svg, motion_png, geometry_tsv, motion_tsv = paths
    picture = picture_mill(mill)
    save(plot_geometry(picture), geometry_svg, geometry_png, tsv=geometry_tsv)
    save(plot_motion(picture), motion_svg, motion_png, tsv=motion_tsv)


if "snakemake" in globals():
    mills, paths = snakemake.params.mills, list(snakemake.output)
    with job(snakemake.log[0], f"draw {', '.join(mill['name'] for mill in mills)}"):
        for number, mill in enumerate(mills):
            # All geometries come first in the output, then all motions.
            main(MillConfig(**mill), paths[number :: len(mills)])
