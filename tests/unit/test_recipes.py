"""The recipes of CONTRIBUTING.md: each edits a copy of the library as it says, and runs what the new thing is for."""

import os
import shutil
import subprocess
import sys

import pytest

from millprint.run.digest import simulation_digest
from tests.conftest import ROOT

MOTION = '''
class DwellMotion(MotionSection):
    """A stroke along x and back in the first half of a turn, at rest in the second."""

    kind: Literal["dwell"]
    needs = ("stroke_mm",)
    stroke_mm: Size
    """length of the stroke [mm]"""

    def in_words(self) -> str:
        """What a body does."""
        return f"strikes by {self.stroke_mm:g} mm and dwells"

    def drive(self) -> Drive:
        """A cosine in the first half of the turn."""
        turns = [k / 200 for k in range(201)]
        place = [self.stroke_mm / 2e3 * (1 - math.cos(4 * math.pi * min(turn, 0.5))) for turn in turns]
        return Drive(points=[(turn, x, 0.0, 0.0) for turn, x in zip(turns, place)])


'''
ASK_MOTION = """
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from millprint.config.strict_yaml import read_yaml
from millprint.mill.bodies import build_bodies
from millprint.mill.speed_limits import mill_in_words, wall_acceleration

DWELL = {"kind": "dwell", "stroke_mm": 20}
mill = check_model({**read_yaml("config/mills/emax.yaml"), "motion": DWELL}, MillConfig, "mine")
motion = build_bodies(mill)[0].motion
found = [motion.position(turn)[0] for turn in (0.25, 0.55, 0.75, 0.95, 1.25)]
assert all(abs(x - known) < 1e-6 for x, known in zip(found, (0.02, 0, 0, 0, 0.02))), found
assert mill_in_words(mill) == "the jar strikes by 20 mm and dwells"
# Where the stroke begins, the acceleration jumps and the smooth curve overshoots.
assert 1 < wall_acceleration(mill) / (0.01 * (4 * 3.14159) ** 2) < 1.2, wall_acceleration(mill)
"""

STATISTIC = """
    Measured("normal_p95_J", "J", "95th percentile", "of the normal energies of collisions", optional=True,
             of_collisions=lambda found: float(np.quantile(found.energy["normal"], 0.95))),
    Measured("closure","""
ASK_STATISTIC = """
import json
from pathlib import Path

from millprint.fingerprint.columns import explain_columns
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.readers import read_summaries
from millprint.run.digest import simulation_digest
from tests.unit.synthetic_mill import summary
from tests.unit.test_dose_spectra import contacts, write

folder = Path(FOLDER)
write(folder / "run.h5", contacts(94, 1e-4, 1e-5), contacts(6, 2e-3, 1e-5, wall=True))
(folder / "summary.json").write_text(json.dumps(summary()))
rows = tabulate_descriptors(read_summaries([folder / "summary.json"]), "gap_0_03")
assert rows["normal_p95_J"].tolist() == [2e-3], rows["normal_p95_J"]
assert tabulate_descriptors([summary()], "gap_0_03")["normal_p95_J"].isna().all()
assert "`normal_p95_J` | J | 95th percentile" in explain_columns()
# What decides whether a simulation runs again.
assert simulation_digest() == DIGEST
"""

