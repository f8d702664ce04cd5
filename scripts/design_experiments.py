"""Makes the design, its alias table and randomised run order, and compares the runs with it."""

from pathlib import Path

from millprint.config.design import DesignConfig
from millprint.doe.aliases import alias_table, confounding_table
from millprint.doe.audit import audit_table
from millprint.doe.design import describe, design_table
from millprint.doe.runs import read_runs
from millprint.files import write_json, write_table
from millprint.job import job

# The tables of the design, by the names of the rule's outputs.
TABLES = ("design", "aliases", "confounding", "audit")


def paths_in(folder: str | Path) -> dict[str, str]:
    """The path of every file of the design in a folder."""
    names = [*(f"{name}.tsv" for name in TABLES), "fraction.json"]
    return {name.partition(".")[0]: str(Path(folder) / name) for name in names}


def main(
    screening: str, design: str, fraction: str, aliases: str, confounding: str, audit: str, settings: DesignConfig
) -> list[str]:
    """Write the tables of the design, and return one line for each departure of the runs from it."""
    runs = read_runs(screening, settings.factors)
    write_table(design_table(settings), design)
    write_json(describe(settings), fraction)
    write_table(alias_table(settings), aliases)
    write_table(confounding_table(settings, runs), confounding)
    found = audit_table(settings, runs)
    write_table(found, audit)
    departures = found[found["departs"] == "yes"]
    return [f"{row.check}, {row.subject}: {row.found}, planned {row.wanted}" for row in departures.itertuples()]


if "snakemake" in globals():
    with job(snakemake.log[0], "design experiments") as log:
        settings = DesignConfig(**snakemake.params.design)
        for line in main(snakemake.input.screening, **dict(snakemake.output.items()), settings=settings):
            log.warning("the runs depart from the design: %s", line)
