"""Animates the mill from the snapshots of a run: balls and jar from above and from the side, coloured by speed.

Settings: view.
Inputs: `run`: run.h5 with snapshots.
Outputs: `gif` and `png`.
"""

from millprint.config.view import ViewConfig
from millprint.figures.animation import save_animation
from millprint.run.job import job
from millprint.view.frames import read_movie

if "snakemake" in globals():
    with job(snakemake.log[0], "animate run") as log:
        movie = read_movie(snakemake.input.run, ViewConfig(**snakemake.params.settings))
        save_animation(movie, snakemake.output.gif, snakemake.output.png)
        log.info("%d frames, %.3g times slower than real time", len(movie.frames), movie.slow_motion)
