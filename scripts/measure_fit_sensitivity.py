"""Effect of one step of each parameter of the jar on the fitted values, from short simulations.

Settings: fit, dem; the mill and its contact set.
Inputs: `published`.
Outputs: `sensitivity`.
"""

from millprint.config.contact_set import ContactConfig
from millprint.config.fit import JarSearch
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.fit.jar_search import parameters_of, sensitivity_rows, trial_of

if "snakemake" in globals():
    with job(snakemake.log[0], "sensitivity of the fit"):
        mill, settings = MillConfig(**snakemake.params.mill), JarSearch(**snakemake.params.settings)
        contact, dem = ContactConfig(**snakemake.params.contact), DemConfig(**snakemake.params.dem)
        trial = trial_of(mill, contact, dem, settings, snakemake.input.published)
        write_table(sensitivity_rows(parameters_of(mill.geometry), settings, trial), snakemake.output.sensitivity)
