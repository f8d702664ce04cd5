"""Writes the snapshots of a run for ParaView: run.vtkhdf (balls), run_walls.vtkhdf and run_contacts.vtkhdf.

millprint export results/dem/MILL/CONTACT/CASE/run.h5 --every 20
"""

from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.view.paraview import export_run

PARTS = ("", "_walls", "_contacts")


def main(arguments: list[str], name: str = "export") -> None:
    """Write the three files."""
    parser = parser_of(name, __doc__)
    parser.add_argument("run", type=Path, help="run.h5 of a case with snapshots")
    parser.add_argument("--every", type=int, default=1, help="write every n-th snapshot (default 1)")
    parser.add_argument("--out", type=Path, help="folder of the files (default: that of run.h5)")
    chosen = parser.parse_args(arguments)
    balls, walls, contacts = files = [
        (chosen.out or chosen.run.parent) / f"{chosen.run.stem}{part}.vtkhdf" for part in PARTS
    ]
    count = export_run(chosen.run, balls, walls, contacts, chosen.every)
    print(f"{count} snapshots written to {', '.join(map(str, files))}")
