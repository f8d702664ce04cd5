"""Searches the jar that agrees best with the fitted published values; writes its geometry for a mill's file.

Or measures the effect of one step of each parameter of the jar on these values, from short simulations.

Settings: fit, dem; the mill and its contact set.
Inputs: `published`.
Outputs: `search` (every jar) and `geometry`; or `sensitivity`.
"""

import yaml

from millprint.config.contact_set import ContactConfig
from millprint.config.fit import JarSearch
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import whole_file, write_table
from millprint.run.job import job
from millprint.thesis.fit.jar_search import Search, parameters_of, sensitivity_rows, shaped, trial_of

if "snakemake" in globals():
    made, own = snakemake.output, snakemake.params
    mill, settings = MillConfig(**own.mill), JarSearch(**own.settings)
    with job(snakemake.log[0], "fit the jar") as logger:
        trial = trial_of(mill, ContactConfig(**own.contact), DemConfig(**own.dem), settings, snakemake.input.published)
        start = parameters_of(mill.geometry)
        if made.get("sensitivity"):
            write_table(sensitivity_rows(start, settings, trial), made.sensitivity)
        else:
            search = Search(settings, trial)
            best = search.run(start)
            write_table(search.table(), made.search)
            geometry = shaped(mill, best).geometry.model_dump(mode="json", exclude_none=True)
            with whole_file(made.geometry) as partial:
                partial.write_text(yaml.safe_dump({"geometry": geometry}, sort_keys=False))
            logger.info("best jar: %s", best)
