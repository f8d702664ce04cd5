"""Searches the jar that agrees best with the fitted published values; writes its geometry for a mill's file.

Or measures the effect of one step of each parameter of the jar on these values, from short simulations.

Or simulates one of the jars that fit equally well at the conditions of chapter 3.

Settings: fit, dem; the mill and its contact set.
Inputs: `published`; or `equal_jars`.
Outputs: `search` (every jar), `geometry` and `equal_jars`; or `sensitivity`; or `summaries`.
"""

from pathlib import Path

import yaml

from millprint.config.calibration import JarSearch
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import whole_file, write_json, write_table
from millprint.run.job import job
from millprint.thesis.fit.jar_search import Search, parameters_of, sensitivity_rows, shaped, trial_of
from millprint.thesis.fit.open_shape import equally_good, read_equal_jars, simulate_jar

if "snakemake" in globals():
    made, own = snakemake.output, snakemake.params
    mill, settings = MillConfig(**own.mill), JarSearch(**own.settings)
    contact, dem = ContactConfig(**own.contact), DemConfig(**own.dem)
    with job(snakemake.log[0], "fit the jar") as logger:
        if made.get("summaries"):
            jars = read_equal_jars(snakemake.input.equal_jars, settings.counting_rules).drop_duplicates("jar")
            row = jars.set_index("jar").loc[int(snakemake.wildcards.jar)]
            done = Path(f"{made.summaries}.done")
            write_json({"runs": simulate_jar(mill, row, contact, dem, settings, done)}, made.summaries)
            done.unlink()
        else:
            trial = trial_of(mill, contact, dem, settings, snakemake.input.published)
            start = parameters_of(mill.geometry)
        if made.get("sensitivity"):
            write_table(sensitivity_rows(start, settings, trial), made.sensitivity)
        if made.get("search"):
            search = Search(settings, trial)
            best = search.run(start)
            write_table(search.table(), made.search)
            write_table(equally_good(search.table(), settings, start), made.equal_jars)
            geometry = shaped(mill, best).geometry.model_dump(mode="json", exclude_none=True)
            with whole_file(made.geometry) as partial:
                partial.write_text(yaml.safe_dump({"geometry": geometry}, sort_keys=False))
            logger.info("best jar: %s", best)
