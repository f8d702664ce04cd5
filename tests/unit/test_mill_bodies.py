"""Several bodies: a vessel and what moves inside it."""

import math

import numpy as np
import pytest
import trimesh
from scipy.spatial.distance import pdist

from millprint.config.errors import ConfigError, SimulationError
from millprint.config.load import check_model
from millprint.config.mill import MillConfig
from millprint.dem.case_checks import checked_bodies
from millprint.dem.packing import capacity, inside, pack
from millprint.mill.bodies import ball_space_m3, build_bodies, check_inserts, inserts_in_vessel, travel_m, volume_within
from millprint.mill.distance import signed_distance
from millprint.mill.vessel import build_vessel
from tests.poses import angular_velocity
from tests.refusals import refusal

TANK = {"kind": "cylinder", "radius_mm": 50, "height_mm": 100}
STIRRER = {
    "kind": "paddles", "hub_radius_mm": 8, "blades": 4, "blade_length_mm": 30, "blade_thickness_mm": 6,
    "height_mm": 60, "bottom_mm": 15,
}  # fmt: skip
TURNING = {"kind": "rotation", "axis": [0, 0, 1]}
ROD = {"kind": "cylinder", "radius_mm": 3, "height_mm": 60, "facets": 12}


def mill(geometry=TANK, motion=None, inserts=(), **changes) -> MillConfig:
    content = {
        "name": "made", "title": "made", "source": "made", "volume_ml": 783, "geometry": geometry,
        "motion": motion or {"kind": "rest"}, "inserts": list(inserts),
    }  # fmt: skip
    return check_model({**content, **changes}, MillConfig, "made.yaml")


def attritor(**changes) -> MillConfig:
    return mill(inserts=[{"name": "stirrer", "geometry": {**STIRRER, **changes}, "motion": TURNING}])


def check(made: MillConfig) -> None:
    check_inserts(made, build_bodies(made))


def distance_to_walls(bodies, points, time_s):
    """Signed distance (n,) [m], its gradient (n, 3) and the nearest body (n,) at points (n, 3) of the laboratory."""
    points = np.asarray(points, dtype=float)
    found = [signed_distance(body.vessel)(body.to_body(points, time_s)) for body in bodies]
    distances = np.array([distance for distance, _ in found])
    gradients = np.array(
        [slope @ body.motion.rotation(time_s).T for body, (_, slope) in zip(bodies, found, strict=True)]
    )
    # Balls can be inside the vessel and outside every insert: the largest of the distances counts.
    nearest = distances.argmax(axis=0)
    return distances.max(axis=0), gradients[nearest, np.arange(len(points))], nearest


def test_an_attritor_is_a_tank_and_a_stirrer_that_turns():
    tank, stirrer = bodies = build_bodies(attritor(), 5.0)
    assert [body.name for body in bodies] == ["vessel", "stirrer"]
    assert not tank.vessel.solid and stirrer.vessel.solid
    assert not tank.motion.turns
    assert angular_velocity(stirrer.motion, 0.1) == pytest.approx([0, 0, 10 * np.pi])
    assert ball_space_m3(bodies) == pytest.approx(tank.vessel.volume_m3 + stirrer.vessel.volume_m3)
    assert ball_space_m3(bodies) < tank.vessel.volume_m3
    check(attritor())


def test_an_impeller_from_a_file_is_the_one_by_parameters(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    expected = build_bodies(attritor())
    # A solid's walls face out of it, as a file's normals do.
    trimesh.Trimesh(*expected[1].vessel.triangles(), process=False).export("stirrer.stl")
    geometry = {"kind": "stl", "path": "stirrer.stl", "unit": "m"}
    made = mill(inserts=[{"name": "stirrer", "geometry": geometry, "motion": TURNING}])
    found = build_bodies(made)
    check(made)
    assert made.source_files == ["stirrer.stl"]
    assert len(found[1].vessel.facets) == len(expected[1].vessel.facets)
    assert ball_space_m3(found) == pytest.approx(ball_space_m3(expected), rel=1e-6)
    points = np.random.default_rng(0).uniform([-0.04, -0.04, 0.01], [0.04, 0.04, 0.09], (300, 3))
    assert distance_to_walls(found, points, 0.3)[0] == pytest.approx(
        distance_to_walls(expected, points, 0.3)[0], abs=1e-8
    )


def test_travel_is_the_amplitude_the_radius_or_the_reach():
    assert travel_m(build_bodies(mill(motion={"kind": "circle", "amplitude_mm": 17}), 10.0)) == pytest.approx(0.017)
    drum = mill({**TANK, "axis": "y"}, {"kind": "rotation", "axis": [0, 1, 0]})
    assert travel_m(build_bodies(drum)) == pytest.approx(0.05, rel=1e-3)
    # The tip of a blade: its corner lies a little farther out than its length.
    assert travel_m(build_bodies(attritor())) == pytest.approx(math.hypot(0.038, 0.003), rel=1e-3)


def refused(made: MillConfig) -> str:
    message = refusal(check, made)
    assert message.startswith("config/mills/made.yaml: inserts: ")
    return message


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"blade_length_mm": 43}, "stirrer meets vessel"),
        ({"bottom_mm": -5}, "stirrer meets vessel"),
        ({"height_mm": 90}, "stirrer meets vessel"),
        ({"height_mm": 85}, "stirrer meets vessel"),  # its top in the plane of the lid, along which it would rub
    ],
)
def test_a_stirrer_that_reaches_a_wall_is_refused(changes, message):
    assert message in refused(attritor(**changes))


