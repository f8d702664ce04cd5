"""Free flight, rest on the floor, and frames of reference."""

import numpy as np
import pytest

from millprint.mill.motion import HARMONIC, Motion
from tests.physics.setups import World

RADIUS = 5e-3
G = 9.81


def test_free_fall():
    step = 1e-6
    world = World([0, 0, 0.15], [0.3, 0, 0], step=step, gravity=G)
    world.run(0.1)
    # Velocities live half a step before positions, hence t + step.
    assert world.balls.position[0, 2] == pytest.approx(0.15 - 0.5 * G * 0.1 * (0.1 + step), abs=1e-12)
    assert world.balls.position[0, 0] == pytest.approx(0.03, abs=1e-12)


def test_a_ball_on_the_floor_is_carried_by_its_weight():
    world = World([0, 0, RADIUS + 1e-4], step=2e-6, gravity=G)
    world.run(0.3)
    overlap = RADIUS - world.balls.position[0, 2]
    assert world.laws.wall[0, 0] * overlap**1.5 == pytest.approx(world.balls.mass[0] * G, rel=1e-6)
    assert np.abs(world.balls.velocity).max() < 1e-9


def test_a_stack_carries_itself():
    world = World([[0, 0, RADIUS], [0, 0, 3 * RADIUS], [0, 0, 5 * RADIUS]], step=2e-6, gravity=G)
    world.run(0.3)
    lowest = RADIUS - world.balls.position[0, 2]
    assert world.laws.wall[0, 0] * lowest**1.5 == pytest.approx(3 * world.balls.mass[0] * G, rel=1e-5)
    highest = 2 * RADIUS - (world.balls.position[2, 2] - world.balls.position[1, 2])
    assert world.laws.pair[0, 0, 0] * highest**1.5 == pytest.approx(world.balls.mass[0] * G, rel=1e-5)


def uniform(velocity: np.ndarray) -> Motion:
    """Motion at constant velocity, as the first moments of a very slow and wide swing."""
    slow = 1e-6
    return Motion(HARMONIC, np.array([[slow, 0, 0, 0, *(velocity / slow)]]), slow)


def test_a_vessel_in_uniform_motion_is_a_vessel_at_rest():
    position = [[0, 0, 0.02], [8e-3, 3e-3, 0.025], [-0.01, 0.002, 0.02]]
    velocity = np.array([[0.3, 0.1, -1.0], [-0.2, 0.4, -1.5], [1.0, 0, -0.5]])
    speed = np.array([1.5, -0.7, 0.2])
    still = World(position, velocity, step=1e-6, gravity=G)
    moving = World(position, velocity + speed, step=1e-6, gravity=G, motion=uniform(speed))
    for world in (still, moving):
        world.run(0.03)
    assert moving.balls.position - 0.03 * speed == pytest.approx(still.balls.position, abs=1e-9)
    assert moving.balls.spin == pytest.approx(still.balls.spin, abs=1e-4)
