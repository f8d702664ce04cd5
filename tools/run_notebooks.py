"""Runs the notebooks of the docs and keeps what their cells show: python -m tools.run_notebooks FOLDER.

FOLDER holds what they simulate. Each notebook carries what its output was made of, and a test compares that with the
present cells and code.
"""

import argparse
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from tools.made_by import digest_of, settings_of

from millprint.dem import PHYSICS

PLACE = Path(__file__).parents[1] / "docs/notebooks"
# In the order in which they run: the second uses what the first has simulated.
NOTEBOOKS, MILLS = [PLACE / "fingerprint.ipynb", PLACE / "two_mills.ipynb"], ["planetary", "spex"]


def made_of(notebook: nbformat.NotebookNode) -> str:
    """What a notebook shows: the version of the physics, the default settings of its mills, and its code."""
    code = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    settings = " ".join(map(settings_of, MILLS))
    return f"physics {PHYSICS}, settings {settings}, cells {digest_of(code.encode())}"


def run(notebook: nbformat.NotebookNode, folder: Path) -> None:
    """Run the cells of a notebook in `folder`; an error in a cell is raised here, with its traceback."""
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=1200, resources=resources, record_timing=False).execute()


def without_progress(notebook: nbformat.NotebookNode) -> None:
    """Leave out what cells write to the error stream: progress, and times of this machine."""
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = [each for each in cell.outputs if each.get("name") != "stderr"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="an empty folder")
    place = parser.parse_args().folder
    for path in NOTEBOOKS:
        notebook = nbformat.read(path, as_version=4)
        run(notebook, place)
        without_progress(notebook)
        # What differs with the machine that ran it.
        notebook.metadata["language_info"] = {"name": "python"}
        notebook.metadata["made_of"] = made_of(notebook)
        nbformat.write(notebook, path)
