"""The scene that a simulation's file describes."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from millprint.thesis.surrogate.scene import read_scene
from tests.unit.surrogate_samples import simulate, write_run

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("scene") / "run.h5"
    mill, contact = (
        yaml.safe_load((ROOT / "config" / name).read_text()) for name in ("mills/emax.yaml", "contacts/calibrated.yaml")
    )
    write_run(simulate(3), path, {"mill": mill, "contact": contact, "case": {"ball_diameter_m": 0.01, "speed_hz": 5.0}})
    return read_scene(path)


def test_balls_and_motion(scene):
    assert scene.ball_radius_m == 0.005 and scene.speed_rpm == 300
    assert scene.ball_mass_kg == pytest.approx(7700 * np.pi / 6 * 0.01**3)
    quarter = scene.wall_position(np.array([0.0, 0.05, 0.1]))
    np.testing.assert_allclose(quarter, 0.017 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0]]), atol=1e-9)


def test_distance_moves_with_the_wall(scene):
    """5 mm over the floor, and 10 mm under the lid of the 35 mm high jar, wherever the jar is."""
    wall = np.array([[0.017, 0.0, 0.0], [-0.3, 0.2, 0.1]])
    heights = np.array([[0, 0, 0.005], [0, 0, 0.025]])
    distance, gradient = scene.signed_distance(wall + heights, wall)
    np.testing.assert_allclose(distance, [-0.005, -0.010], rtol=1e-9)
    np.testing.assert_allclose(gradient, [[0, 0, -1], [0, 0, 1]], atol=1e-9)


def test_what_is_not_finite_has_no_distance(scene):
    position = np.array([[np.nan, 0, 0], [0, 0, 0.01], [np.inf, 0, 0]])
    distance, gradient = scene.signed_distance(position, np.zeros(3))
    assert np.isnan(distance[[0, 2]]).all() and distance[1] == pytest.approx(-0.01)
    assert np.isfinite(gradient[1]).all()


def test_section_is_blank_outside(scene):
    part = scene.section("z", 0.0175, points=41)
    assert part["axes"] == ("x", "y") and part["distance_m"].shape == (41, 41)
    assert np.isnan(part["distance_m"][0, 0])  # a corner of the box about the stadium
    assert part["distance_m"][20, 20] == pytest.approx(-0.0175, abs=1e-6)
