"""Searches the jar that agrees best with the fitted published values; writes its geometry for a mill's file.

Settings: fit, dem; the mill and its contact set.
Inputs: `published`.
Outputs: `search` (every jar) and `geometry`.
"""

import yaml

from millprint.config.contact_set import ContactConfig
from millprint.config.fit import JarSearch
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.run.files import whole_file, write_table
from millprint.run.job import job
from millprint.thesis.fit.jar_search import Search, parameters_of, shaped, trial_of


def main(
    published_paths: list[str], output, mill: MillConfig, contact: ContactConfig, dem: DemConfig, settings: JarSearch
) -> dict[str, float]:
    """Write every jar that was tried, and the geometry of the best one as YAML; return its parameters."""
    search = Search(settings, trial_of(mill, contact, dem, settings, published_paths))
    best = search.run(parameters_of(mill.geometry))
    write_table(search.table(), output.search)
    geometry = shaped(mill, best).geometry.model_dump(mode="json", exclude_none=True)
    with whole_file(output.geometry) as partial:
        partial.write_text(yaml.safe_dump({"geometry": geometry}, sort_keys=False))
    return best


if "snakemake" in globals():
    with job(snakemake.log[0], "fit the jar") as logger:
        found = main(
            snakemake.input.published,
            snakemake.output,
            MillConfig(**snakemake.params.mill),
            ContactConfig(**snakemake.params.contact),
            DemConfig(**snakemake.params.dem),
            JarSearch(**snakemake.params.settings),
        )
        logger.info("best jar: %s", found)
