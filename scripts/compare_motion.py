"""Draws the balls of roll-outs next to those of the simulation, as a figure and as animations.

Settings: variant and test of each pair, and the test on the motion of the training.
Inputs: `rollouts` and `runs`.
Outputs: `stills`, `pngs`, `tsvs`, `gifs`, `movies`.
"""

import numpy as np

from millprint.figures.animation import save_animation
from millprint.figures.style import save
from millprint.run.job import job
from millprint.thesis.figures.chapter6_figures import plot_motion
from millprint.thesis.surrogate.rollout import RollOut
from millprint.thesis.surrogate.rollout_evaluation import movie_side_by_side

# Moments of the figure, as fractions of the length of the animation: while the errors grow, and after.
MOMENTS = (0.0, 0.1, 0.4, 1.0)

# Two revolutions, or the length of the roll-out; time of motion between two frames [s]; frames shown per
# second [1/s].
LENGTH_S, FRAME_INTERVAL_S, FRAMES_PER_SECOND = 0.4, 0.008, 15


def main(path: str, run: str, svg: str, png: str, tsv: str, animations: list[str]) -> None:
    rollout = RollOut.read(path)
    interval_s = rollout.time_s[1] - rollout.time_s[0]
    last = min(len(rollout.time_s) - 1, round(LENGTH_S / interval_s))
    every = max(1, min(last, round(FRAME_INTERVAL_S / interval_s)))
    movie = movie_side_by_side(
        run,
        rollout.start_s[0] + rollout.time_s[: last + 1],
        rollout.position_m[: last + 1, 0],
        rollout.velocity_m_s[: last + 1, 0],
        every,
        FRAMES_PER_SECOND,
    )
    moments = np.unique(np.rint(np.array(MOMENTS) * (len(movie.frames) - 1)).astype(int)).tolist()
    save(plot_motion(movie, moments), svg, png, tsv=tsv)
    save_animation(movie, *animations)


if "snakemake" in globals():
    with job(snakemake.log[0], "draw the balls of the surrogates") as log:
        given, made, own = snakemake.input, snakemake.output, snakemake.params
        movies, drawings = iter(made.movies), zip(made.stills, made.pngs, made.tsvs, strict=True)
        files = zip(own.moved, given.rollouts, given.runs, drawings, made.gifs, strict=True)
        for (variant, test), rollout, run, drawing, gif in files:
            animations = [gif, next(movies)] if test == own.trained else [gif]
            main(rollout, run, *drawing, animations)
            log.info("drawn: %s, %s", variant, test)
