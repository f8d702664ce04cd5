"""Writes a page for each of some chapters, with its tables, which can be sorted and filtered."""

from millprint.files import read_table, whole_file
from millprint.job import job
from millprint.report.catalogue import TABLES
from millprint.report.tables import Section, tables_page


def main(chapter: str, name: str, tables: list[str], results: str, output: str) -> None:
    """Write the page of one chapter, with those of its tables in the folder `results` that `tables` lists."""
    sections = [
        Section(listed.title, read_table(path), f"{listed.note} {listed.path}".strip())
        for listed in TABLES[chapter]
        if (path := f"{results}/{listed.path}") in tables
    ]
    title, about = (
        (f"Chapter {chapter}", f"thesis chapter {chapter}") if chapter.isdigit() else (chapter, chapter.lower())
    )
    introduction = f"Tables of {about} as the run {name} computed them. A click on a column sorts by it."
    with whole_file(output) as partial:
        partial.write_text(tables_page(f"{title}: tables", introduction, sections))


if "snakemake" in globals():
    chapters = snakemake.params.chapters
    with job(snakemake.log[0], f"show the tables of {', '.join(chapters)}"):
        tables = list(snakemake.input.tables)
        for chapter, page in zip(chapters, snakemake.output.pages, strict=True):
            main(chapter, snakemake.params.name, tables, snakemake.params.results, page)
