"""Derives the conditions of a mill whose file has no sweep.

Settings: the mill.
Inputs: `sources`: the files of its geometry and motion.
Outputs: `sweep`, as JSON.
"""

from millprint.config.mill import MillConfig
from millprint.mill.default_sweep import default_sweep
from millprint.run.files import write_json
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], f"derive the sweep of {snakemake.params.mill['name']}") as log:
        sweep = default_sweep(MillConfig(**snakemake.params.mill)).model_dump(mode="json")
        log.info("%s", sweep)
        write_json(sweep, snakemake.output.sweep)
