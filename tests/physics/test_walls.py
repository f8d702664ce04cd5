"""A hit on a convex edge, and the velocity of a moving wall. `test_closed_surfaces.py` has where a ball touches."""

import numpy as np
import pytest

from millprint.mill.motion import motion_from_law
from tests.physics.setups import CALIBRATED, FewBalls, prism
from tests.poses import velocity

RADIUS = 5e-3
# A box with a square notch: the wall juts in along the vertical line x = y = 0.
NOTCHED = np.array([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.0], [0.0, 0.0], [0.0, 0.1], [-0.1, 0.1]])


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
    motion = motion_from_law(mills[name].motion, 5.0)
    time_s, h = np.linspace(0.001, 0.4, 97), 1e-6
    rate = (motion.position(time_s + h) - motion.position(time_s - h)) / (2 * h)
    assert velocity(motion, time_s) == pytest.approx(rate, abs=1e-7)
