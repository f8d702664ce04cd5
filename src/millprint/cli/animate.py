"""Animates the mill from the snapshots of a run: balls and jar from above and from the side, coloured by speed.

millprint animate results/dem/MILL/CONTACT/CASE/run.h5 --out mill.gif
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.load import check_model
from millprint.config.view import ViewConfig
from millprint.figures.animation import save_animation
from millprint.view.frames import read_movie


def main(arguments: list[str], name: str = "animate") -> None:
    """Write the animation."""
    parser = parser_of(name, __doc__)
    parser.add_argument("run", type=Path, help="run.h5 of a case with snapshots")
    parser.add_argument("--out", type=Path, help=".gif or animated .png (default: mill.gif next to run.h5)")
    parser.add_argument("--start", type=float, metavar="S", help="time of the first frame after the start [s]")
    own = ViewConfig()
    turns, frames = own.revolutions, own.frames_per_revolution
    parser.add_argument(
        "--revolutions", type=float, default=turns, metavar="N", help="of the mill (default %(default)g)"
    )
    parser.add_argument("--frames-per-revolution", type=int, default=frames, metavar="N", help="(default %(default)g)")
    chosen = parser.parse_args(arguments)
    out = chosen.out or chosen.run.parent / "mill.gif"
    keys = {key: getattr(chosen, key) for key in ViewConfig.model_fields if hasattr(chosen, key)}
    movie = read_movie(chosen.run, check_model(keys, ViewConfig, "command line"), chosen.start)
    save_animation(movie, out)
    print(f"{len(movie.frames)} frames, {movie.slow_motion:.3g} times slower than real time, written to {out}")
