"""The recipes of CONTRIBUTING.md: each edits a copy of the library as it says, and runs what the new thing is for."""

import os
import shutil
import subprocess
import sys

import pytest

from millprint.run.digest import simulation_digest
from tests.conftest import ROOT

MOTION = '''
class TiltedMotion(MotionSection):
    """Turning about an axis that a frame swings to and fro about the vertical."""

    kind: Literal["tilted"]
    needs = ("swing_deg",)
    swing_deg: Annotated[float, Field(gt=0, le=90)]
    """largest swing of the axis to each side [deg]"""

    def in_words(self) -> str:
        """What a body does."""
        return f"turns about an axis that swings by {self.swing_deg:g} degrees"

    def drive(self) -> Drive:
        """A drum's turning, carried by the frame."""
        frame = Drive(swing=((1, 0.0, math.radians(self.swing_deg)),))
        return Drive(axis=(1.0, 0.0, 0.0), pivot_mm=(0.0, 10.0, 0.0), turns=1, carrier=frame)


'''
ASK_MOTION = """
import numpy as np
from scipy.spatial.transform import Rotation

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from millprint.config.strict_yaml import read_yaml
from millprint.dem.lammps.regions import unsupported
from millprint.mill.bodies import build_bodies
from millprint.mill.speed_limits import mill_in_words, wall_acceleration

TILTED = {"kind": "tilted", "swing_deg": 20}
mill = check_model({**read_yaml("config/mills/emax.yaml"), "motion": TILTED}, MillConfig, "mine")
motion = build_bodies(mill)[0].motion
turns = np.linspace(0, 3, 61)
drum = Rotation.from_rotvec(np.outer(2 * np.pi * turns, [1, 0, 0]))
frame = Rotation.from_rotvec(np.outer(np.radians(20) * np.sin(2 * np.pi * turns), [0, 0, 1]))
pivot, point = np.array([0, 0.01, 0]), np.array([0.02, 0.03, -0.01])
known = frame.apply(pivot + drum.apply(point - pivot))
found = motion.position(turns) + motion.rotation(turns) @ point
assert np.abs(found - known).max() < 1e-9, np.abs(found - known).max()
assert mill_in_words(mill) == "the jar turns about an axis that swings by 20 degrees"
assert wall_acceleration(mill) > 0
drum = check_model({**read_yaml("config/mills/drum.yaml"), "motion": TILTED}, MillConfig, "mine")
said = unsupported(drum)
assert said == "motion.kind = tilted: LAMMPS gets motions of harmonics and rotations", said
"""

OBSERVABLE = """
    Measured("median_impact_speed_m_s", "m/s", "median impact speed", "of the speeds along the line of centres",
             symbol="v50", curve="v50", scale="speed", matched=BY_NAME, panel="Impact speed", line="median",
             optional=True, of_collisions=lambda found: found.quantile("approach_speed_m_s")),
    Measured("closure","""
ASK_OBSERVABLE = """
import json
from pathlib import Path

import numpy as np

from millprint.card.card_model import Descriptors
from millprint.card.latex import TITLES
from millprint.config.fingerprint import (MatchConfig)
from millprint.explorer.content import Machine, explorer_content, mill_content
from millprint.fingerprint.condition_search import rank_conditions, simulated_request
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
request = MatchConfig(targets=[{"name": "mine", NAME: 0.12}])
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

    return BayesianRidge(**parameters)


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
SEARCHED = """    "gpr_starts": Training(),
    "ridge": Training({"alpha_1": Drawn(1e-8, 1e-2, "logarithmic")}, 3, 2),"""
ASK_REGRESSOR = """
import re

import numpy as np

from millprint.config.load import check_model
from millprint.config.search_spaces import COMPARED, STORED_MODEL
from millprint.config.yields import HeldOutConfig, SearchConfig, TrainingConfig, YieldConfig
from millprint.thesis.yields.model_files import load_model, save_model
from millprint.thesis.yields.yield_model import Trainer
from tests.unit.yield_settings import parts, settings

