"""Tables, settings and models with a wrong value: one line names the file, the column or key, and the value."""

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.config import BenchConfig
from millprint.config.calibration import CalibrationConfig
from millprint.config.charge import BallMixture, fill_of
from millprint.config.contact_set import ContactConfig
from millprint.config.doe import DoeConfig
from millprint.config.fingerprint import MatchConfig, UncertaintyConfig
from millprint.config.load import check_model, read_yaml
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig, with_fill_ratios
from millprint.config.surrogate import SurrogateConfig
from millprint.config.sweep import SweepConfig
from millprint.config.workflow import WorkflowConfig
from millprint.config.yields import YieldConfig
from millprint.dose.kinetics import own_doses
from millprint.dose.wear import read_materials
from millprint.thesis.doe.chemistry import read_literature
from millprint.thesis.doe.factorial_designs import read_runs
from millprint.thesis.doe.wet_lab import read_wear, yield_table
from millprint.thesis.drop import read_heights, read_track
from millprint.thesis.regimes import read_regimes
from millprint.thesis.yields.experiments import read_experiments, read_parts, read_rows
from tests.conftest import ROOT, configuration
from tests.refusals import refusal, refusals
from tests.unit import doe_settings, yield_settings
from tests.unit.doe_settings import SCREENING
from tests.unit.synthetic_mill import fingerprint
from tests.unit.test_contact_laws import COMMON, KEYS
from tests.unit.test_mill_lifters import DRUM, LIFTERS

DATA = ROOT / "config/data"
FACTORS = doe_settings.settings().factors


def stored(name: str) -> pd.DataFrame:
    return pd.read_csv(DATA / name, sep="\t", comment="#", dtype=str, keep_default_na=False)


def table(rows: int = 2, **columns) -> pd.DataFrame:
    """A table of equal rows, but for the cases."""
    frame = pd.DataFrame(columns, index=range(rows)).astype(str)
    return frame.assign(case=[f"r{row}" for row in range(rows)]) if "case" in columns else frame


MILL = fingerprint().about["mill"]
PLACE = {"fill_ratio": 0.08, "speed_rpm": 900, "ball_diameter_mm": 10}
GAS = {"gas_volume_ml": 578.6, "temperature_k": 298.15, "pressure_pa": 101325, "limiting_mass_g": 1.11}
ENERGIES = {"normal_energy_uJ": 221, "tangential_energy_uJ": 500, "specific_frequency_hz": 400}
CHARGE = {"bpr": 40, "molar_ratio": 10, "time_h": 17.5}

# The good table, and what reads it.
READERS: dict[str, tuple[pd.DataFrame, Callable]] = {
    "screening": (stored("screening.tsv"), lambda path: read_runs(path, FACTORS)),
    "yields": (stored("screening.tsv"), lambda path: read_parts(path, str(yield_settings.SPLIT), FACTORS)),
    "split": (stored("split.tsv"), lambda path: read_parts(str(SCREENING), path, FACTORS)),
    "outside": (stored("out_of_domain.tsv"), read_rows),
    "conditions": (table(case="", **CHARGE, **ENERGIES), lambda path: read_rows(path, yields=False)),
    "experiments": (
        table(case="", status="done", **CHARGE, **PLACE, yield_percent=93),
        lambda path: read_experiments(path, read_regimes(str(DATA / "regimes.tsv")), ["24"]),
    ),
    "regimes": (stored("regimes.tsv"), read_regimes),
    "literature": (stored("literature.tsv"), read_literature),
    "weighings": (stored("wear.tsv"), read_wear),
    "materials": (stored("wear_materials.tsv"), lambda path: read_materials(path, "stainless_steel")),
    "gas": (
        table(case="", **GAS, gas_volume_error_ml=1),
        lambda path: yield_table(path, doe_settings.settings().chemistry, doe_settings.settings().gas),
    ),
    "drops": (table(drop_height_mm=10, bounce_height_mm=1), read_heights),
    "track": (table(30, across_mm=1).assign(time_s=[str(k / 50) for k in range(30)]), read_track),
    "dose": (
        table(case="", mill=MILL, powder_mass_g=2, time_h=1, **PLACE),
        lambda path: own_doses(path, {MILL: fingerprint()}),
    ),
}

