"""Tabulates what other groups report, do not report and contradict; plots their yields against speed."""

from millprint.doe.literature import (
    literature_checks,
    missingness_table,
    read_literature,
    read_reported_yields,
    unreported_table,
)
from millprint.figures.chapter2 import literature, missingness
from millprint.figures.style import save
from millprint.files import write_table
from millprint.job import job


def main(studies: str, yields: str, outputs: dict[str, str]) -> None:
    """Write the tables and both figures; `outputs` has the path of each."""
    frame, reported = read_literature(studies), read_reported_yields(yields)
    write_table(unreported_table(frame), outputs["unreported"])
    missing = missingness_table(frame)
    write_table(missing, outputs["missingness"])
    write_table(literature_checks(frame, reported), outputs["checks"])
    save(literature(frame, reported), outputs["svg"], outputs["png"], tsv=outputs["tsv"])
    save(missingness(missing), outputs["missingness_svg"], outputs["missingness_png"])


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate literature"):
        main(snakemake.input.studies, snakemake.input.yields, dict(snakemake.output.items()))