REGRESSOR = """
def _make_ridge(parameters: Parameters, columns: int, training: TrainingConfig, threads: int) -> Any:
    from sklearn.linear_model import BayesianRidge

    return BayesianRidge()


REGRESSORS = {
    "ridge": Regressor(
        title="Bayesian ridge",
        settled="Not of the thesis.",
        make=_make_ridge,
        scaled=True,
        deviation=lambda estimator, inputs: estimator.predict(inputs, return_std=True)[1],
        mean_deviation=lambda estimator, inputs: (
            (estimator.predict(inputs, return_std=True)[1] ** 2 - 1 / estimator.alpha_) ** 0.5
        ),
    ),
"""
ASK_REGRESSOR = """
import re

import numpy as np

from millprint.config.load import check_model
from millprint.config.search_spaces import COMPARED, STORED_MODEL
from millprint.config.yields import TrainingConfig, YieldConfig
from millprint.thesis.yields.model_files import load_model, save_model
from millprint.thesis.yields.yield_model import Trainer
from tests.unit.yield_settings import parts, settings

assert re.match(STORED_MODEL, "ridge_two_step")
own = check_model({**settings().model_dump(), "models": [*COMPARED, "ridge"]}, YieldConfig, "mine")
rows, test = parts()
model, results = Trainer(own.training, own.search).train("ridge", "two_step", rows, rows["yield_percent"].to_numpy())
save_model(model, results, rows, own.training, FOLDER + "/ridge.json")
loaded = load_model(FOLDER + "/ridge.json")
assert np.allclose(loaded.predict(test), model.predict(test), rtol=1e-9)
assert (loaded.deviation(test) > 0).all(), loaded.deviation(test)
"""

LAW = '''"""A quadratic spring."""

import math
from typing import NamedTuple

from millprint.dem.laws.record import ContactLaw, ball_mass


class Quadratic(NamedTuple):
    """The mark of the law."""


class CohesiveQuadratic(NamedTuple):
    """The mark of the law with cohesion."""


QUADRATIC = ContactLaw(
    mark=Quadratic,
    cohesive_mark=CohesiveQuadratic,
    coefficients=lambda contact, radius, mass: (contact.of_law("quadratic_stiffness_n_m2"), 1e5, 0.0, 0.0),
    springs=lambda overlap, normal, tangential, damping, viscous: (
        normal * overlap**2, tangential, damping, viscous, normal * overlap**3 / 3
    ),
    step_scale=lambda contact, radius: 1e-5,
    scale_title="10 us",
    impact=lambda mass, stiffness, speed: ((1.5 * mass * speed**2 / stiffness) ** (1 / 3), 1e-4),
    overlap_power=3.0,
)
'''
LAW_IMPORT = "import LINEAR\nfrom millprint.dem.laws.quadratic import QUADRATIC\n"
LAW_WORDS = """
    "quadratic": LawKeys(("quadratic_stiffness_n_m2",), "quadratic contact", "stiffness", "N/m2"),
"""
LAW_KEY = '''    quadratic_stiffness_n_m2: float | None = Field(default=None, ge=1e-3, le=1e15)
    """stiffness of every contact [N/m2]"""

    @model_validator'''
ASK_LAW = """
import numpy as np
from numba import njit

from millprint.config.load import check_model
from millprint.config.contact_set import CONTACT_LAWS, ContactConfig
from millprint.config.errors import ConfigError
from millprint.dem.law import springs
from millprint.dem.laws.registry import LAWS, step_scale
from millprint.run.digest import simulation_digest
from millprint.run.kernel import kernel_files

own = dict(name="mine", source="test", restitution=1.0, static_friction=0.3, rolling_friction=0.0, density_kg_m3=7700)
own |= {"kind": "quadratic", "quadratic_stiffness_n_m2": 1e11}
mine = check_model(own, ContactConfig, "mine.yaml")
assert CONTACT_LAWS[mine.kind].title == "quadratic contact" and step_scale(mine, 5e-3) == 1e-5
assert any(file.name == "quadratic.py" for file in kernel_files()) and simulation_digest() != DIGEST
call = njit(lambda mark, overlap, numbers: springs(mark, overlap, *numbers))
found = [call(LAWS[kind].mark(), 1e-4, (1e7, 1e6, 3.0, 2.0))[0] for kind in ("hertz", "linear", "quadratic")]
assert np.allclose(found, [1e7 * 1e-6, 1e3, 0.1]), found
try:
    check_model({**own, "young_modulus_gpa": 2.0}, ContactConfig, "mine.yaml")
except ConfigError as error:
    assert "young_modulus_gpa: not a key of kind: quadratic, which takes quadratic_stiffness_n_m2" in str(error), error
else:
    raise AssertionError("a key of another law was taken")
"""
CLAIM = '''

@claim("2.fewest_runs")
def fewest_runs(evidence: Evidence) -> Finding:
    """The smallest fraction."""
    return Finding(evidence.row("doe/fraction.json", "runs")["runs"], "counted")
'''
ASK_CLAIM = """
from pathlib import Path

from millprint.thesis.claims.tolerances import judge_value
from millprint.thesis.claims.tabulate import collect_findings

folder = Path(FOLDER)
row = ["2.fewest_runs", "Table 2.3", "runs of a fraction", "27", "runs", "arithmetic", "stated", "printed", ""]
(folder / "claims.tsv").write_text(Path("config/data/claims.tsv").read_text() + "\\t".join(row) + "\\n")
(folder / "doe").mkdir()
(folder / "doe/fraction.json").write_text('{"runs": 27}')
found = collect_findings(folder, folder / "claims.tsv", "2.fewest_runs")["2.fewest_runs"]
assert judge_value("27", "printed", found).agrees and "doe/fraction.json" in str(found.sources), found
"""