# A column that is left out, or the column and the wrong value of its first row.
WRONG = {
    "screening": "case, case=2, case=, time_h, bpr=ten, bpr=12.5, speed_rpm=700, run_order=first, yield_percent, "
    "yield_percent=, yield_percent=NaN, yield_percent=inf, yield_percent=140, yield_percent=-3",
    "yields": "normal_energy_uJ, normal_energy_uJ=-221, yield_percent=plenty, yield_percent=140, case=2",
    "split": "case, case=14, role=validation",
    "outside": "yield_percent=194",
    "conditions": "bpr, bpr=-1, time_h=long, case=r1",
    "experiments": "case=24, case=r1, status=finished, speed_rpm, time_h=long, bpr=-1, fill_ratio=0.4, yield_percent=, "
    "yield_percent=120",
    "regimes": "case=power.normal, mode=base, balls=many, fill_ratio=-0.17, molar_ratio, yield_percent, "
    "yield_percent=140, yield_percent=much",
    "literature": "reference=12, borate=sand, speed_rpm=fast, bpr=-3, balls=4/2, ball_diameter_mm=thick, "
    "yield_percent=140, yield_percent=",
    "weighings": "used_mass_g=98.0, wear_g=0.5, bpr=0, time_h=long",
    "materials": "material=inox, material=alumina, hardness_hv, hardness_hv=55, hardness_hv=very, density_kg_m3=7.7, "
    "iron_share=85",
    "gas": "case, case=r1, case=, gas_volume_ml, gas_volume_ml=much, gas_volume_ml=, gas_volume_ml=nan, "
    "gas_volume_ml=inf, gas_volume_ml=-1, gas_volume_ml=1141, temperature_k=25, pressure_pa=1013, limiting_mass_g, "
    "limiting_mass_g=0, gas_volume_error_ml=-2, gas_volume_error_ml=",
    "drops": "drop_height_mm=-10, bounce_height_mm, bounce_height_mm=11",
    "track": "across_mm, across_mm=lost, time_s=-1, time_s=0.5",
    "dose": "case=r1, mill=emaks, powder_mass_g=0.0, time_h=-1.0, fill_ratio=1.5",
}


def refused(name: str, folder: Path, frame: pd.DataFrame) -> str:
    path = str(folder / f"{name}.tsv")
    frame.to_csv(path, sep="\t", index=False)
    line = refusal(READERS[name][1], path)
    assert path in line
    return line


@pytest.mark.parametrize("name", READERS)
def test_a_wrong_cell_is_refused_in_one_line_that_names_it(tmp_path, name):
    good, read = READERS[name]
    good.to_csv(tmp_path / "good.tsv", sep="\t", index=False)
    read(str(tmp_path / "good.tsv"))
    for column, given, value in (item.partition("=") for item in WRONG[name].split(", ")):
        wrong = good.assign(**{column: good.get(column, "1")}) if given else good.drop(columns=column)
        if given:
            wrong.loc[0, column] = value
        line = refused(name, tmp_path, wrong)
        number = f"{pd.to_numeric(value, errors='coerce'):g}"
        assert column in line and (value.lower() in line.lower() or number in line), (column, value, line)


def test_what_only_several_rows_show_is_refused(tmp_path):
    screening, split = READERS["screening"][0], READERS["split"][0]
    assert "run_order" in refused("screening", tmp_path, screening.assign(run_order=1))
    assert "case 9" in refused("split", tmp_path, split[split["case"] != "9"])
    assert "case = 28" in refused("split", tmp_path, pd.concat([split, split.head(1).assign(case="28")]))
    assert "test" in refused("split", tmp_path, split.assign(role="train"))
    assert "yield_percent" in refused("experiments", tmp_path, READERS["experiments"][0].assign(status="running"))
    assert "reference" in refused("regimes", tmp_path, READERS["regimes"][0].assign(mode="speed"))
    for name in set(READERS) - {"experiments"}:
        assert refused(name, tmp_path, READERS[name][0].head(0)), "a table of experiments may still be empty"
    drops, track = READERS["drops"][0], READERS["track"][0]
    assert "at least 2" in refused("drops", tmp_path, drops.head(1))
    assert "at least 20" in refused("track", tmp_path, track.head(5))
    gas = READERS["gas"][0]
    assert "vapour" in refused("gas", tmp_path, gas.assign(temperature_k=370, pressure_pa=8e4))


def bench() -> dict:
    return read_yaml(ROOT / "benchmarks/bench.yaml")


def heat() -> dict:
    return {"mill": "emax", "dose": {"heat": {}}}


