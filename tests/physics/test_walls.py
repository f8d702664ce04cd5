"""Contacts of a ball with faces, seams, convex edges and corners of the wall."""

import numpy as np
import pytest

from millprint.mill.features import features_of
from millprint.mill.motion import motion_from_law
from millprint.mill.wall_arrays import build_walls
from millprint.mill.walls import touch
from millprint.run.kernel import kernel
from tests.physics.setups import CALIBRATED, FewBalls, box, prism
from tests.poses import velocity

RADIUS = 5e-3
# A box with a square notch: the wall juts in along the vertical line x = y = 0.
NOTCHED = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.0], [0.0, 0.0], [0.0, 0.1], [-0.1, 0.1]])


@kernel()
def touch_feature(walls, feature, point, limit):
    """A function that only kernels may call, for Python."""
    return touch(walls, feature, 0, point, limit)


def touched(vessel, point) -> list[tuple[int, float, np.ndarray]]:
    """Features that a ball at `point` touches: (number, distance, direction)."""
    walls = build_walls([vessel], RADIUS, 3e-4, 0.02)
    features = len(vessel.facets) + len(features_of(vessel).lines) + len(features_of(vessel).corners)
    found = [(k, *touch_feature(walls, k, tuple(map(float, point)), RADIUS)) for k in range(features)]
    return [(k, distance, np.array(normal)) for k, distance, normal in found if distance >= 0]


@pytest.mark.slow
def test_a_face_is_felt_once():
    (found,) = touched(box(), [0.01, 0.02, 0.9 * RADIUS])
    assert found[1] == pytest.approx(0.9 * RADIUS)
    assert found[2] == pytest.approx([0, 0, 1])


def test_a_seam_is_felt_as_its_two_faces():
    found = touched(box(), [0.1 - 0.95 * RADIUS, 0.02, 0.9 * RADIUS])
    assert sorted(distance for _, distance, _ in found) == pytest.approx([0.9 * RADIUS, 0.95 * RADIUS])


def test_a_convex_edge_is_felt_once_all_the_way_round():
    vessel = prism(NOTCHED, 0.1)
    assert len(features_of(vessel).lines) == 1
    for angle in np.linspace(np.pi / 2, 2 * np.pi, 181):
        point = 0.9 * RADIUS * np.array([np.cos(angle), np.sin(angle), 0]) + [0, 0, 0.05]
        # Above the edge the ball is beside the face x = 0, right of it under the face y = 0.
        if angle < np.pi:
            point[0] = -0.9 * RADIUS
        elif angle > 3 * np.pi / 2:
            point[1] = -0.9 * RADIUS
        found = touched(vessel, point)
        # Where facet and edge meet, both may feel it: they are one wall there (walls.belongs).
        assert 1 <= len(found) <= 2, (angle, found)
        assert [each[1] for each in found] == pytest.approx([0.9 * RADIUS] * len(found), rel=1e-9)


def test_distance_is_continuous_from_face_to_edge():
    vessel = prism(NOTCHED, 0.1)
    distances = [touched(vessel, [x, -0.9 * RADIUS, 0.05]) for x in np.linspace(-1e-4, 1e-4, 41)]
    assert all(len(found) == 1 for found in distances)
    assert np.abs(np.diff([found[0][1] for found in distances])).max() < 1.5e-7


def test_each_face_of_a_shallow_seam_is_felt_where_the_foot_is_on_it():
    """A seam of 7.5 degrees: on both sides the nearer face is felt, and nothing that is not there."""
    turn = np.radians(7.5)
    outline = np.array([[-0.05, 0], [0, 0], [0.05 * np.cos(turn), 0.05 * np.sin(turn)], [0.05, 0.1], [-0.05, 0.1]])
    vessel = prism(outline, 0.1)
    depth = 0.97 * RADIUS
    along, inner = np.array([np.cos(turn), np.sin(turn)]), np.array([-np.sin(turn), np.cos(turn)])
    for s in np.linspace(-6e-3, 6e-3, 241):
        # The curve at constant distance from the nearer of the two faces.
        point = np.array([s, depth]) if s < 0 else s * along + depth * inner
        found = sorted(f[1] for f in touched(vessel, [*point, 0.05]))
        feet = [d for d, foot in ((point[1], -point[0]), (point @ inner, point @ along)) if foot >= 0 and d < RADIUS]
        assert found == pytest.approx(sorted(feet), rel=1e-9)


def test_a_ball_bounces_off_a_convex_edge_as_off_a_sphere_of_no_radius():
    vessel = prism(NOTCHED, 0.1)
    contact = CALIBRATED.model_copy(update={"restitution": 1.0, "static_friction": 0.0, "rolling_friction": 0.0})
    direction = np.array([-np.cos(np.pi / 4), -np.sin(np.pi / 4), 0])
    world = FewBalls([*(direction[:2] * (RADIUS + 1e-5)), 0.05], -direction, vessel=vessel, contact=contact, step=5e-7)
    world.run(1e-3)
    assert len(world.collisions[0]) == 1
    assert world.balls.velocity[0] == pytest.approx(direction, abs=1e-3)


@pytest.mark.parametrize("name", ["emax", "emax_motion1", "emax_motion2", "emax_post"])
def test_wall_velocity_is_the_rate_of_change_of_position(name, mills):
    motion = motion_from_law(mills[name].motion, 300)
    time_s, h = np.linspace(0.001, 0.4, 97), 1e-6
    rate = (motion.position(time_s + h) - motion.position(time_s - h)) / (2 * h)
    assert velocity(motion, time_s) == pytest.approx(rate, abs=1e-7)
