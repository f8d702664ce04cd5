"""Draws a picture of docs/pictures: python -m tools.draw_pictures PICTURE FOLDER.

FOLDER is where the command of PICTURE was run, in RUNS or ANIMATED; the drawings of a mill need no run. TABLE has what
each picture was made of, and a page of a fingerprint carries the numbers on it. Tests compare these with the
present code and with the text of the page.
"""

import argparse
import json
from io import BytesIO
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from PIL import Image, PngImagePlugin
from tools.made_by import digest_of, settings_of

from millprint.config.included import load_mill
from millprint.config.view import ViewConfig
from millprint.dem import PHYSICS
from millprint.dose.spectra import read_spectra
from millprint.dose.spectra_shown import of_sheet, temperature_rows, with_rows
from millprint.figures.animation import save_animation
from millprint.figures.mill_sheet_figure import plot_geometry, plot_motion, plot_sheet
from millprint.fingerprint.descriptors import read_descriptors
from millprint.run.files import read_table, write_table
from millprint.view.frames import picture_mill, read_movie

PICTURES = Path(__file__).parents[1] / "docs/pictures"
MILL = "planetary"
# Each picture, the command of its run, and the folder of the results.
RUNS = {
    "planetary_fingerprint.png": ("millprint fingerprint planetary", "results"),
    "first_hour_fingerprint.png": ("millprint fingerprint config/first_hour/planetary.yaml", "results/first_hour"),
}
# The animation, its case, and its command.
ANIMATION, CASE = "mill.gif", "dem/emax/calibrated/d10_f0.10_n300_s0"
ANIMATED = f"snakemake --cores 2 results/{CASE}/{ANIMATION}"
# Drawings of the mill of the first hour, which its first command makes.
DRAWINGS = {"planetary_geometry.png": plot_geometry, "planetary_motion.png": plot_motion}
TABLE = PICTURES.parent / "pictures.tsv"
DPI, COLOURS = 150, 64
ONE_TURN = ViewConfig(revolutions=1, frames_per_revolution=17)


def made_of(sheet: pd.DataFrame, command: str) -> str:
    """What a page shows: the version of the physics, the settings of its command, and the names of its rows."""
    rows = sheet[sheet["section"].isin(["mill", "condition", "descriptors", "dose", "exponents"])]
    settings = settings_of(command.split()[-1])
    return f"physics {PHYSICS}, settings {settings}, rows {digest_of(' '.join(rows['quantity']).encode())}"


def numbers_of(sheet: pd.DataFrame) -> dict[str, float]:
    """The numbers of a page, by the names of their rows."""
    own = sheet[sheet["section"].isin(["condition", "descriptors", "dose", "exponents"]) & sheet["value"].notna()]
    return dict(zip(own["quantity"], own["value"].astype(float), strict=True))


def mill_of(picture: str) -> str:
    """The version of the physics and what a picture shows, but for a page: a mill, and for an animation its case."""
    mill = load_mill(MILL if picture in DRAWINGS else CASE.split("/")[1])
    what = mill.model_dump_json(include={"geometry", "inserts", "motion"}) + (CASE if picture == ANIMATION else "")
    return f"physics {PHYSICS}, mill {digest_of(what.encode())}"


def draw(picture: str, folder: Path) -> None:
    """Draw a picture, and note what it was made of."""
    if picture in DRAWINGS:
        few(DRAWINGS[picture](picture_mill(load_mill(MILL)))).save(PICTURES / picture, optimize=True)
        made = mill_of(picture)
    elif picture == ANIMATION:
        save_animation(read_movie(folder / "results" / CASE / "run.h5", ONE_TURN, None), PICTURES / picture)
        made = mill_of(picture)
    else:
        made = draw_page(picture, folder / RUNS[picture][1])
    rows = read_table(TABLE).set_index("picture")
    rows.loc[picture] = [made, digest_of((PICTURES / picture).read_bytes())]
    write_table(rows.sort_index().reset_index(), TABLE)


def few(figure: Figure) -> Image.Image:
    """A figure in few colours, for a small file."""
    buffer = BytesIO()
    figure.savefig(buffer, dpi=DPI)
    return Image.open(buffer).convert("RGB").quantize(COLOURS)


def draw_page(picture: str, results: Path) -> str:
    """Draw the page of a fingerprint with its numbers; returns what it was made of."""
    mill, dose = results / "mills" / MILL, results / "dose"
    own = read_table(mill / "fingerprint.tsv")
    sheet = with_rows(own, temperature_rows(read_table(dose / "heat" / MILL / "limits.tsv"), own))
    spectra = [of_sheet(read_spectra(dose / MILL / name), sheet) for name in ("spectra.tsv", "spectra_summary.tsv")]
    descriptors, curves = read_descriptors(mill / "descriptors.tsv"), read_table(mill / "curves.tsv")
    figure = plot_sheet(picture_mill(load_mill(MILL)), sheet, descriptors, curves, *spectra)
    told, command = PngImagePlugin.PngInfo(), RUNS[picture][0]
    made = made_of(own, command)
    for key, text in {"made of": made, "run": command, "numbers": json.dumps(numbers_of(own))}.items():
        told.add_text(key, text)
    few(figure).save(PICTURES / picture, optimize=True, pnginfo=told)
    return made


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("picture", choices=[*RUNS, *DRAWINGS, ANIMATION])
    parser.add_argument("folder", type=Path, nargs="?", default=Path(), help="the folder of the run")
    options = parser.parse_args()
    draw(options.picture, options.folder)
