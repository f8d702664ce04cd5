"""Draws what the surrogate is given: the signed distance of the jar and where balls touch its wall."""

import numpy as np

from millprint.config.surrogate import EdgeConfig
from millprint.figures.chapter6 import plot_distance_slices, plot_wall_contacts
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job
from millprint.surrogate.scene import read_scene
from millprint.surrogate.section import section
from millprint.surrogate.wall_contacts import covered_share


def main(run: str, wall_contacts: str, outputs: dict[str, str], rule: EdgeConfig) -> None:
    scene = read_scene(run)
    table = read_table(wall_contacts, numeric=["low_m", "high_m", "contacts"])
    height = scene.bounds_m[:, 2]
    # One section through the middle of the jar, one at the height of a ball's centre that lies on the floor.
    slices = [
        section(scene, "y", float(np.mean(scene.bounds_m[:, 1]))),
        section(scene, "z", float(height[0] + scene.ball_radius_m)),
    ]
    save(plot_distance_slices(slices), outputs["slices_svg"], outputs["slices_png"])
    share = covered_share(table, rule.wall_threshold_m)
    save(plot_wall_contacts(table, rule.wall_threshold_m, share), outputs["contacts_svg"], outputs["contacts_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], "draw the surrogate's data"):
        main(
            snakemake.input.run,
            snakemake.input.wall_contacts,
            dict(snakemake.output.items()),
            EdgeConfig(**snakemake.params.edges),
        )
