"""The wheel: what it holds, and that it works where nothing else of the project is."""

import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from millprint.fingerprint.model import Fingerprint
from millprint.run.files import write_table
from tests.unit import synthetic_mill
from tests.workflow.conftest import copy_project
from tests.workflow.test_kills import COMMAND, kill_and_remark

# Fits curves to descriptors, and asks for a condition that cannot be.
FIT = """
from pathlib import Path
import millprint
from millprint.fingerprint.descriptors import read_descriptors

millprint.Fingerprint.fit(read_descriptors("descriptors.tsv"), 125e-6, 0.95).write("fingerprint.json")
print(Path(millprint.__file__).parent)
print(*millprint.included_mills())
try:
    balls = {"diameter_mm": 10, "fill_ratio": 0.9}
    millprint.simulate("planetary", "steel", folder="out", speed_rpm=300, balls=balls)
except millprint.ConfigError as error:
    print(error)
"""

# Simulates a small drum of one's own.
SIMULATE = """
import millprint

sweep = {"speeds_rpm": [120], "ball_diameters_mm": [12], "fill_ratios": [0.1, 0.2, 0.3],
         "discard_turns": 1, "window_turns": 2}
millprint.take_fingerprint(millprint.load_mill("mine.yaml"), "steel", folder="mine", sweep=sweep)
"""

MILL = """
name: mine
title: Small drum
source: made for a test
volume_ml: 63.6
geometry: {kind: cylinder, axis: y, radius_mm: 22.5, height_mm: 40, facets: 24, fillet_radius_mm: 0, fillet_ends: none}
motion: {kind: rotation, axis: [0, 1, 0]}
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """The wheel of a clean copy of the project."""
    folder = tmp_path_factory.mktemp("wheel")
    project = copy_project(folder / "millprint")
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--no-index"]
    subprocess.run([*command, "--wheel-dir", str(folder), str(project)], check=True, timeout=600)
    (made,) = folder.glob("*.whl")
    return made


def names_of(wheel: Path) -> set[str]:
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_the_wheel_holds_every_module_and_every_file_beside_them(wheel):
    names = names_of(wheel)
    package = wheel.parent / "millprint/src/millprint"
    beside = {".py", ".html", ".css", ".js", ".yaml"}
    files = [path for path in package.rglob("*") if path.suffix in beside and "__pycache__" not in path.parts]
    assert len(files) > 200
    missing = [path.name for path in files if f"millprint/{path.relative_to(package)}" not in names]
    assert not missing


def test_the_wheel_holds_the_included_mills_and_the_workflow(wheel):
    names, project = names_of(wheel), wheel.parent / "millprint"
    files = [
        path for folder in ("config", "workflow", "scripts", "profiles") for path in (project / folder).rglob("*.*")
    ]
    shipped = {str(path.relative_to(project)) for path in files if path.suffix != ".pyc"}
    assert {"config/mills/emax.yaml", "workflow/profiles/default/config.yaml"} <= shipped
    assert {f"millprint/included/{name}" for name in shipped} <= names


def test_the_wheel_holds_nothing_else(wheel):
    tops = {name.split("/")[0] for name in names_of(wheel)}
    assert len(tops) == 2 and "millprint" in tops and any(top.endswith(".dist-info") for top in tops)
    assert any(name.endswith("licenses/LICENSE") for name in names_of(wheel))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    """The Python of an environment that has only the wheel, and sees what it depends on, but not this project."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=False, symlinks=True)
    python = home / "bin/python"
    install = [sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet", "--no-deps", "--no-index"]
    subprocess.run([*install, str(wheel)], check=True, timeout=600)
    site = sysconfig.get_path("purelib", vars={"base": str(home), "platbase": str(home)})
    # Searched after the environment's own packages. The path files of that folder are not read: one of them would lead
    # to this project, where it is installed to be edited.
    Path(site, "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return python


def call(python: Path, program: str, folder: Path) -> list[str]:
    """What a program of the environment prints, in a folder of its own."""
    hidden = ("PYTHONPATH", "MILLPRINT_RUN", "NUMBA_CACHE_DIR")
    own = {name: value for name, value in os.environ.items() if name not in hidden}
    done = subprocess.run(
        [python, "-c", program], cwd=folder, env={**own, "XDG_CACHE_HOME": str(folder / "cache")},
        capture_output=True, text=True, timeout=1200, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout.splitlines()


def test_the_wheel_fits_a_fingerprint_in_an_empty_environment(installed, tmp_path):
    write_table(synthetic_mill.descriptors(), tmp_path / "descriptors.tsv")
    where, mills, refusal = call(installed, FIT, tmp_path)
    assert Path(where).is_relative_to(installed.parents[1])
    assert {"planetary", "spex", "emax"} <= set(mills.split())
    assert "do not fit in mill planetary" in refusal
    condition = synthetic_mill.fingerprint().condition(speed_hz=12.0, ball_diameter_m=0.01, fill_ratio=0.12)
    found = Fingerprint.read(tmp_path / "fingerprint.json").predict(condition)
    assert found.wall_power_W.value == pytest.approx(
        synthetic_mill.fingerprint().predict(condition).wall_power_W.value, rel=0.02
    )


def test_the_command_of_the_wheel_finds_its_workflow(installed, tmp_path):
    """A mill of one's own is described, and its fingerprint planned, in a folder that has nothing else."""
    command = "import sys; from millprint.cli.commands import main; sys.exit(main(sys.argv[1].split()))"
    run = [installed, "-c", command]
    hidden = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    for words in ("new drum --name mine --yes --no-picture", "fingerprint mine.yaml --dry-run --quiet reason"):
        done = subprocess.run([*run, words], cwd=tmp_path, env=hidden, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-4000:]
    assert "Using workflow specific profile" in done.stderr
    assert "run_dem_case" in done.stdout + done.stderr and "chapter" not in done.stdout + done.stderr


def test_by_the_wheel_a_kill_is_mended_and_a_comment_runs_nothing_again(installed, tmp_path):
    hidden = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    (script,) = installed.parents[1].rglob("included/scripts/draw_mill.py")
    kill_and_remark(tmp_path, installed, COMMAND, hidden, script)


@pytest.mark.skipif(
    not os.environ.get("MILLPRINT_WHEEL"), reason="compiles the kernels again; MILLPRINT_WHEEL=1 runs it"
)
def test_the_wheel_simulates_a_mill_of_ones_own_in_an_empty_environment(installed, tmp_path):
    (tmp_path / "mine.yaml").write_text(MILL)
    call(installed, SIMULATE, tmp_path)
    found = Fingerprint.read(tmp_path / "mine/fingerprint.json")
    condition = found.condition(speed_hz=2.0, ball_diameter_m=0.012, fill_ratio=0.2)
    prediction = found.predict(condition)
    assert 0 < prediction.wall_power_W.lower < prediction.wall_power_W.value < prediction.wall_power_W.upper
    assert not prediction.outside and found.about["contact"] == "steel"