def test_a_stirrer_that_meets_a_wall_only_when_turned_is_refused():
    box = {"kind": "box", "x_mm": 100, "y_mm": 60, "z_mm": 100}
    one = {"name": "stirrer", "geometry": {**STIRRER, "blades": 1}, "motion": TURNING}
    assert "stirrer meets vessel at (" in refused(mill(box, inserts=[one]))
    check(mill({**box, "y_mm": 80}, inserts=[one]))


@pytest.mark.slow
def test_a_slow_stirrer_is_followed_through_its_whole_turn():
    box = {"kind": "box", "x_mm": 100, "y_mm": 80, "z_mm": 100, "centre_mm": [0, 4, 50]}
    slow = {"name": "stirrer", "geometry": {**STIRRER, "blades": 1}, "motion": {**TURNING, "ratio": 0.1}}
    # The blade meets the near wall after three quarters of its turn, long after the mill's first.
    assert "turns" in refused(mill(box, inserts=[slow]))
    check(mill({**box, "centre_mm": [0, 0, 50]}, inserts=[slow]))


def test_an_insert_that_stays_while_the_jar_moves_is_refused():
    circle = {"kind": "circle", "amplitude_mm": 30}
    rod = {"name": "rod", "geometry": {**ROD, "centre_mm": [25, 0, 50]}}
    check(mill(motion=circle, inserts=[rod]))
    assert "rod meets vessel" in refused(mill(motion=circle, inserts=[{**rod, "motion": {"kind": "rest"}}]))


def test_what_moves_with_the_vessel_may_stand_on_its_floor():
    check(mill(inserts=[{"name": "baffle", "geometry": {"kind": "box", "x_mm": 10, "y_mm": 20, "z_mm": 30}}]))


CRATE = {"kind": "box", "x_mm": 80, "y_mm": 60, "z_mm": 50}


def baffle(sunk_mm=3.0, z_mm=70, **changes):
    """A plate, 4 by 8 mm in the hollow and of a height, on the wall at y = 30 mm and `sunk_mm` into it."""
    size = {"x_mm": 4, "y_mm": 8 + sunk_mm, "z_mm": z_mm, "centre_mm": [10, 30 - (8 - sunk_mm) / 2, 20]}
    return {"name": "baffle", "geometry": {"kind": "box", **size}, **changes}


@pytest.mark.parametrize(("sunk_mm", "z_mm"), [(3.0, 70), (0.01, 70), (0.0, 70), (3.0, 52)])
def test_an_insert_that_moves_with_the_vessel_may_stand_in_its_wall(sunk_mm, z_mm):
    made = mill(CRATE, {"kind": "circle", "amplitude_mm": 10}, [baffle(sunk_mm, z_mm)])
    bodies = build_bodies(made)
    check(made)
    height = min(50, 20 + z_mm / 2)
    assert ball_space_m3(bodies) == pytest.approx((80 * 60 * 50 - 4 * 8 * height) * 1e-9, rel=1e-6)


@pytest.mark.slow
def test_the_radius_of_a_drum_is_that_of_its_hollow_whatever_stands_in_its_wall():
    drum = {"kind": "rotation", "axis": [0, 1, 0]}
    lifter = {"kind": "box", "x_mm": 12, "y_mm": 100, "z_mm": 6, "centre_mm": [49, 0, 0]}
    made = mill({**TANK, "axis": "y"}, drum, [{"name": "lifter", "geometry": lifter}])
    check(made)
    assert travel_m(build_bodies(made)) == pytest.approx(0.05, rel=1e-3)


@pytest.mark.slow
def test_the_volume_of_a_part_in_a_round_wall_is_measured():
    """Against random points, half a million in the box of the rod."""
    rod = {"name": "rod", "geometry": {**ROD, "radius_mm": 8, "axis": "x", "height_mm": 60, "centre_mm": [35, 0, 50]}}
    vessel, solid = (body.vessel for body in build_bodies(mill(inserts=[rod])))
    points = np.random.default_rng(0).uniform(*solid.bounds, (500_000, 3))
    is_in = (signed_distance(vessel)(points)[0] < 0) & (signed_distance(solid)(points)[0] > 0)
    expected = is_in.mean() * np.prod(np.ptp(solid.bounds, axis=0))
    assert 0.2 < expected / -solid.volume_m3 < 0.9
    assert volume_within(vessel, solid) == pytest.approx(expected, rel=4e-3)


