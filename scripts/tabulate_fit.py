"""The values that the jar and the counting rule were fitted to, those held back, and the error of each.

And the jars and counting rules that fit equally well. Or what the fit leaves open of the shape of the jar, as factors
on what its fingerprint predicts.

Settings: fit, fingerprint.counting_rule, fingerprint.interval; the mill.
Inputs: `published`; `descriptors`, `cycles`, `sensitivity` and `equal_jars`, or `search` (fit_search.tsv).
Outputs: `fit`, and `equal` where the fit names such jars; or `shape`.
"""

import numpy as np

from millprint.config.fit import JarSearch
from millprint.config.mill import MillConfig
from millprint.run.files import read_table, write_json, write_table
from millprint.run.job import job
from millprint.thesis.curves.regimes import read_published
from millprint.thesis.fit.jar_search import JAR_PARAMETERS, fit_table, parameter_rows, parameters_of
from millprint.thesis.fit.published import computed_values, published_values, with_roles

TEXT = ["mill", "contact", "varied"]

if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    mill, settings = MillConfig(**own.mill), JarSearch(**own.settings)
    with job(snakemake.log[0], "tabulate the fit") as logger:
        values, jar = published_values(read_published(*given.published), settings.contact), parameters_of(mill.geometry)
        if made.get("shape"):
            # Slow to import, and the table of the fit does not need it.
            from millprint.thesis.fit.open_shape import shape_factors

            search = read_table(given.search, numeric=JAR_PARAMETERS, text=["counting_rule"])
            printed = dict(zip(values["name"], values["published"], strict=True))
            rule = {"counting_rule": own.counting_rule, "probability": own.probability}
            factors = shape_factors(search, printed, settings, jar, mill=mill.name, **rule)
            write_json(factors.model_dump(mode="json"), made.shape)
        else:
            tables = [read_table(path, text=TEXT) for path in (given.descriptors, given.cycles)]
            values = computed_values(with_roles(values, settings.fitted), *tables, mill.name, settings.contact)
            values = values.assign(counting_rule=own.counting_rule)
            parameters = parameter_rows(jar, mill.geometry.end_radius_mm, own.counting_rule)
            write_table(fit_table(parameters, values, read_table(given.sensitivity)), made.fit)
            if made.get("equal"):
                jars = read_table(given.equal_jars, text=["counting_rule"])
                simulated = np.where(jars["jar"] <= settings.equal_jars, "yes", "no")
                write_table(jars.assign(simulated=simulated), made.equal)
            for role, part in values.groupby("role"):
                worst = part["error_percent"].abs().max()
                logger.info("%s: largest error %.1f %% of %d values", role, worst, len(part))
