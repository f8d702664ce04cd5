"""Shows the snapshots of a run: balls and jar from above and from the side, coloured by speed, or files for ParaView.

    millprint animate results/dem/MILL/CONTACT/CASE/run.h5 --out mill.gif
    millprint export results/dem/MILL/CONTACT/CASE/run.h5 --every 20

For ParaView: run.vtkhdf (balls), run_walls.vtkhdf and run_contacts.vtkhdf.
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.arguments import value_of, value_of_key
from millprint.config.load import check_model
from millprint.config.section import Count, NonNegative
from millprint.config.view import ViewConfig

PARTS = ("", "_walls", "_contacts")


def main(arguments: list[str], name: str) -> None:
    """Write the animation, or the three files."""
    parser, own = parser_of(name, __doc__), ViewConfig()
    add = parser.add_argument
    add("run", type=Path, help="run.h5 of a case with snapshots")
    if name == "export":
        add("--every", type=value_of("every", Count), default=1, help="write every n-th snapshot (default 1)")
        add("--out", type=Path, help="folder of the files (default: that of run.h5)")
        export(**vars(parser.parse_args(arguments)))
        return
    add("--out", type=Path, help=".gif or animated .png (default: mill.gif next to run.h5)")
    start = value_of("start_s", NonNegative)
    add("--start", type=start, metavar="S", help="time of the first frame after the start [s]")
    for key in ("revolutions", "frames_per_revolution"):
        kind, default = value_of_key(ViewConfig, key), getattr(own, key)
        add(f"--{key.replace('_', '-')}", type=kind, default=default, metavar="N", help="(default %(default)g)")
    animate(**vars(parser.parse_args(arguments)))


def animate(run: Path, out: Path | None, start: float | None, **keys: float) -> None:
    """Write the animation. keys: of ViewConfig."""
    from millprint.figures.animation import save_animation
    from millprint.view.frames import read_movie

    out = out or run.parent / "mill.gif"
    movie = read_movie(run, check_model(keys, ViewConfig, "command line"), start)
    save_animation(movie, out)
    print(f"{len(movie.frames)} frames, {movie.pace} than real time, written to {out}")


def export(run: Path, every: int, out: Path | None) -> None:
    """Write the three files."""
    from millprint.view.paraview import export_run

    balls, walls, contacts = files = [(out or run.parent) / f"{run.stem}{part}.vtkhdf" for part in PARTS]
    count = export_run(run, balls, walls, contacts, every)
    print(f"{count} snapshots written to {', '.join(map(str, files))}")
