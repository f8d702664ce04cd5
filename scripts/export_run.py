"""Writes the snapshots of a run for ParaView: run.vtkhdf (balls), run_walls.vtkhdf and run_contacts.vtkhdf.

By Snakemake, or by hand: python scripts/export_run.py results/dem/MILL/CONTACT/CASE/run.h5
"""

import argparse
from pathlib import Path

from millprint.config.checks import stop_on_bad_input
from millprint.run.job import job
from millprint.view.paraview import export_run

PARTS = ("", "_walls", "_contacts")


def main() -> None:
    """Parse the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="run.h5 of a case with snapshots")
    parser.add_argument("--every", type=int, default=1, help="write every n-th snapshot (default 1)")
    parser.add_argument("--out", type=Path, help="folder of the files (default: that of run.h5)")
    chosen = parser.parse_args()
    files = [(chosen.out or chosen.run.parent) / f"{chosen.run.stem}{part}.vtkhdf" for part in PARTS]
    with stop_on_bad_input():
        count = export_run(chosen.run, *files, chosen.every)
        print(f"{count} snapshots written to {', '.join(map(str, files))}")


if "snakemake" in globals():
    with job(snakemake.log[0], "export run") as log:
        count = export_run(snakemake.input.run, *snakemake.output)
        log.info("%d snapshots", count)
elif __name__ == "__main__":
    main()
