"""Fits the atlas to its simulations, and compares it with other models on mills that each has not seen.

Settings: the kinds.
Inputs: `simulations`; `included`, the mills and fingerprints of the scaling law.
Outputs: `model`, `comparison`, `learning`.
"""

import pandas as pd

from millprint.atlas.compare_atlas import compared
from millprint.atlas.fit_atlas import fit_atlas, rows_of
from millprint.atlas.kinds import kind_named
from millprint.run.files import read_table, write_json, write_table
from millprint.run.job import job

if "snakemake" in globals():
    with job(snakemake.log[0], "fit atlas"):
        kinds = [kind_named(name) for name in snakemake.params.kinds]
        simulations = read_table(snakemake.input.simulations)
        rows = {kind: rows_of(simulations, kind, "training") for kind in kinds}
        write_json(fit_atlas(rows), snakemake.output.model)
        comparison, learning = zip(*(compared(*each) for each in rows.items()), strict=True)
        write_table(pd.concat(comparison), snakemake.output.comparison, 3)
        write_table(pd.concat(learning), snakemake.output.learning, 3)
