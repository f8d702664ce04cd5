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

OBSERVABLE = """
    Measured("median_impact_speed_m_s", "m/s", "median impact speed", "of the speeds along the line of centres",
             symbol="v50", curve="v50", scale="speed", matched=BY_NAME, panel="Impact speed", line="median",
             optional=True, of_collisions=lambda found: float(np.median(found["approach_speed_m_s"][found.begins]))),
    Measured("closure","""
ASK_OBSERVABLE = """
import json
from pathlib import Path

import numpy as np

from millprint.card.card_model import Descriptors
from millprint.card.latex import TITLES
from millprint.config.fingerprint import (MatchConfig)
from millprint.explorer.content import Machine, explorer_content, mill_content
from millprint.fingerprint.condition_search import rank_conditions, simulated_ranges, simulated_request
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.mill_collapse import tabulate_mill_collapse
from millprint.fingerprint.mill_sheet import tabulate_sheet
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.readers import read_summaries
from millprint.fingerprint.zones import find_zones
from millprint.observables.definitions import explain_columns
from millprint.run.digest import simulation_digest
from tests.unit.synthetic_mill import AMPLITUDE, FILLS, VOLUME, summary
from tests.unit.test_dose_spectra import contacts, write
from tests.unit.test_sheets import mill

folder, rng, paths = Path(FOLDER), np.random.default_rng(0), []
for fill in FILLS[::2]:
    for speed_rpm in (600.0, 1200.0):
        place = folder / f"f{fill}_n{speed_rpm:g}"
        place.mkdir()
        # Half of the speed of the wall, with scatter.
        table = contacts(400, 1e-4, 1e-5).assign(start_s=0.55 + rng.random(400))
        scale = speed_rpm / 60 * AMPLITUDE
        write(place / "run.h5", table.assign(approach_speed_m_s=0.5 * scale * rng.lognormal(0, 0.3, 400)))
        (place / "summary.json").write_text(json.dumps(summary(fill, speed_rpm=speed_rpm)))
        paths.append(place / "summary.json")
rows = tabulate_descriptors(read_summaries(paths), "gap_0_03")
NAME = "median_impact_speed_m_s"
# The median of 400 lognormal speeds of this spread has a standard error of 1.25 * 0.3 / 20.
assert np.allclose(rows["v50"], 0.5, rtol=0.08) and (rows["v50_se"] / rows["v50"]).median() < 0.05, rows["v50_se"]
assert tabulate_descriptors([summary()], "gap_0_03")[NAME].isna().all()
fingerprint = Fingerprint.fit(rows, VOLUME, 0.95)
fingerprint.write(folder / "fingerprint.json")
found = fingerprint.predict(fingerprint.condition(speed_hz=15.0, ball_diameter_m=0.01, fill_ratio=0.1))
assert abs(found.median_impact_speed_m_s.value / (0.5 * 15 * AMPLITUDE) - 1) < 0.08 and found.known[NAME].unit == "m/s"
request = MatchConfig(targets=[{"name": "mine", NAME: 0.12}], **simulated_ranges([fingerprint]))
best = rank_conditions({NAME: 0.12}, [fingerprint], request).iloc[0]
assert abs(best[NAME] / 0.12 - 1) < 1e-3, best
sheet = tabulate_sheet(mill("spex"), fingerprint, tabulate_mill_collapse(rows, 0.95), find_zones(fingerprint), rows)
assert "median impact speed" in sheet["quantity"].tolist()
own = mill_content(Machine("emax", "A mill"), [folder / "fingerprint.json"], simulated_request(fingerprint, "weighted"))
(shown,) = [each for each in explorer_content("a", [own])["observables"] if each["name"] == NAME]
assert (shown["panel"], shown["scale"]) == ("Impact speed", "speed")
assert NAME in Descriptors.model_fields and TITLES[NAME] == "median impact speed"
assert "`median_impact_speed_m_s` | m/s | median impact speed" in explain_columns()
# A fingerprint that was made before says so, and predicts all else.
older = Fingerprint.read("config/fingerprints/mixer.json")
assert "run the command again" in older.about["no_curve"]["v50"]
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
    "observable": ([("observables/definitions.py", '\n    Measured("closure",', OBSERVABLE)], {}, ASK_OBSERVABLE),
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
