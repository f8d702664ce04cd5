"""The oscillating ball: the friction pair that fits one track, simulated or measured.

Settings: calibration.oscillation, calibration.interval, dem.rayleigh_fraction_max; the experiment with its mills and
contact set.
Inputs: a measured `track`, if any.
Outputs: `track`, `fit`, `profile`, `paths`.
"""

from millprint.config.calibration import ExperimentConfig, SwingConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.friction_fit import fit_experiment

if "snakemake" in globals():
    with job(snakemake.log[0], f"fit friction of {snakemake.wildcards.experiment}"):
        tables = fit_experiment(
            ExperimentConfig(**snakemake.params.experiment),
            {name: MillConfig(**mill) for name, mill in snakemake.params.mills.items()},
            ContactConfig(**snakemake.params.contact),
            snakemake.params.rayleigh_fraction_max,
            SwingConfig(**snakemake.params.settings),
            snakemake.params.interval,
        )
        for name, table in tables.items():
            write_table(table, snakemake.output[name])
