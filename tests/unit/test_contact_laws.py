"""What every contact law must have, and linear springs in all that depends on the law; physics/cases has impacts."""

import json
import math
from pathlib import Path
from typing import NamedTuple

import numba
import numpy as np
import pytest

from millprint.cases.of_mill import study_variants
from millprint.config.contact_set import ContactConfig
from millprint.config.dose import FlashSection
from millprint.config.errors import ConfigError, SimulationError
from millprint.config.fingerprint import UncertaintyConfig
from millprint.config.included import load_mill
from millprint.config.sweep import overridden
from millprint.dem.contact_events import share_resistance, sort_found
from millprint.dem.law import STOP_SHARE, evaluate_block, law_row
from millprint.dem.laws.record import ball_mass
from millprint.dem.laws.registry import LAWS, step_scale
from millprint.dem.layout import COUNTER, LANE, LANES, PRESENT
from millprint.dose import flash
from millprint.mill.kernel_columns import span_of, width_of
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


def test_a_row_of_coefficients_is_by_hand():
    # R* = 2 mm, m* = 3 g, I* = 5e-9 kg m2; E* = 2e9 / 1.82, G* = 2e9 / (4 * 1.7 * 1.3); beta of 0.5 is -0.2154538.
    hertz, linear = (law_row(SETS[kind], 2e-3, 3e-3, 5e-9, 8e-3, 1e-4, 2e-6, 0.25) for kind in ("hertz", "linear"))
    slope, shear, root = 2e9 / 1.82, 2e9 / (4 * 1.7 * 1.3), math.sqrt(2e-3)
    normal = 2 * math.sqrt(5 / 6) * 0.2154538 * math.sqrt(2 * slope * root * 3e-3)
    tangential = 2 * math.sqrt(5 / 6) * 0.2154538 * math.sqrt(8 * shear * root * 3e-3)
    assert hertz[:4] == pytest.approx([4 / 3 * slope * root, 8 * shear * root, normal, tangential], rel=1e-6)
    damping = 2 * 0.2154538 * np.sqrt([1e6 * 3e-3, 2e6 / 7 * 3e-3])
    assert linear[:4] == pytest.approx([1e6, 2e6 / 7, *damping], rel=1e-6)
    for row in (hertz, linear):
        assert row[4:] == pytest.approx([0.3, 0.01, 5e-9 / 24 / 2e-6, 8e-3, 1e-4, 0.25]) and len(row) == 10
    assert STOP_SHARE == 1 / 24


def by_hand(kind, law, is_wall, difference, history, present, step):
    """Force, both torques, spring, works and energies of a contact by Eqs 3.3 to 3.16, with vectors of numpy."""
    kn, kt, cn, ct, friction, rolling, largest, reach, _, pull = law
    spring, last_slip, share = history
    away, velocity, angular, other_angular = present
    distance = np.linalg.norm(away)
    normal, overlap = away / distance, reach - distance
    first, second = (reach + difference) / 2, (reach - difference) / 2
    arm = distance if is_wall else (distance**2 + first**2 - second**2) / (2 * distance)
    other = distance - arm
    lever = arm if is_wall else 2 * arm * other / (arm + other)
    velocity = velocity + np.cross(angular, -arm * normal) - np.cross(other_angular, other * normal)
    power = 0.5 if kind == "hertz" else 0.0
    elastic = kn * overlap ** (1 + power)
    kt, cn, ct = kt * overlap**power, cn * overlap ** (power / 2), ct * overlap ** (power / 2)
    approach = velocity @ normal
    slip = velocity - approach * normal
    flat = spring - (spring @ normal) * normal
    spring = flat * np.linalg.norm(spring) / np.linalg.norm(flat) + step * (slip + last_slip) / 2
    cap = friction * elastic
    spring = spring * min(1.0, cap / kt / np.linalg.norm(spring))
    force = -kt * spring - ct * slip
    slides = np.linalg.norm(force) > cap
    force = force * cap / np.linalg.norm(force) if slides else force
    turning = angular - other_angular
    torque = -min(rolling * elastic * lever / np.linalg.norm(turning), share * largest) * turning
    works = step * np.array([cn * approach**2, 0 if slides else ct * slip @ slip, -force @ slip, -torque @ turning])
    whole = force + (elastic - cn * approach - pull) * normal
    energies = elastic * overlap / (2 + power) - pull * overlap, kt * spring @ spring / 2
    torques = np.cross(-arm * normal, whole) + torque, np.cross(other * normal, -whole) - torque
    return slides, whole, torques, spring, slip, works, energies, elastic - cn * approach - pull, overlap


