"""Draws a roll-out of the surrogate below the simulation that it started from."""

from millprint.config.view import ViewConfig
from millprint.figures.animation import save_animation
from millprint.job import job
from millprint.surrogate.store import read_rollout
from millprint.view.replay import Replay, read_comparison


def main(run: str, rollout_path: str, outputs: list[str], settings: ViewConfig) -> int:
    """Draw the first trajectory of the batch; returns the number of frames."""
    rollout = read_rollout(rollout_path)
    replay = Replay(
        "surrogate",
        float(rollout.start_s[0]),
        rollout.time_s,
        rollout.position_m[:, 0].astype(float),
        rollout.velocity_m_s[:, 0].astype(float),
    )
    movie = read_comparison(run, replay, settings)
    save_animation(movie, *outputs)
    return len(movie.frames)


if "snakemake" in globals():
    with job(snakemake.log[0], "animate surrogate") as logger:
        frames = main(
            snakemake.input.run,
            snakemake.input.rollout,
            list(snakemake.output),
            ViewConfig(**snakemake.params.settings),
        )
        logger.info("%d frames", frames)
