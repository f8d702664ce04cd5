"""The notebooks run from top to bottom in a folder of their own, are kept with output, and tell what they say."""

import nbformat
import pytest
from tools.run_notebooks import NOTEBOOKS, made_of, run

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
    assert kept.metadata["made_of"] == made_of(kept), "python -m tools.run_notebooks FOLDER"
    assert pictures(kept) == 1 and texts(kept)
    assert path.stat().st_size < 100_000


def test_the_notebooks_end_with_a_prediction_a_comparison_and_figures(executed):
    folder, found = executed
    assert "wall_power_W" in texts(found["fingerprint"]) and "ratio_lower" in texts(found["two_mills"])
    assert all(pictures(notebook) == 1 for notebook in found.values())
    for mill in ("planetary", "spex"):
        assert (folder / f"fingerprint_{mill}/fingerprint.json").is_file()
    # Three fill ratios at two speeds.
    assert len(list((folder / "fingerprint_planetary/runs").glob("*/run.h5"))) == 18
