"""Normal impacts against Hertz's closed forms and the law's restitution."""

import numpy as np
import pytest

from millprint.dem.law import KN
from tests.physics.setups import CALIBRATED, World

RADIUS = 5e-3


def smooth(restitution: float):
    return CALIBRATED.model_copy(update={"restitution": restitution, "static_friction": 0.0, "rolling_friction": 0.0})


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.68, 0.9])
def test_wall_restitution_does_not_depend_on_speed(restitution):
    for speed in (0.05, 0.5, 3.0):
        step = 2e-7
        world = World([0, 0, RADIUS + 1e-6], [0, 0, -speed], contact=smooth(restitution), step=step)
        world.run(3e-3)
        assert len(world.collisions[0]) == 1
        assert world.balls.velocity[0, 2] / speed == pytest.approx(restitution, abs=1e-3)


@pytest.mark.parametrize("radii", [(5e-3, 5e-3), (5e-3, 2.5e-3)])
def test_pair_restitution_and_momentum(radii):
    gap = sum(radii) + 1e-6
    world = World(
        [[0, 0, 0.1], [gap, 0, 0.1]], [[1.0, 0, 0], [-0.5, 0, 0]], radius=np.array(radii),
        contact=smooth(0.3), step=2e-7,
    )  # fmt: skip
    mass = world.balls.mass[world.balls.species]
    before = mass @ world.balls.velocity
    world.run(2e-3)
    after = world.balls.velocity
    assert after[1, 0] - after[0, 0] == pytest.approx(0.3 * 1.5, abs=1.5e-3)
    assert mass @ after == pytest.approx(before, abs=1e-15)


def test_restitution_at_the_default_step():
    world = World([0, 0, RADIUS + 1e-5], [0, 0, -1.0], contact=smooth(0.3), step=2e-6)
    world.run(2e-3)
    assert world.balls.velocity[0, 2] == pytest.approx(0.3, abs=2e-3)


@pytest.mark.parametrize("speed", [0.1, 1.0])
def test_elastic_impact_has_hertz_peak_force_and_duration(speed):
    world = World([0, 0, RADIUS + 1e-7], [0, 0, -speed], contact=smooth(1.0), step=1e-7)
    mass, stiffness = world.balls.mass[0], world.laws.wall[0, KN]
    world.run(2e-3)
    overlap = (5 * mass * speed**2 / (4 * stiffness)) ** 0.4
    _, _, _, value = world.collisions
    assert value[0, 2] == pytest.approx(speed, rel=1e-6)
    assert value[0, 3] == pytest.approx(stiffness * overlap**1.5, rel=1e-4)
    assert value[0, 4] == pytest.approx(overlap, rel=1e-4)
    # t = 2 Int dx / sqrt(1 - x^(5/2)) delta / v = 2.9432 delta / v
    assert value[0, 1] == pytest.approx(2.9432 * overlap / speed, rel=2e-3)
    assert world.balls.velocity[0, 2] == pytest.approx(speed, rel=1e-4)


def test_hertz_stiffness_of_a_wall_is_that_of_the_ball_radius():
    world = World([0, 0, 0.1])
    effective = 2.05e9 / (2 * (1 - 0.235**2))
    assert world.laws.wall[0, KN] == pytest.approx(4 / 3 * effective * np.sqrt(RADIUS))
    assert world.laws.pair[0, 0, KN] == pytest.approx(4 / 3 * effective * np.sqrt(RADIUS / 2))
