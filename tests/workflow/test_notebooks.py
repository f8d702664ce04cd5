"""The notebooks run from top to bottom in a folder of their own, are kept with output, and tell what they say."""

import nbformat
import pytest
from tools.run_notebooks import NOTEBOOKS, PLACE, made_of, run

from tests.conftest import ROOT


def read(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    return notebook


def texts(notebook) -> str:
    """What the cells print and show, one after another."""
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    return "\n".join(output.get("text") or output.get("data", {}).get("text/plain", "") for output in outputs)


def pictures(notebook) -> int:
    return sum("image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", []))


@pytest.fixture(scope="module")
def executed(tmp_path_factory):
    """The notebooks by name, executed in one folder: the second finds the planetary mill of the first."""
    folder = tmp_path_factory.mktemp("notebooks")
    found = {}
    with pytest.MonkeyPatch.context() as patch:
        # The library of this checkout, also where another one is installed.
        patch.setenv("PYTHONPATH", str(ROOT / "src"))
        for path in NOTEBOOKS:
            found[path.stem] = read(path)
            run(found[path.stem], folder)
    return folder, found


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_with_the_output_of_its_present_cells(path):
    kept = read(path)
    assert kept.metadata["made_of"] == made_of(kept), "python tools/run_notebooks.py FOLDER"
    assert pictures(kept) == 1 and texts(kept)
    assert path.stat().st_size < 100_000


def test_every_notebook_is_run():
    assert sorted(PLACE.glob("*.ipynb")) == sorted(NOTEBOOKS)


def test_the_first_takes_a_fingerprint_in_twenty_lines():
    code = [cell.source for cell in read(PLACE / "fingerprint.ipynb").cells if cell.cell_type == "code"]
    # The figure, the last cell, does not matter here.
    assert len([line for cell in code[:-1] for line in cell.splitlines() if line.strip()]) <= 20
    assert not any("sys.path" in cell or "snakemake" in cell for cell in code)


def test_the_first_ends_with_a_prediction_and_a_figure(executed):
    folder, found = executed
    shown = texts(found["fingerprint"])
    assert "outside the simulated range: nothing" in shown and "power_W" in shown
    assert pictures(found["fingerprint"]) == 1
    assert (folder / "fingerprint_planetary/fingerprint.json").is_file()
    # Three fill ratios at two speeds.
    assert len(list((folder / "fingerprint_planetary/runs").glob("*/run.h5"))) == 18


def test_the_second_compares_and_says_what_to_set(executed):
    folder, found = executed
    shown = texts(found["two_mills"])
    assert "ratio_lower" in shown and "power of all balls" in shown
    assert "Hz with" in shown and "weighted_normal_frequency_hz:" in shown
    assert pictures(found["two_mills"]) == 1
    assert (folder / "fingerprint_spex/fingerprint.json").is_file()
