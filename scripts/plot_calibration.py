"""Figures: the restitution of every drop; the track of each oscillating ball and its fit (Fig. 3.3)."""

from millprint.figures.calibration import plot_drops, plot_friction_fit
from millprint.figures.style import save
from millprint.files import read_table
from millprint.job import job


def draw_drops(drops_path: str, restitution_path: str, svg: str, png: str) -> None:
    """Draw every drop and the mean of each contact set."""
    drops = read_table(drops_path, numeric=["drop_height_mm", "restitution"], text=["contact"])
    means = read_table(restitution_path, numeric=["mean", "lower", "upper"], text=["contact"])
    save(plot_drops(drops, means), svg, png)


def draw_fit(track_path: str, fit_path: str, profile_path: str, paths_path: str, svg: str, png: str) -> None:
    """Draw a track with its fit and the profiles of both coefficients."""
    track = read_table(track_path, numeric=["time_s"])
    fit = read_table(fit_path, numeric=["estimate", "lower", "upper"], text=["parameter"])
    profile = read_table(profile_path, numeric=["value", "excess", "threshold"], text=["parameter"])
    paths = read_table(paths_path, numeric=["time_s", "across_mm", "height_mm"], text=["path"])
    save(plot_friction_fit(track, paths, fit, profile), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], "plot the calibration"):
        given, made = snakemake.input, snakemake.output
        draw_drops(given.drops, given.restitution, made.drops_svg, made.drops_png)
        for files in zip(
            given.track, given.fit, given.profile, given.paths, made.friction_svgs, made.friction_pngs, strict=True
        ):
            draw_fit(*files)
