"""Shows the tables of a chapter on a page on which they sort and filter."""

from millprint.files import read_table, whole_file
from millprint.job import job
from millprint.report.catalogue import TABLES
from millprint.report.tables import Section, tables_page


def main(chapter: str, name: str, tables: list[str], output: str) -> None:
    """Write the page of one chapter; `tables` are the files of TABLES[chapter] in that order."""
    sections = [
        Section(listed.title, read_table(path), " ".join(filter(None, (listed.note, f"{listed.path}"))))
        for listed, path in zip(TABLES[chapter], tables, strict=True)
    ]
    introduction = (
        f"Tables of thesis chapter {chapter} as the run {name} computed them. A click on a column sorts by it."
    )
    with whole_file(output) as partial:
        partial.write_text(tables_page(f"Chapter {chapter}: tables", introduction, sections))


if "snakemake" in globals():
    with job(snakemake.log[0], f"show the tables of chapter {snakemake.wildcards.chapter}"):
        main(
            snakemake.wildcards.chapter,
            snakemake.params.name,
            list(snakemake.input.tables),
            snakemake.output.html,
        )