# Of each recipe: (file, text, what stands in its place) of every edit, new files, and the program that asks for it.
RECIPES = {
    "motion": (
        [
            ("config/motion_kinds.py", "class RestMotion(", MOTION.lstrip() + "class RestMotion("),
            ("config/motion_kinds.py", "(RestMotion, ", "(DwellMotion),\n        MotionKind(RestMotion, "),
        ],
        {},
        ASK_MOTION,
    ),
    "statistic": ([("fingerprint/columns.py", '\n    Measured("closure",', STATISTIC)], {}, ASK_STATISTIC),
    "regressor": (
        [
            ("thesis/yields/regressors.py", "REGRESSORS = {\n", REGRESSOR.lstrip()),
            ("config/search_spaces.py", 'UNTUNED = ("gpr_starts",)', 'UNTUNED = ("gpr_starts", "ridge")'),
        ],
        {},
        ASK_REGRESSOR,
    ),
    "claim": (
        [("thesis/claims/chapter2.py", '\n\n@claim("2.screening_runs")', CLAIM + '\n\n@claim("2.screening_runs")')],
        {},
        ASK_CLAIM,
    ),
    "contact law": (
        [
            ("dem/laws/registry.py", "LINEAR}", 'LINEAR, "quadratic": QUADRATIC}'),
            ("dem/laws/registry.py", "import LINEAR\n", LAW_IMPORT),
            ("config/contact_set.py", "\n}\nALL_LAW_KEYS", LAW_WORDS + "}\nALL_LAW_KEYS"),
            ("config/contact_set.py", "    @model_validator", LAW_KEY),
        ],
        {"dem/laws/quadratic.py": LAW},
        ASK_LAW,
    ),
}  # fmt: skip


def follow(recipe: str, folder) -> None:
    """Do the steps of a recipe in a copy of the library, and run its program with the copy."""
    edits, files, program = RECIPES[recipe]
    library = folder / "src/millprint"
    # With what Python has compiled of it, which still holds for the files that no recipe edits.
    shutil.copytree(ROOT / "src/millprint", library)
    for name, old, new in edits:
        text = (library / name).read_text()
        assert text.count(old) == 1, (name, old)
        (library / name).write_text(text.replace(old, new))
    for name, text in files.items():
        (library / name).write_text(text)
    assert len({name for name, _, _ in edits} | set(files)) <= 3
    path = os.pathsep.join([str(folder / "src"), str(ROOT), str(ROOT / "scripts")])
    given = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(folder / "numba")}
    program = f"FOLDER, DIGEST = {str(folder)!r}, {simulation_digest()!r}\n{program}"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.slow
def test_the_recipe_is_complete(recipe, tmp_path):
    follow(recipe, tmp_path)
