"""Tabulates what each study of the literature leaves unreported, and plots yield against speed."""

from millprint.doe.literature import read_literature, unreported_table
from millprint.figures.chapter2 import literature
from millprint.figures.style import save
from millprint.files import write_table
from millprint.job import job


def main(studies: str, unreported: str, svg: str, png: str) -> None:
    """Write the table and the figure."""
    frame = read_literature(studies)
    write_table(unreported_table(frame), unreported)
    save(literature(frame), svg, png)


if "snakemake" in globals():
    with job(snakemake.log[0], "tabulate literature"):
        main(**dict(snakemake.input.items()), **dict(snakemake.output.items()))
