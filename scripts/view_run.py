"""Shows the snapshots of a run: an animation, balls and jar coloured by speed, or files for ParaView.

Settings: view.
Inputs: `run`: run.h5 with snapshots.
Outputs: `gif` and `png`; or `balls`, `walls`, `contacts` (run.vtkhdf, run_walls.vtkhdf, run_contacts.vtkhdf).
"""

from millprint.config.view import ViewConfig
from millprint.figures.animation import save_animation
from millprint.run.job import job
from millprint.view.frames import read_movie
from millprint.view.paraview import export_run

if "snakemake" in globals():
    run, made = snakemake.input.run, snakemake.output
    with job(snakemake.log[0], "show run") as log:
        if made.get("gif"):
            movie = read_movie(run, ViewConfig(**snakemake.params.settings))
            save_animation(movie, made.gif, made.png)
            log.info("%d frames, %s than real time", len(movie.frames), movie.pace)
        else:
            log.info("%d snapshots", export_run(run, *made))