assert re.match(STORED_MODEL, "ridge_two_step")
assert (SearchConfig().evaluations["ridge"], HeldOutConfig().evaluations["ridge"]) == (3, 2)
own = check_model({**settings().model_dump(), "models": [*COMPARED, "ridge"]}, YieldConfig, "mine")
rows, test = parts()
model, results = Trainer(own.training, own.search).train("ridge", "two_step", rows, rows["yield_percent"].to_numpy())
assert all(1e-8 <= step.parameters["alpha_1"] <= 1e-2 for step in results), results
save_model(model, results, rows, own.training, FOLDER + "/ridge.json")
loaded = load_model(FOLDER + "/ridge.json")
assert np.allclose(loaded.predict(test), model.predict(test), rtol=1e-9)
assert (loaded.deviation(test) > 0).all(), loaded.deviation(test)
"""

LAW = '''"""A spring whose force is damped in proportion to it, by a time of the material."""

import math
from typing import NamedTuple

from millprint.dem.laws.record import ContactLaw


class Damped(NamedTuple):
    """The mark of the law."""


class CohesiveDamped(NamedTuple):
    """The mark of the law with cohesion."""


def coefficients(contact, radius, mass):
    """k_n, k_t [N/m], and both times the damping time."""
    stiffness, time = contact.value_of("spring_n_m"), contact.value_of("damping_time_s")
    return stiffness, 0.3 * stiffness, time * stiffness, 0.3 * time * stiffness


LAW = ContactLaw(
    mark=Damped,
    cohesive_mark=CohesiveDamped,
    coefficients=coefficients,
    springs=lambda overlap, normal, tangential, damping, viscous: (
        normal * overlap, tangential, damping, viscous, normal * overlap**2 / 2
    ),
    step_scale=lambda contact, radius: 1e-5,
    scale_title="10 us",
    impact=lambda mass, stiffness, speed: (speed * math.sqrt(mass / stiffness), math.pi * math.sqrt(mass / stiffness)),
    overlap_power=2.0,
)
'''
LAW_KEYS = '''class DampingTimeKeys(LawKeys):
    """A spring with a damping time."""

    spring_n_m: Annotated[float, Field(gt=0)]
    """stiffness of every contact [N/m]"""
    damping_time_s: Annotated[float, Field(ge=0)]
    """force of the dashpot over stiffness and speed [s]"""


'''
LAW_KIND = """
    "damping_time": LawKind(
        DampingTimeKeys, "contact with a damping time",
        {"damping_time_s": ("damping time", "s"), "spring_n_m": ("stiffness", "N/m")},
    ),
}
"""
ASK_LAW = """
import json
from pathlib import Path

import numpy as np
from numba import njit

from millprint.card.build import _contact_set
from millprint.card.methods import simulation_sentences
from millprint.card.read import read_card
from millprint.config.load import check_model
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.dem.lammps.support import check_law
from millprint.dem.law import law_row, springs
from millprint.dem.laws.registry import LAWS, step_scale
from millprint.dem.speed_choice import at_reference
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.run.digest import simulation_digest
from millprint.run.kernel import kernel_files
from tests.unit.synthetic_mill import summary
from tests.unit.test_card import card_content

# No restitution: the law does not ask for it.
own = dict(name="mine", source="test", static_friction=0.3, rolling_friction=0.0, density_kg_m3=7700)
own |= {"kind": "damping_time", "spring_n_m": 1e5, "damping_time_s": 2e-5}
mine = check_model(own, ContactConfig, "mine.yaml")
assert step_scale(mine, 5e-3) == 1e-5 and mine.restitution is None and at_reference(mine) is mine
assert any(file.name == "damping_time.py" for file in kernel_files()) and simulation_digest() != DIGEST
call = njit(lambda mark, overlap, numbers: springs(mark, overlap, *numbers))
row = law_row(mine, 5e-3, 4e-3, 4e-8, 0.01, 1e-3, 1e-6, 0.0)[:4]
assert np.allclose(call(LAWS["damping_time"].mark(), 1e-4, tuple(row)), [10, 3e4, 2, 0.6, 5e-4])
assert np.allclose(call(LAWS["linear"].mark(), 1e-4, tuple(row)), [10, 3e4, 2, 0.6, 5e-4])
for key, value, words in (
    ("restitution", 0.5, "restitution: not a key of kind: damping_time, which takes spring_n_m, damping_time_s"),
    ("damping_time_s", None, "damping_time_s: this key is missing; kind: damping_time needs it"),
):
    try:
        check_model({**own, key: value}, ContactConfig, "mine.yaml")
    except ConfigError as error:
        assert words in str(error), error
    else:
        raise AssertionError(key)
try:
    check_law(mine)
