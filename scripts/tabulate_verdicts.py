"""The verdict on every measured number, what each prediction assumes and when it was fixed, and their page."""

import pandas as pd

from millprint.config.contact import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import DemConfig
from millprint.config.validation import ValidationConfig
from millprint.files import read_table, write_table
from millprint.job import job
from millprint.report.chapter_pages import write_chapter
from millprint.validation.fixed import read_fixed, settings_digest, status_of
from millprint.validation.measured import measured_points, read_measurements
from millprint.validation.setups import SETUPS, assumption_table
from millprint.validation.verdicts import count_verdicts, give_verdicts


def main(
    setups: dict[str, dict], dem: DemConfig, predictions: list[str], measured: str, fixed_path: str, output
) -> None:
    """Write the verdicts, their counts and the assumptions.

    setups: for each that was run its `settings`, its `mill` (or none) and its `contacts`, as plain values.
    """
    fixed, statuses, assumed = read_fixed(fixed_path), {}, []
    for name, given in setups.items():
        settings = type(getattr(ValidationConfig(), name))(**given["settings"])
        mill = MillConfig(**given["mill"]) if given["mill"] else None
        contacts = {contact["name"]: ContactConfig(**contact) for contact in given["contacts"]}
        statuses[name] = status_of(name, settings_digest(settings, mill, contacts, dem), fixed)
        assumed += [{**row, "settings": statuses[name]} for row in assumption_table(name, settings, mill, contacts)]
    tables = [
        read_table(
            path,
            numeric=["x", "predicted", "lower", "upper"],
            text=["id", "quantity", "unit", "model", "interval"],
            may_be_blank=["x", "lower", "upper"],
        )
        for path in predictions
    ]
    points = measured_points(read_measurements(measured, SETUPS))
    unknown = [name for name, setup in SETUPS.items() if not setup.known]
    verdicts = give_verdicts(points, pd.concat(tables), statuses, unknown=unknown)
    write_table(verdicts, output.verdicts)
    write_table(count_verdicts(verdicts), output.counts)
    write_table(pd.DataFrame(assumed), output.assumptions)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate verdicts"):
        main(
            snakemake.params.setups,
            DemConfig(**snakemake.params.dem),
            list(snakemake.input.predictions),
            snakemake.input.measured,
            snakemake.input.fixed,
            snakemake.output,
        )
        own, made = snakemake.params, snakemake.output
        tables = made.verdicts, made.counts, made.assumptions
        write_chapter(own.chapter, own.name, tables, own.results, made.page)
