"""Animates the mill from the snapshots of a run: balls and jar from above and from the side, coloured by speed.

By Snakemake, or by hand: python scripts/animate_run.py results/dem/MILL/CONTACT/CASE/run.h5
"""

import argparse
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.config.load import check_model
from millprint.config.meanings import meaning_of
from millprint.config.view import ViewConfig
from millprint.figures.animation import save_animation
from millprint.run.job import job
from millprint.view.frames import read_movie


def main() -> None:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="run.h5 of a case with snapshots")
    parser.add_argument("--out", type=Path, help=".gif or animated .png (default: mill.gif next to run.h5)")
    parser.add_argument("--start", type=float, metavar="S", help="time of the first frame after the start [s]")
    for key in ("revolutions", "frames_per_revolution"):
        field, meaning = ViewConfig.model_fields[key], meaning_of(ViewConfig, key)
        parser.add_argument(
            f"--{key.replace('_', '-')}",
            type=field.annotation,
            default=field.default,
            metavar="N",
            help=f"{meaning} (default {field.default:g})",
        )
    chosen = parser.parse_args()
    out = chosen.out or chosen.run.parent / "mill.gif"
    with stop_on_bad_input():
        keys = {key: getattr(chosen, key) for key in ViewConfig.model_fields if hasattr(chosen, key)}
        movie = read_movie(chosen.run, check_model(keys, ViewConfig, "command line"), chosen.start)
        save_animation(movie, out)
        print(f"{len(movie.frames)} frames, {movie.slow_motion:.3g} times slower than real time, written to {out}")


if "snakemake" in globals():
    with job(snakemake.log[0], "animate run") as log:
        movie = read_movie(snakemake.input.run, ViewConfig(**snakemake.params.settings))
        save_animation(movie, snakemake.output.gif, snakemake.output.png)
        log.info("%d frames, %.3g times slower than real time", len(movie.frames), movie.slow_motion)
elif __name__ == "__main__":
    main()
