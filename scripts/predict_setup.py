"""The predictions of one measured set-up.

Settings: the settings of the set-up, dem; its mill and contact sets.
Inputs: `measured` and `other_codes`; the `runs` and `tables` of its simulations.
Outputs: `predictions`.
"""

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.setup_models import read_settings, setup_cases
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.validation.measured import measured_points, read_measurements, read_other_codes
from millprint.thesis.validation.setups import SETUPS, predict

if "snakemake" in globals():
    name, given = snakemake.wildcards.setup, snakemake.params
    with job(snakemake.log[0], f"predict set-up {name}"):
        settings = read_settings(name, given.settings)
        dem = DemConfig(**given.dem)
        table = predict(
            name,
            settings,
            MillConfig(**given.mill) if given.mill else None,
            {contact["name"]: ContactConfig(**contact) for contact in given.contacts},
            dem,
            setup_cases(settings, dem),
            given.runs,
            measured_points(read_measurements(snakemake.input.measured, SETUPS)),
            given.folder,
            read_other_codes(snakemake.input.other_codes),
        )
        write_table(table, snakemake.output.predictions)
