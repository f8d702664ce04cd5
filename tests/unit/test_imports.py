"""A job imports what it needs: libraries that take half a second to two seconds to import, of which it uses nothing."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# Libraries that each script must not import, not even through another one.
NEEDLESS = {
    "run_dem_case": ["matplotlib", "scipy.spatial", "sklearn", "statsmodels", "torch", "trimesh"],
    "tabulate_descriptors": ["matplotlib", "numba", "scipy", "sklearn", "torch"],
    "tabulate_spectra": ["matplotlib", "numba", "scipy", "sklearn", "torch", "trimesh"],
    "plot_fingerprint": ["numba", "sklearn", "torch", "trimesh"],
    "split_screening": ["matplotlib", "numba", "scipy.stats", "sklearn", "statsmodels", "torch", "trimesh"],
    "draw_mill": ["sklearn", "statsmodels", "torch"],
    "draw_sheet": ["sklearn", "statsmodels", "torch"],
    "draw_spectra": ["numba", "sklearn", "torch", "trimesh"],
    "tabulate_claims": ["torch", "trimesh"],
    "draw_claims": ["torch", "trimesh"],
}
ASK = "import sys; import {script}; print(*sys.modules)"


@pytest.mark.parametrize("script", NEEDLESS)
def test_a_script_does_not_import_what_it_does_not_use(script):
    asked = [sys.executable, "-c", ASK.format(script=script)]
    done = subprocess.run(asked, cwd=ROOT / "scripts", capture_output=True, text=True, check=True)
    imported = set(done.stdout.split())
    assert "millprint" in imported and imported.isdisjoint(NEEDLESS[script])
