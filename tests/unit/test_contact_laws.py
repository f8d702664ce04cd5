"""What every contact law must have, and linear springs in all that depends on the law; physics/cases has impacts."""

import json
import math
from pathlib import Path

import pytest

from millprint.cases.of_mill import study_variants
from millprint.config.contact_set import ContactConfig
from millprint.config.dose import FlashSection
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.included import load_mill
from millprint.config.sweep import overridden
from millprint.config.uncertainty import UncertaintyConfig
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import LAWS, step_scale
from millprint.dose import flash
from millprint.uncertainty.samples import check_contact, space_of
from tests.unit.test_dem_faults import DEM, MILL, PRESSED, simulation, stopped_at_a_wall
from tests.unit.test_heat import write_run
from tests.unit.test_study import MILLS, STUDY

COMMON = {"name": "soft", "source": "made up", "restitution": 0.5, "static_friction": 0.3, "rolling_friction": 0.01,
          "density_kg_m3": 7800}  # fmt: skip
KEYS = {
    "hertz": {"young_modulus_gpa": 2.0, "poisson_ratio": 0.3},
    "linear": {"normal_stiffness_n_m": 1e6, "tangential_stiffness_ratio": 2 / 7},
}
SETS = {kind: ContactConfig(**COMMON, kind=kind, **keys) for kind, keys in KEYS.items()}
SOFT = SETS["linear"]


@pytest.mark.parametrize("kind", LAWS)
def test_the_energy_of_the_normal_spring_is_the_work_of_its_force(kind):
    law, mass, speed = LAWS[kind], 4e-3, 1.0
    numbers = law.coefficients(SETS[kind], 5e-3, mass)
    overlap, duration = law.impact(mass, numbers[0], speed)
    assert law.springs(overlap, *numbers)[-1] == pytest.approx(mass * speed**2 / 2)
    below, above = (law.springs(overlap * factor, *numbers) for factor in (1 - 1e-6, 1 + 1e-6))
    assert (above[-1] - below[-1]) / (2e-6 * overlap) == pytest.approx(law.springs(overlap, *numbers)[0], rel=1e-6)
    # At the largest step that is usually allowed, an impact takes some twenty steps.
    assert 12 < duration / (0.2 * step_scale(SETS[kind], 5e-3)) < 40


def test_the_scale_of_a_linear_step_is_of_the_faster_spring():
    duration = math.pi * math.sqrt(ball_mass(SOFT, 5e-3) / 2 / 1e6)
    assert step_scale(SOFT, 5e-3) == pytest.approx(0.2 * duration)
    stiff = SOFT.model_copy(update={"tangential_stiffness_ratio": 8 / 7})
    assert step_scale(stiff, 5e-3) == pytest.approx(0.2 * duration / 2)


def test_a_step_that_is_too_long_for_linear_springs_is_refused():
    with pytest.raises(
        SimulationError, match=r"time step of 4e-05 s is [\d.]+ of a fifth of an impact's duration; at m"
    ):
        simulation(DEM.model_copy(update={"time_step_s": 4e-5}), SOFT)


def test_an_overlap_asks_for_a_larger_stiffness():
    line = stopped_at_a_wall(PRESSED, 30.0, contact=SOFT)
    mass, bound = ball_mass(SOFT, 5e-3), 0.15 * 5e-3
    assert "the speed is too high for this normal stiffness: " in line
    assert f"it needs {mass * (30.0 / bound) ** 2:.3g} N/m in place of 1e+06, or a slower mill" in line


def test_what_needs_a_young_modulus_refuses_a_law_without_one(tmp_path, caplog):
    case = simulation().case
    line = "contact set soft: kind: linear has no young_modulus_gpa, which is needed here"
    with pytest.raises(ConfigError, match=line):
        overridden(case.model_copy(update={"young_modulus_gpa": 3.0}), MILL, SOFT)
    with pytest.raises(ConfigError, match=line):
        check_contact(space_of(load_mill("planetary"), UncertaintyConfig()), SOFT)
    variants = study_variants(load_mill("planetary"), SOFT, MILLS, DEM, STUDY, {})
    assert {variant.setting for variant in variants} == {"reference", "time_step", "facets"}
    files = write_run(tmp_path / "run")
    summary = json.loads(Path(files[0]).read_text()) | {"young_modulus_pa": None, "contact": "soft"}
    assert flash.read_impacts(files[1], summary, FlashSection()) is None
    assert "no flash temperatures of soft: they follow from Hertz's law" in caplog.text
