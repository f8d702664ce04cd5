"""Draws docs/pictures/planetary_fingerprint.png from a run of the planetary mill: python tools/draw_pictures.py FOLDER.

FOLDER is where `millprint fingerprint planetary` was run. The page carries what it was made of, and a test compares
that with the present code.
"""

import argparse
import hashlib
from io import BytesIO
from pathlib import Path

import pandas as pd
from PIL import Image, PngImagePlugin

from millprint.config.included import load_mill
from millprint.dem import PHYSICS
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, temperature_rows, with_rows
from millprint.figures.mill_sheet_figure import plot_sheet
from millprint.fingerprint.descriptors import read_descriptors
from millprint.run.files import read_table
from millprint.view.mill_picture import picture_mill

PAGE = Path(__file__).parents[1] / "docs/pictures/planetary_fingerprint.png"
MILL = "planetary"
DPI, COLOURS = 150, 64


def made_of(sheet: pd.DataFrame) -> str:
    """What a page shows: the version of the physics, and a digest of the names of its rows."""
    rows = sheet[sheet["section"].isin(["mill", "condition", "descriptors", "dose", "exponents"])]
    return f"physics {PHYSICS}, rows {hashlib.sha256(' '.join(rows['quantity']).encode()).hexdigest()[:16]}"


def draw(results: Path) -> None:
    """Draw the page."""
    mill, dose = results / "mills" / MILL, results / "dose"
    own = read_table(mill / "fingerprint.tsv")
    sheet = with_rows(own, temperature_rows(read_table(dose / "heat" / MILL / "limits.tsv"), own))
    spectra = [of_sheet(read_spectra(dose / MILL / name), sheet) for name in ("spectra.tsv", "spectra_summary.tsv")]
    descriptors, curves = read_descriptors(mill / "descriptors.tsv"), read_table(mill / "curves.tsv")
    buffer = BytesIO()
    plot_sheet(picture_mill(load_mill(MILL)), sheet, descriptors, curves, *spectra).savefig(buffer, dpi=DPI)
    told = PngImagePlugin.PngInfo()
    told.add_text("made of", made_of(own))
    few = Image.open(buffer).convert("RGB").quantize(COLOURS)
    few.save(PAGE, optimize=True, pnginfo=told)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="the folder of the run")
    draw(parser.parse_args().folder / "results")
