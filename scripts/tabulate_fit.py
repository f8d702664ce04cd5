"""The values that the jar and the counting rule were fitted to, those held back, and the error of each.

And the jars and counting rules that fit equally well. Or what the fit leaves open of the shape of the jar, as factors
on what its fingerprint predicts.

Settings: fit, fingerprint.counting_rule, fingerprint.interval; the mill.
Inputs: `published`; `descriptors`, `cycles`, `sensitivity`, `equal_jars` and their simulations `of_jars`; or `search`
(fit_search.tsv).
Outputs: `fit`, and `equal` where the fit names such jars; or `shape`.
"""

from millprint.config.calibration import JarSearch
from millprint.config.mill import MillConfig
from millprint.run.files import read_json, read_table, write_json, write_table
from millprint.run.job import job
from millprint.thesis.fit.jar_search import (
    JAR_PARAMETERS,
    computed_values,
    fit_table,
    parameter_rows,
    parameters_of,
    published_values,
    with_roles,
)
from millprint.thesis.fit.open_shape import measured_again, read_equal_jars
from millprint.thesis.regimes import read_published

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
            values = with_roles(values, settings.fitted)
            computed = computed_values(values, *tables, mill.name, settings.contact)
            computed = computed.assign(counting_rule=own.counting_rule)
            parameters = parameter_rows(jar, mill.geometry.end_radius_mm, own.counting_rule)
            write_table(fit_table(parameters, computed, read_table(given.sensitivity)), made.fit)
            if made.get("equal"):
                jars = read_equal_jars(given.equal_jars, settings.counting_rules)
                runs = {number: read_json(path)["runs"] for number, path in enumerate(given.of_jars, start=1)}
                write_table(measured_again(jars, runs, values, mill.name, settings.contact), made.equal)
            for role, part in computed.groupby("role"):
                worst = part["error_percent"].abs().max()
                logger.info("%s: largest error %.1f %% of %d values", role, worst, len(part))
