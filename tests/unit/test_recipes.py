"""The recipes of CONTRIBUTING.md: each edits a copy of the library as it says, and runs what the new thing is for."""

import os
import shutil
import subprocess
import sys

import pytest
import yaml

from millprint.run.digest import simulation_digest
from tests.conftest import ROOT

RECIPES = yaml.safe_load((ROOT / "tests/data/recipes.yaml").read_text())


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.slow
def test_the_recipe_is_complete(recipe, tmp_path):
    """Its steps in a copy of the library, with which its program runs."""
    edits, files, program = RECIPES[recipe].values()
    library = tmp_path / "src/millprint"
    # With what Python has compiled of it, which still holds for the files that no recipe edits.
    shutil.copytree(ROOT / "src/millprint", library)
    for edit in edits:
        text = (library / edit["file"]).read_text()
        assert text.count(edit["text"]) == 1, edit
        (library / edit["file"]).write_text(text.replace(edit["text"], edit["becomes"]))
    for name, text in files.items():
        (library / name).write_text(text)
    assert len({edit["file"] for edit in edits} | set(files)) <= 2
    path = os.pathsep.join([str(tmp_path / "src"), str(ROOT), str(ROOT / "scripts")])
    given = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(tmp_path / "numba")}
    program = f"FOLDER, DIGEST = {str(tmp_path)!r}, {simulation_digest()!r}\n{program}"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