@pytest.mark.parametrize("kind", LAWS)
def test_a_block_of_contacts_is_the_law_by_hand(kind):
    """Pairs and walls that stick and slide, roll freely and at the bound; linear springs with cohesion."""
    pull = 0.7 if kind == "linear" else 0.0
    mark = LAWS[kind].cohesive_mark() if pull else LAWS[kind].mark()
    lanes, present = (np.ones((1, width_of(columns) * LANES)) for columns in (LANE, PRESENT))
    step = 2e-6
    numbers = np.random.default_rng(1)
    contacts = []
    for m in range(LANES):
        is_wall, slides, is_bound = m % 2, m // 2 % 2, m // 4
        difference = 0.0 if is_wall else (-1) ** (m // 2) * 2e-3
        stiff = (1.4e8, 0.9e8, 15.0, 11.0) if kind == "hertz" else (1e6, 3e5, 24.0, 13.0)
        law = np.array([*stiff, 0.3, 0.02, 1e-9 if is_bound else 1.0, 8e-3, 1e-4, pull])
        normal = np.array([0.48, -0.6, 0.64])
        across = np.cross(normal, [0.0, 0.0, 1.0])
        history = (across * (4e-5 if slides else 1e-6) + 1e-9 * normal, 0.1 * across, 0.8)
        angular, other_angular = numbers.normal(scale=0.5, size=(2, 3))
        fall = (0.2 if m % 3 else -0.1) * normal + (3.0 if slides else 0.02) * across
        given = ((8e-3 - 3e-5) * normal, fall, angular, 0 * angular if is_wall else other_angular)
        for place, value in ((LANE.is_wall, is_wall), (LANE.radius_difference, difference)):
            lanes[0, place * LANES + m] = value
        for place, value in zip(range(*span_of(LANE.law).indices(len(lanes[0]))), law, strict=True):
            lanes[0, place * LANES + m] = value
        for vector, value in ((LANE.history.spring, history[0]), (LANE.history.last_slip, history[1])):
            lanes[0, np.array(vector) * LANES + m] = value
        lanes[0, LANE.history.resistance * LANES + m] = history[2]
        for place in (LANE.history.peak_force, LANE.history.peak_overlap):
            lanes[0, place * LANES + m] = 1e9 if m == 0 else 0.0
        for vector, value in zip((PRESENT.away, PRESENT.velocity, PRESENT.angular_velocity,
                                  PRESENT.other_angular_velocity), given, strict=True):  # fmt: skip
            present[0, np.array(vector) * LANES + m] = value
        contacts.append(by_hand(kind, law, is_wall, difference, history, given, step))
    call = numba.njit(lambda mark, lanes, present, step: evaluate_block(mark, lanes, 0, present, 0, step))
    call(mark, lanes, present, step)

    def of(block, columns, m):
        return block[0, np.array(columns) * LANES + m]

    assert [bool(each[0]) for each in contacts] == [bool(m // 2 % 2) for m in range(LANES)]
    for m, (_, force, torques, spring, slip, works, energies, normal_force, overlap) in enumerate(contacts):
        assert of(lanes, LANE.force, m) == pytest.approx(force, rel=1e-6)
        assert of(present, PRESENT.torque, m) == pytest.approx(torques[0], rel=1e-6)
        assert of(present, PRESENT.other_torque, m) == pytest.approx(torques[1], rel=1e-6, abs=1e-12)
        assert of(lanes, LANE.history.spring, m) == pytest.approx(spring, rel=1e-6, abs=1e-18)
        assert of(lanes, LANE.history.last_slip, m) == pytest.approx(slip, rel=1e-9, abs=1e-15)
        assert of(lanes, LANE.history.works, m) - 1 == pytest.approx(works, rel=1e-4, abs=1e-13)
        assert of(lanes, [LANE.elastic_normal, LANE.elastic_tangential], m) == pytest.approx(energies, rel=1e-6)
        peaks = of(lanes, [LANE.history.peak_force, LANE.history.peak_overlap], m)
        assert peaks == pytest.approx([1e9, 1e9] if m == 0 else [max(normal_force, 0), overlap], rel=1e-6)


class Balls(NamedTuple):
    touching: np.ndarray


class Contacts(NamedTuple):
    lanes: np.ndarray
    slot: np.ndarray
    ball: np.ndarray
    partner: np.ndarray


def test_rolling_friction_is_shared_by_the_contacts_of_the_ball_with_most():
    """Shares of a twelfth: 12 over the contacts of a ball, of at least 2 and at most 12; a free lane keeps its own."""
    pairs = [(0, -1), (1, 2), (1, -1), (3, 1), (0, 1), *13 * [(4, -1)]]
    ball, partner = np.array(pairs).T
    slot = np.where(np.arange(len(pairs)) == 4, -1, 0)
    contacts = Contacts(np.full((3, width_of(LANE) * LANES), 7.0), slot, ball, partner)
    counters = np.zeros(width_of(COUNTER), dtype=np.int64)
    counters[COUNTER.used] = len(pairs)
    balls = Balls(np.zeros(5, dtype=np.int64))
    numba.njit(lambda balls, contacts, counters: share_resistance(balls, contacts, counters))(balls, contacts, counters)
    first = LANE.history.resistance * LANES
    found = contacts.lanes[:, first : first + LANES].ravel()[: len(pairs)]
    assert found.tolist() == [6, 4, 4, 4, 7, *13 * [1]] and balls.touching.tolist() == [1, 3, 1, 1, 13]


def test_what_has_come_within_reach_is_put_in_order():
    found = np.array([5, 2, 9, 0, 7, 3, 1], dtype=np.uint32)
    numba.njit(lambda found, count: sort_found(found, count))(found, 5)
    assert found.tolist() == [0, 2, 5, 7, 9, 3, 1]


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
