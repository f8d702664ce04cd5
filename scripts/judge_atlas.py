"""Asks the atlas, once it is fitted, for the mills that no model has seen.

Settings: the kinds.
Inputs: `simulations`, `model`; `included`, the mills and fingerprints of the scaling law.
Outputs: `errors`, by kind and model; `regions`, by kind and tenth of the fill ratio.
"""

import pandas as pd

from millprint.atlas.atlas_model import read_model
from millprint.atlas.compare_atlas import judged, regions
from millprint.atlas.fit_atlas import rows_of
from millprint.run.files import read_table, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "judge atlas"):
        simulations, model = read_table(snakemake.input.simulations), read_model(snakemake.input.model)
        parts = {
            name: [rows_of(simulations, model[name].kind, part) for part in ("training", "held_out")]
            for name in snakemake.params.kinds
        }
        write_table(pd.concat([judged(model[name], *parts[name]) for name in parts]), snakemake.output.errors, 3)
        write_table(pd.concat([regions(model[name], parts[name][1]) for name in parts]), snakemake.output.regions, 3)
