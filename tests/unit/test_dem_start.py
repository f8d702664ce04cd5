"""Starting positions, steps and the Rayleigh time."""

import math
import re

import numpy as np
import pytest
import trimesh
from scipy.spatial.distance import pdist

from millprint.config.errors import ConfigError, SimulationError
from millprint.config.included import load_contact, load_mill
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.case_checks import check_room, checked_bodies
from millprint.dem.laws.registry import step_scale
from millprint.dem.packing import capacity, inside, laid_lattice, pack, thin_direction, widest_ball
from millprint.dem.resources import SKIN_SHARE, aligned_step, longest_step, skin_of
from millprint.dem.simulation import Simulation
from millprint.mill.bodies import build_bodies, inserts_in_vessel
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import build_vessel
from tests.physics.setups import CALIBRATED

VOLUME = 125e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "diameter", "count"),
    [("emax", 0.010, 24), ("emax", 0.010, 95), ("emax", 0.005, 764), ("emax_post", 0.010, 24)],
)
def test_balls_start_apart_and_inside(name, diameter, count):
    vessel = build_vessel(load_mill(name))
    first, again, other = (pack(vessel, diameter, count, seed, VOLUME) for seed in (5, 5, 6))
    assert first.shape == (count, 3)
    assert pdist(first).min() >= diameter
    assert inside(vessel, first, diameter / 2).all()
    assert np.array_equal(first, again)
    assert np.abs(first - other).max() > diameter / 10


def test_too_many_balls_are_refused_with_the_largest_fill():
    vessel = build_vessel(load_mill("emax"))
    most = capacity(vessel, 0.010)
    assert most >= 96
    with pytest.raises(SimulationError, match=f"at most {most}, a fill ratio of") as caught:
        pack(vessel, 0.010, most + 60, 0, VOLUME)
    fill = float(re.search(r"a fill ratio of ([\d.]+)", str(caught.value))[1])
    assert fill == pytest.approx(most * math.pi / 6 * 1e-6 / VOLUME, abs=0.011)


def test_a_ball_without_room_is_told_the_widest_place():
    """An upright jar of 60 mm with a core of 44 mm leaves a ring of 8 mm, and 1 mm above the core."""
    jar = {"kind": "cylinder", "radius_mm": 30, "height_mm": 40, "fillet_ends": "none"}
    core = {"kind": "cylinder", "radius_mm": 22, "height_mm": 39, "fillet_ends": "none", "centre_mm": [0, 0, 19.5]}
    mill = MillConfig(
        name="ring", title="ring", source="made for a test", volume_ml=113.1, geometry=jar, motion={"kind": "rest"},
        inserts=[{"name": "core", "geometry": core, "motion": {"kind": "rotation", "axis": [0, 0, 1]}}],
    )  # fmt: skip
    bodies = build_bodies(mill)
    solids = inserts_in_vessel(bodies)
    assert widest_ball(bodies[0].vessel, solids) == pytest.approx(8e-3, rel=1e-3)
    with pytest.raises(SimulationError, match=r"nowhere is room for a ball of 10 mm; at most (8|7\.99) mm"):
        pack(bodies[0].vessel, 0.010, 20, 0, 113.1e-6, solids)
    with pytest.raises(SimulationError, match=r"packing method"):
        pack(bodies[0].vessel, 0.0079, 100, 0, 113.1e-6, solids)


# A drum of 550 mm with lifters, one and a bit balls of 22 mm wide, as validations of DEM codes simulate it.
SLICE, BALL_MM, BALLS = load_mill("slice_mill"), 22.0, 120


def turned_slice(turn: np.ndarray) -> MillConfig:
    """The mill from a drawing of its hollow, turned by a matrix (3, 3)."""
    vertices, triangles = build_vessel(SLICE).triangles()
    jar = trimesh.Trimesh(1e3 * vertices @ turn.T, triangles[:, ::-1], process=False)
    jar.export("drum.obj", digits=12)
    return MillConfig(
        name="slice", title="slice", source="made for a test", volume_ml=round(jar.volume / 1e3, 1),
        geometry={"kind": "stl", "path": "drum.obj", "unit": "mm"},
        motion={"kind": "rotation", "axis": turn[:, 1].tolist()},
    )  # fmt: skip


def slice_case(fill: float) -> Case:
    return Case(
        mill="slice_mill", contact="steel", ball_diameter_m=BALL_MM / 1e3, fill_ratio=fill, speed_hz=40 / 60, seed=0,
        settle_s=0.002, discard_s=0.0, window_s=0.002, snapshot_interval_s=0.001,
    )  # fmt: skip