except ConfigError as error:
    assert str(error).startswith("contact set mine: kind = damping_time: LAMMPS gets hertz, linear; take"), error
else:
    raise AssertionError("LAMMPS took the law")
# The card has the coefficient, and its text the words.
content = card_content() | {"contact_set": json.loads(_contact_set(mine).model_dump_json())}
assert content["contact_set"]["damping_time_s"] == 2e-5 and content["contact_set"]["restitution"] is None
(Path(FOLDER) / "card.json").write_text(json.dumps(content))
said = simulation_sentences(read_card(Path(FOLDER) / "card.json"))[0]
assert "a contact with a damping time (damping time 2e-05 s, static friction 0.3," in said, said
assert "stiffness 100000 N/m" in said and "restitution" not in said, said
# A run without a restitution has descriptors.
runs = [summary(seed=seed) | {"restitution": None, "wall_restitution": None} for seed in range(2)]
table = tabulate_descriptors(runs, "gap_0_03")
assert table["effective_restitution"].isna().all() and table["wall_power_W"].notna().all()
"""
CLAIM = '''

@claim("2.fewest_runs")
def fewest_runs(evidence: Evidence) -> Finding:
    """The smallest fraction."""
    return Finding(evidence.row("doe/fraction.json", "runs")["runs"], "counted")
'''
ASK_CLAIM = """
import re
import shutil
from pathlib import Path

from millprint.thesis.claims.tolerances import judge_value
from millprint.thesis.claims.tabulate import collect_findings
from tools.store_verdicts import TEXTS, written

folder = Path(FOLDER)
row = ["2.fewest_runs", "Table 2.3", "runs of a fraction", "27", "runs", "arithmetic", "stated", "printed", ""]
data = folder / "config/data"
for name in ("config/data", "docs/why", "benchmarks"):
    shutil.copytree(name, folder / name)
for name in ("README.md", "paper.md"):
    shutil.copy(name, folder / name)
said = re.compile(r"It judges (\\d+) claims.*?(\\d+)\\s+arithmetic", re.S)
before = [[int(number) for number in said.search(Path(name).read_text()).groups()] for name in TEXTS[:2]]
with (data / "claims.tsv").open("a") as file:
    file.write("\\t".join(row) + "\\n")
after = [[int(number) for number in said.search(written(folder, name)).groups()] for name in TEXTS[:2]]
assert after == [[number + 1 for number in own] for own in before], (before, after)
(folder / "doe").mkdir()
(folder / "doe/fraction.json").write_text('{"runs": 27}')
found = collect_findings(folder, data / "claims.tsv", "2.fewest_runs")["2.fewest_runs"]
assert judge_value("27", "printed", found).agrees and "doe/fraction.json" in str(found.sources), found
"""

# Of each recipe: (file, text, what stands in its place) of every edit, new files, and the program that asks for it.
RECIPES = {
    "motion": (
        [
            ("config/motion_kinds.py", "class RestMotion(", MOTION.lstrip() + "class RestMotion("),
            ("config/motion_kinds.py", "(RestMotion, ", "(TiltedMotion),\n        MotionKind(RestMotion, "),
        ],
        {},
        ASK_MOTION,
    ),
    "observable": ([("observables/definitions.py", '\n    Measured("closure",', OBSERVABLE)], {}, ASK_OBSERVABLE),
    "regressor": (
        [
            ("thesis/yields/regressors.py", "REGRESSORS = {\n", REGRESSOR.lstrip()),
            ("config/search_spaces.py", '    "gpr_starts": Training(),', SEARCHED),
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
            ("config/contact_laws.py", "@dataclass(frozen=True)", LAW_KEYS + "@dataclass(frozen=True)"),
            ("config/contact_laws.py", "\n}\n", LAW_KIND),
        ],
        {"dem/laws/damping_time.py": LAW},
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
    assert len({name for name, _, _ in edits} | set(files)) <= 2
    path = os.pathsep.join([str(folder / "src"), str(ROOT), str(ROOT / "scripts")])
    given = {**os.environ, "PYTHONPATH": path, "NUMBA_CACHE_DIR": str(folder / "numba")}
    program = f"FOLDER, DIGEST = {str(folder)!r}, {simulation_digest()!r}\n{program}"
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]


@pytest.mark.parametrize("recipe", RECIPES)
@pytest.mark.slow
def test_the_recipe_is_complete(recipe, tmp_path):
    follow(recipe, tmp_path)
