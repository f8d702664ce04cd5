"""Compiles the DEM kernels before any simulation, so that no simulation has to wait for it.

Settings: none.
Inputs: none.
Outputs: `report`: how long it took, as JSON.
"""

from millprint.dem.compilation import compile_kernels
from millprint.run.files import write_json
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "compile kernels") as log:
        report = compile_kernels(snakemake.threads)
        log.info("compiled in %.1f s", report["seconds"])
        write_json(report, snakemake.output.report)