@pytest.mark.slow
def test_a_slice_of_a_drum_with_lifters_starts_and_runs():
    """Only a plane of balls that lies across its axis holds them: level planes have one row each in 19 mm of height."""
    mills = {"slice_mill": SLICE}
    bodies = checked_bodies(mills)
    (body,) = bodies["slice_mill"]
    volume, diameter = SLICE.volume_ml * 1e-6, BALL_MM / 1e3
    fill = BALLS * math.pi / 6 * diameter**3 / volume
    check_room([slice_case(fill)], mills, bodies, "test")
    with pytest.raises(ConfigError, match=r"fill_ratios = 0.9: \d+ balls of 22 mm do not fit in mill slice_mill: "):
        check_room([slice_case(0.9)], mills, bodies, "test")
    start, again, other = (pack(body.vessel, diameter, BALLS, seed, volume) for seed in (0, 0, 1))
    assert start.shape == (BALLS, 3)
    assert np.array_equal(start, again)
    assert np.abs(start - other).max() > diameter / 10
    assert pdist(start).min() >= diameter
    assert signed_distance(body.vessel)(start)[0].max() <= -diameter / 2

    contact = load_contact("steel")
    dem = DemConfig(time_step_s=1e-5, settle_s=0.002, window_s=0.002)
    simulation = Simulation(slice_case(fill), SLICE, contact, dem)
    assert simulation.count == BALLS
    simulation.run("test")
    # Under free fall and little else, for 4 ms: balls have begun to fall and are still inside.
    assert simulation.counters[0] >= 400
    now = simulation.counters[0] * simulation.step
    at = simulation.bodies[0].to_body(simulation.balls.position, now)
    assert signed_distance(body.vessel)(at)[0].max() < -0.98 * diameter / 2
    assert simulation.balls.velocity[:, 2].mean() < -0.005


@pytest.mark.slow
def test_a_slice_may_lie_in_any_direction(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3]
    mill = turned_slice(turn)
    vessel, diameter = build_vessel(mill), BALL_MM / 1e3
    assert abs(thin_direction(vessel) @ turn[:, 1]) == pytest.approx(1, abs=1e-9)
    start = pack(vessel, diameter, BALLS, 0, mill.volume_ml * 1e-6)
    assert pdist(start).min() >= diameter
    assert inside(vessel, start, diameter / 2).all()


@pytest.mark.parametrize(("room", "planes"), [(0.9, 0), (1.01, 1), (1.81, 1), (1.83, 2), (2.65, 3)])
def test_planes_are_as_many_as_have_room_and_lie_in_the_middle(room, planes):
    """Two planes of balls take d + sqrt(2/3) d: 1.816 diameters; here GAP adds a thousandth."""
    box = {"kind": "box", "x_mm": 100, "y_mm": 10 * room, "z_mm": 100}
    drawn = {"name": "box", "title": "box", "source": "test", "volume_ml": 100 * room, "motion": {"kind": "rest"}}
    (body,) = build_bodies(MillConfig(**drawn, geometry=box))
    sites = laid_lattice(body.vessel, 0.01, 0.01 * 1.001, 0.3, np.array([0.2, 0.7]))
    levels = np.unique(sites[:, 1].round(9))
    assert len(levels) == planes
    if planes:
        assert levels.mean() == pytest.approx(0, abs=1e-12)
        assert pdist(sites).min() >= 0.01


def test_rayleigh_time_of_a_soft_steel_ball():
    shear = 2.05e9 / (2 * 1.235)
    expected = math.pi * 0.005 * math.sqrt(7700 / shear) / (0.1631 * 0.235 + 0.8766)
    stiff = CALIBRATED.model_copy(update={"young_modulus_gpa": 205.0})
    assert step_scale(CALIBRATED, 0.005) == pytest.approx(expected)
    assert step_scale(CALIBRATED, 0.005) == pytest.approx(10 * step_scale(stiff, 0.005))


def test_aligned_step():
    step, number = aligned_step(2e-6, 1e-4)
    assert number == 50
    assert step == pytest.approx(2e-6)
    step, number = aligned_step(3e-6, 1e-4)
    assert number == 34
    assert step <= 3e-6


def test_a_simulation_begins_from_a_given_start():
    mill = load_mill("planetary")
    contact = load_contact("steel")
    times = {"settle_s": 0.01, "discard_s": 0.0, "window_s": 0.01}
    dem = DemConfig(time_step_s=2e-6)
    case = Case(mill="planetary", contact="steel", ball_diameter_m=0.01, fill_ratio=0.1, speed_hz=5.0, seed=3, **times)
    packed = Simulation(case, mill, contact, dem)
    start = pack(packed.vessel, 0.010, packed.count, 3, mill.volume_ml / 1e6)
    given = Simulation(case.model_copy(update={"seed": 4}), mill, contact, dem, start)
    packed.run("packed")
    given.run("given")
    assert np.array_equal(given.balls.position, packed.balls.position)
    with pytest.raises(SimulationError, match=rf"a start of shape \(1, 3\): it must have {packed.count} rows"):
        Simulation(case, mill, contact, dem, start[:1])


def test_the_longest_step_is_that_of_the_cases_of_a_ball_as_it_is():
    """Each ball size by its own sweep; a case of heavier balls, whose steps are longer, does not count."""
    contact = load_contact("calibrated")
    common = {"mill": "emax", "contact": "calibrated", "fill_ratio": 0.1, "speed_hz": 10, "seed": 0}
    common |= {"settle_s": 0.1, "discard_s": 0.1, "window_s": 0.1}
    cases = [
        Case(ball_diameter_m=0.01, **common),
        Case(ball_diameter_m=0.01, rayleigh_fraction=0.076, density_kg_m3=15000, **common),
        Case(ball_diameter_m=0.005, rayleigh_fraction=0.076, **common),
    ]
    found = [longest_step(ball, cases, {"calibrated": contact}, DemConfig()) for ball in (0.01, 0.005, 0.003)]
    assert found == pytest.approx([4e-6, 0.076 * step_scale(CALIBRATED, 0.0025), 4e-6])


def test_the_skin_goes_with_the_ball_and_the_root_of_the_step():
    assert skin_of(5e-3, 0.16) == pytest.approx(SKIN_SHARE * 5e-3 * 0.4)
    assert skin_of(5e-3, 0.16) == pytest.approx(2 * skin_of(5e-3, 0.04))
