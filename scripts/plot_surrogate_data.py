"""Draws the input of the surrogate: the signed distance of the jar, and where balls touch its wall."""

import numpy as np

from millprint.config.surrogate import EdgeConfig
from millprint.figures.chapter6 import plot_distance_slices, plot_recursion, plot_wall_contacts
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job
from millprint.surrogate.scene import read_scene
from millprint.surrogate.tables import covered_share
from millprint.surrogate.trajectory import read_attributes


def main(
    run: str, wall_contacts: str, outputs: dict[str, str], window: int, edges: EdgeConfig, snap_back_m: float | None
) -> None:
    scene = read_scene(run)
    table = read_table(wall_contacts, numeric=["low_m", "high_m", "contacts"])
    height = scene.bounds_m[:, 2]
    # One section through the middle of the jar, one at the height of the centre of a ball on the floor.
    slices = [
        scene.section("y", float(np.mean(scene.bounds_m[:, 1]))),
        scene.section("z", float(height[0] + scene.ball_radius_m)),
    ]
    save(plot_distance_slices(slices), outputs["slices_svg"], outputs["slices_png"])
    threshold_m = edges.wall_threshold_m
    contacts = plot_wall_contacts(table, threshold_m, covered_share(table, threshold_m))
    save(contacts, outputs["contacts_svg"], outputs["contacts_png"])
    step_s = read_attributes(run)["case"]["snapshot_interval_s"]
    save(plot_recursion(window, edges, snap_back_m, step_s), outputs["loop_svg"], outputs["loop_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], "draw the surrogate's data"):
        main(
            snakemake.input.run,
            snakemake.input.wall_contacts,
            dict(snakemake.output.items()),
            snakemake.params.window,
            EdgeConfig(**snakemake.params.edges),
            snakemake.params.snap_back_m,
        )