def test_what_stands_in_the_wall_must_move_with_it_and_be_in_the_hollow():
    circle = {"kind": "circle", "amplitude_mm": 10}
    line = refused(mill(CRATE, circle, [baffle(motion=TURNING)]))
    assert "baffle meets vessel at (" in line and "has no `motion`, and may stand in its wall" in line
    check(mill(CRATE, TURNING, [baffle(motion=TURNING)]))
    outside = {"name": "baffle", "geometry": {**CRATE, "centre_mm": [200, 0, 25]}}
    assert "baffle lies outside the hollow of the vessel" in refused(mill(CRATE, circle, [outside]))
    larger = {"name": "baffle", "geometry": {**CRATE, "x_mm": 90, "y_mm": 90, "z_mm": 90, "centre_mm": [0, 0, 25]}}
    assert "mL of the vessel to the balls" in refused(mill(CRATE, circle, [larger]))


def test_a_divider_whose_edges_are_all_in_the_wall_is_in_the_hollow():
    plate = {"kind": "box", "x_mm": 2, "y_mm": 70, "z_mm": 60, "centre_mm": [5, 0, 25]}
    made = mill(CRATE, inserts=[{"name": "divider", "geometry": plate}])
    check(made)
    assert ball_space_m3(build_bodies(made)) == pytest.approx((80 - 2) * 60 * 50e-9, rel=1e-6)


def test_two_inserts_must_not_meet_even_where_only_edges_cross():
    """Two bars through each other: no corner of one lies in the other."""
    bars = [
        {"name": "a", "geometry": {"kind": "box", "x_mm": 40, "y_mm": 4, "z_mm": 4, "centre_mm": [0, 0, 50]}},
        {"name": "b", "geometry": {"kind": "box", "x_mm": 3, "y_mm": 40, "z_mm": 3, "centre_mm": [0, 0, 50]}},
    ]
    assert "a meets b" in refused(mill(inserts=bars)) or "b meets a" in refused(mill(inserts=bars))


def test_preflight_names_every_mill_that_does_not_hold():
    first, second = attritor(bottom_mm=-5), attritor(blade_length_mm=60)
    with pytest.raises(ConfigError) as caught:
        checked_bodies({"first": first, "second": second})
    assert len(str(caught.value).splitlines()) == 2
    assert list(checked_bodies({"good": attritor()})) == ["good"]


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_balls_start_around_an_insert_at_its_first_pose(angle):
    made = mill(
        inserts=[
            {
                "name": "stirrer",
                "geometry": STIRRER,
                "motion": {
                    "kind": "swing", "axis": [0, 0, 1], "pivot_mm": [0, 0, 0], "amplitude_deg": math.degrees(0.4),
                    "phase_deg": math.degrees(math.asin(angle / 0.4)),
                },
            }
        ]
    )  # fmt: skip
    bodies = build_bodies(made)
    vessel, solids = bodies[0].vessel, inserts_in_vessel(bodies)
    start = pack(vessel, 6e-3, 600, 0, 700e-6, solids)
    assert pdist(start).min() >= 6e-3
    assert distance_to_walls(bodies, start, 0.0)[0].max() <= -3e-3
    # Without the insert some would have started in it.
    plain = pack(vessel, 6e-3, 600, 0, 700e-6)
    assert distance_to_walls(bodies, plain, 0.0)[0].max() > 0
    assert capacity(vessel, 6e-3, inserts=solids) < capacity(vessel, 6e-3)


def test_the_insert_lowers_the_largest_fill_in_the_refusal():
    thick = [{"name": "core", "geometry": {**ROD, "radius_mm": 40, "height_mm": 90}}]
    bodies = build_bodies(mill(inserts=thick))
    with pytest.raises(SimulationError, match=r"a fill ratio of 0\.1"):
        pack(bodies[0].vessel, 8e-3, 1000, 0, 700e-6, inserts_in_vessel(bodies))


@pytest.mark.parametrize(
    "shape",
    [
        {"kind": "cylinder", "radius_mm": 15, "height_mm": 400},
        {"kind": "cylinder", "radius_mm": 15, "height_mm": 400, "axis": "x"},
        {"kind": "cylinder", "radius_mm": 90, "height_mm": 12, "axis": "y"},
        {"kind": "cylinder", "radius_mm": 90, "height_mm": 12},
    ],
)
def test_tall_lying_and_flat_vessels_are_filled_alike(shape):
    vessel = build_vessel(mill(shape))
    balls = capacity(vessel, 5e-3)
    share = balls * math.pi / 6 * 5e-3**3 / vessel.volume_m3
    assert 0.4 < share < 0.74
    start = pack(vessel, 5e-3, balls // 2, 3, vessel.volume_m3)
    assert inside(vessel, start, 2.5e-3).all()
    # Every region of the vessel holds its share of the balls.
    longest = int(np.argmax(np.ptp(vessel.bounds, axis=0)))
    counts = np.histogram(start[:, longest], 3, tuple(vessel.bounds[:, longest]))[0]
    assert counts.min() > 0.15 * counts.sum()
