"""A page with the tables of a chapter, to sort and filter."""

from collections.abc import Collection

from millprint.run.files import read_table, whole_file
from millprint.thesis.report.catalogue import TABLES
from millprint.thesis.report.table_pages import Section, tables_page


def write_chapter(chapter: str, name: str, tables: Collection[str], results: str, output: str) -> None:
    """Write the page of a chapter, with those of its tables in the folder `results` that `tables` lists.

    name: of the run.
    """
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