SECTIONS: dict[str, tuple[Callable[[], dict], type]] = {
    "doe": (doe_settings.thesis_settings, DoeConfig),
    "yields": (yield_settings.thesis_yields, YieldConfig),
    "surrogate": (lambda: configuration()["surrogate"], SurrogateConfig),
    "calibration": (lambda: configuration()["calibration"], CalibrationConfig),
    "heat": (heat, WorkflowConfig),
    "bench": (bench, BenchConfig),
}


@pytest.mark.parametrize(
    ("section", "key", "value", "part"), refusals("a_wrong_setting_is_refused_in_one_line_that_names_its_key")
)
def test_a_wrong_setting_is_refused_in_one_line_that_names_its_key(section, key, value, part):
    make, model = SECTIONS[section]
    content = deepcopy(make())
    check_model(content, model, "config.yaml")
    *place, last = (int(name) if name.isdigit() else name for name in key.split("."))
    inner = content
    for name in place:
        inner = inner.setdefault(name, {}) if isinstance(inner, dict) else inner[name]
    inner[last] = value
    line = refusal(check_model, content, model, "config.yaml")
    assert line.startswith("config.yaml: ") and str(last).removesuffix("s") in line and part in line, line


MINE = {"name": "mine", "sizes_mm": (10, 5)}
JAR = {"speeds_rpm": [60, 90], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3]}
STEPS = {"name": "s", "contacts": ["steel"], "ball_diameters_mm": [10], "fill_ratios": [0.1], "speeds_rpm": [600],
         "seeds": [0], "time_steps_s": [1e-6, 2e-6]}  # fmt: skip
REQUEST = {"speeds_rpm": [300, 1200], "fill_ratios": [0.04, 0.40], "ball_diameters_mm": [5, 8, 10]}
EMAX = read_yaml(ROOT / "config/mills/emax.yaml")
FILE = {"kind": "stl", "path": "jar.stl", "unit": "mm"}


def model(of: type, base: dict, file: str) -> Callable[[dict], object]:
    """What reads a model whose base has some other keys."""
    return lambda change: check_model(base | change, of, file)


# What reads an input, by name.
TAKEN: dict[str, Callable] = {
    "charge": lambda given: fill_of(given, 200.0, 10, 8000.0, "balls"),
    "keys of a sweep": lambda given: with_fill_ratios(check_model(given, MillSweepConfig, "sweep"), 200, 8e3, "sweep"),
    "sweep": model(MillSweepConfig, JAR, "mine.yaml"),
    "steps": model(SweepConfig, STEPS, "mine.yaml"),
    "ball sizes": lambda size: check_model(JAR | {"ball_diameters_mm": [size]}, MillSweepConfig, "mine.yaml"),
    "two sizes": lambda sizes: check_model(JAR | {"ball_diameters_mm": sizes}, MillSweepConfig, "mine.yaml"),
    "mixture": model(BallMixture, MINE, "mine.yaml"),
    "uncertainty": model(UncertaintyConfig, {}, "mine.yaml"),
    "mill": model(MillConfig, EMAX, "config/mills/emax.yaml"),
    "motion": lambda law: check_model(EMAX | {"motion": law}, MillConfig, "config/mills/emax.yaml"),
    "geometry": lambda given: check_model(EMAX | {"geometry": EMAX["geometry"] | given}, MillConfig, "emax.yaml"),
    "geometry of a file": lambda given: check_model(EMAX | {"geometry": FILE | given}, MillConfig, "emax.yaml"),
    "lifters": lambda given: check_model(
        EMAX | {"geometry": DRUM | {"lifters": LIFTERS | given}}, MillConfig, "m.yaml"
    ),
    "solid": lambda given: check_model(EMAX | {"inserts": [{"name": "a", "geometry": given}]}, MillConfig, "m.yaml"),
    "contact law": model(ContactConfig, {**COMMON, "kind": "linear", **KEYS["linear"]}, "soft.yaml"),
    "contact set": model(ContactConfig, {**COMMON, "kind": "hertz", **KEYS["hertz"]}, "soft.yaml"),
    "cohesion": lambda given: check_model(
        {**COMMON, "kind": "hertz", **KEYS["hertz"], "cohesion": given}, ContactConfig, "soft.yaml"
    ),
    "request": model(MatchConfig, REQUEST, "request.yaml"),
    "run": model(WorkflowConfig, {}, "--config"),
}


@pytest.mark.parametrize(("what", "given", "parts"), refusals("a_model_refuses_what_it_cannot_take"))
def test_a_model_refuses_what_it_cannot_take(what, given, parts):
    line = refusal(TAKEN[what], given)
    assert all(part in line for part in parts), line
