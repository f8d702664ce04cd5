"""A job imports what it needs: libraries that take half a second to two seconds to import, of which it uses nothing."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from millprint.run.extras import EXTRAS

# Each script is imported in a process of its own.
pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
CHECK = "millprint.checks.before_running"
# Libraries that each script must not import, not even through another one.
NEEDLESS = {
    "millprint.checks.before_running": [
        "matplotlib",
        "scipy.optimize",
        "scipy.stats",
        "sklearn",
        "statsmodels",
        "torch",
        "trimesh",
    ],
    "millprint.dem.run": ["matplotlib", "scipy.spatial", "sklearn", "statsmodels", "torch", "trimesh"],
    "tabulate_simulations": ["matplotlib", "numba", "scipy", "sklearn", "torch", "trimesh"],
    "plot_fingerprint": ["numba", "sklearn", "torch", "trimesh"],
    "split_screening": ["matplotlib", "numba", "scipy.stats", "sklearn", "statsmodels", "torch", "trimesh"],
    "draw_mill": ["scipy.stats", "sklearn", "statsmodels", "torch", "trimesh"],
    "check_measures": ["matplotlib", "scipy.stats", "sklearn", "statsmodels", "torch", "trimesh"],
    "write_pages": ["numba", "scipy.stats", "sklearn", "statsmodels", "torch", "trimesh"],
    "predict_setup": ["matplotlib", "scipy.interpolate", "scipy.optimize", "scipy.stats", "sklearn", "trimesh"],
    "fit_wear": ["numba", "scipy.stats", "sklearn", "torch", "trimesh"],
    "plot_surrogates": ["scipy.stats", "sklearn", "statsmodels", "trimesh"],
}
# Libraries that no script needs to avoid: imported once, before a fork for each script.
SHARED = ["h5py", "numpy", "pandas", "pydantic", "yaml"]
# And those that most of the scripts import that need not avoid them, before a fork for these.
LARGE = ["matplotlib.pyplot", "numba"]
ASK = """
import importlib, os, sys

def fork(names, then):
    sys.stdout.flush()
    if os.fork() == 0:
        for name in names:
            importlib.import_module(name)
        then()
        sys.stdout.flush()
        os._exit(0)
    assert os.wait()[1] == 0, names

def ask(scripts):
    for script in scripts:
        fork([script], lambda: print(script, *sys.modules))

shared, *groups = (words.split() for words in sys.argv[1:])
for name in shared:
    importlib.import_module(name)
for count, *group in groups:
    fork(group[: int(count)], lambda: ask(group[int(count) :]))
"""


@pytest.fixture(scope="module")
def imported() -> dict[str, set[str]]:
    """The modules that are imported after each script, by script. Each has a process that has imported no other."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for script, needless in NEEDLESS.items():
        large = tuple(name for name in LARGE if name.partition(".")[0] not in needless)
        groups.setdefault(large, []).append(script)
    words = [" ".join([str(len(large)), *large, *scripts]) for large, scripts in groups.items()]
    done = subprocess.run(
        [sys.executable, "-c", ASK, " ".join(SHARED), *words],
        cwd=ROOT / "scripts",
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        check=True,
    )
    lines = (line.split() for line in done.stdout.splitlines())
    return {script: set(modules) for script, *modules in lines}


@pytest.mark.parametrize("script", NEEDLESS)
def test_a_script_does_not_import_what_it_does_not_use(imported, script):
    assert {script, "millprint"} <= imported[script] and imported[script].isdisjoint(NEEDLESS[script])


# Rules that only the thesis has; what other mills need is installed without its packages.
THESIS_RULES = {"calibration", "chapters", "doe", "fingerprint", "partition", "surrogate", "yields"}
IMPORT_ALL = """
import importlib, sys
extras, scripts = (words.split() for words in sys.argv[1:])
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in extras:
            raise ModuleNotFoundError(name)
sys.meta_path.insert(0, Missing())
for script in scripts:
    importlib.import_module(script)
"""


def test_a_mill_needs_no_package_of_an_extra():
    rules = [path for path in (ROOT / "workflow/rules").glob("*.smk") if path.stem not in THESIS_RULES]
    scripts = {name for path in rules for name in re.findall(r"scripts/(\w+)\.py", path.read_text())}
    assert {"run_dem_case", "describe_mill", "write_card"} <= scripts
    packages = [*EXTRAS["thesis"], *EXTRAS["surrogate"]]
    done = subprocess.run(
        [sys.executable, "-c", IMPORT_ALL, " ".join(packages), " ".join([*scripts, CHECK])],
        cwd=ROOT / "scripts",
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]


HELP = """
import sys
from importlib import import_module
from millprint.cli.commands import COMMANDS
for command in COMMANDS.values():
    import_module(command.module)
print(*sys.modules)
"""


def test_commands_say_what_they_take_without_what_they_need_later():
    done = subprocess.run(
        [sys.executable, "-c", HELP],
        env={**os.environ, "PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
    )
    assert {"millprint.cli.match_conditions", "millprint.thesis.commands.ask_yields"} <= set(done.stdout.split())
    assert {"numpy", "pandas", "snakemake", "millprint.config.workflow"}.isdisjoint(done.stdout.split())
