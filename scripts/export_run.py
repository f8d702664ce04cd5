"""Writes the snapshots of a run for ParaView: run.vtkhdf (balls), run_walls.vtkhdf and run_contacts.vtkhdf.

Settings: none.
Inputs: `run`: run.h5 with snapshots.
Outputs: `balls`, `walls`, `contacts`.
"""

from millprint.run.job import job
from millprint.view.paraview import export_run

if "snakemake" in globals():
    with job(snakemake.log[0], "export run") as log:
        count = export_run(snakemake.input.run, *snakemake.output)
        log.info("%d snapshots", count)
