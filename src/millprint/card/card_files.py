"""The files of a card: JSON, one page, methods paragraph, table, references and animation."""

import shutil
import tempfile
from pathlib import Path
from typing import NamedTuple

from millprint.card.card_model import MillingCard
from millprint.card.latex import bibtex, latex_table
from millprint.cases.table import ANIMATION
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.run import run_case
from millprint.run.files import whole_file, write_json
from millprint.view.frames import read_movie
from millprint.view.mill_picture import picture_mill


class CardFiles(NamedTuple):
    """The names of a card's files in its folder."""

    card: str = "card.json"
    svg: str = "card.svg"
    png: str = "card.png"
    pdf: str = "card.pdf"
    tsv: str = "card.tsv"
    methods: str = "methods.txt"
    table: str = "table.tex"
    references: str = "references.bib"


FILES = CardFiles()
GIF = "mill.gif"


def write_card(card: MillingCard, mill: MillConfig, folder: str | Path) -> None:
    """Write the files of CardFiles."""
    # Imported here: slow to import, and not needed by tests of texts.
    from millprint.figures.card_figures import plot_card
    from millprint.figures.style import save

    folder = Path(folder)
    page = (folder / name for name in (FILES.svg, FILES.png, FILES.pdf, FILES.tsv))
    save(plot_card(card, picture_mill(mill)), *page)
    for name, text in (
        (FILES.methods, card.methods + "\n"),
        (FILES.table, latex_table(card)),
        (FILES.references, bibtex(card)),
    ):
        with whole_file(folder / name) as partial:
            partial.write_text(text, encoding="utf-8")
    # Written last, so that a folder with a card is complete.
    write_json(card.model_dump(mode="json"), folder / FILES.card)


def animate(case: Case, mill: MillConfig, contact: ContactConfig, dem: DemConfig, path: str | Path) -> None:
    """Simulate a case with snapshots in the folder of `path`, and draw its animation there (.gif)."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".animation.", dir=path.parent) as folder:
        run = Path(folder) / "run.h5"
        run_case(case, mill, contact, dem, run, run.with_name("summary.json"))
        draw_run(run, path)


def draw_run(run: Path, gif: Path) -> None:
    """Draw the animation of a run with snapshots."""
    # Imported here: slow to import, and only one process needs it.
    from millprint.figures.animation import save_animation

    save_animation(read_movie(run, ANIMATION), gif)


def remove_left_overs(folder: str | Path) -> None:
    """Remove what killed calls of `animate` have left in a folder."""
    for left in Path(folder).glob(".animation.*"):
        shutil.rmtree(left, ignore_errors=True)
