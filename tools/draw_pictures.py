"""Draws a page of docs/pictures from a run of the planetary mill: python tools/draw_pictures.py PICTURE FOLDER.

FOLDER is where the command of PICTURE in RUNS was run. The page carries what it was made of and the numbers on it, and
tests compare these with the present code and with the text of the page.
"""

import argparse
import hashlib
import json
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
from millprint.view.frames import picture_mill

PICTURES = Path(__file__).parents[1] / "docs/pictures"
MILL = "planetary"
# Each picture, the command of its run, and the folder of the results.
RUNS = {
    "planetary_fingerprint.png": ("millprint fingerprint planetary", "results"),
    "first_hour_fingerprint.png": ("millprint fingerprint config/first_hour/planetary.yaml", "results/first_hour"),
}
DPI, COLOURS = 150, 64


def made_of(sheet: pd.DataFrame) -> str:
    """What a page shows: the version of the physics, and a digest of the names of its rows."""
    rows = sheet[sheet["section"].isin(["mill", "condition", "descriptors", "dose", "exponents"])]
    return f"physics {PHYSICS}, rows {hashlib.sha256(' '.join(rows['quantity']).encode()).hexdigest()[:16]}"


def numbers_of(sheet: pd.DataFrame) -> dict[str, float]:
    """The numbers of a page, by the names of their rows."""
    own = sheet[sheet["section"].isin(["condition", "descriptors", "dose", "exponents"]) & sheet["value"].notna()]
    return dict(zip(own["quantity"], own["value"].astype(float), strict=True))


def draw(picture: str, folder: Path) -> None:
    """Draw a page."""
    command, place = RUNS[picture]
    results = folder / place
    mill, dose = results / "mills" / MILL, results / "dose"
    own = read_table(mill / "fingerprint.tsv")
    sheet = with_rows(own, temperature_rows(read_table(dose / "heat" / MILL / "limits.tsv"), own))
    spectra = [of_sheet(read_spectra(dose / MILL / name), sheet) for name in ("spectra.tsv", "spectra_summary.tsv")]
    descriptors, curves = read_descriptors(mill / "descriptors.tsv"), read_table(mill / "curves.tsv")
    buffer = BytesIO()
    plot_sheet(picture_mill(load_mill(MILL)), sheet, descriptors, curves, *spectra).savefig(buffer, dpi=DPI)
    told = PngImagePlugin.PngInfo()
    for key, text in {"made of": made_of(own), "run": command, "numbers": json.dumps(numbers_of(own))}.items():
        told.add_text(key, text)
    few = Image.open(buffer).convert("RGB").quantize(COLOURS)
    few.save(PICTURES / picture, optimize=True, pnginfo=told)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", choices=RUNS)
    parser.add_argument("folder", type=Path, help="the folder of the run")
    options = parser.parse_args()
    draw(options.picture, options.folder)
