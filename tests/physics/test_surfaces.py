"""Walls with coefficients of their own, and ends without any friction, against closed forms."""

import math

import numpy as np
import pytest

from millprint.mill.vessel import Vessel
from tests.physics.setups import CALIBRATED, FewBalls, box

GRAVITY = 9.81
APART = {"wall_restitution": 0.8, "wall_static_friction": 0.1, "wall_rolling_friction": 0.0}


def smooth_floor() -> Vessel:
    """A box whose floor and lid have no friction."""
    made = box()
    return Vessel(list(made.facets), smooth_axis="z")


def test_a_ball_at_a_wall_has_the_walls_restitution_and_two_balls_their_own():
    contact = CALIBRATED.model_copy(update=APART)
    fall = FewBalls([0.0, 0.0, 0.0051], [0.0, 0.0, -1.0], contact=contact)
    fall.run(2e-3)
    assert fall.balls.velocity[0, 2] == pytest.approx(0.8, rel=1e-3)
    pair = FewBalls([[-0.0051, 0.0, 0.1], [0.0051, 0.0, 0.1]], [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]], contact=contact)
    pair.run(2e-3)
    assert pair.balls.velocity[1, 0] == pytest.approx(0.5 * CALIBRATED.restitution, rel=3e-3)


@pytest.mark.parametrize("friction", [0.05, 0.1, 0.2])
def test_a_sliding_ball_is_slowed_by_the_friction_of_the_wall(friction):
    """While it slides, dv/dt = -mu g."""
    contact = CALIBRATED.model_copy(update={**APART, "wall_static_friction": friction})
    world = FewBalls([-0.05, 0.0, 0.004999], [1.0, 0.0, 0.0], contact=contact, gravity=GRAVITY)
    world.run(0.02)
    begin, at = world.balls.velocity[0, 0], 0.05
    world.run(at)
    # It rolls after 2 v / (7 mu g), later than this.
    assert begin - world.balls.velocity[0, 0] == pytest.approx(friction * GRAVITY * at, rel=0.02)


def test_a_ball_slides_on_a_smooth_end_without_loss_and_without_turning():
    world = FewBalls([-0.05, 0.0, 0.004999], [1.0, 0.0, 0.0], vessel=smooth_floor(), gravity=GRAVITY)
    world.run(0.05)
    assert world.balls.velocity[0, 0] == 1.0
    assert not world.balls.angular_velocity.any()


def test_the_other_walls_of_a_slice_keep_their_friction():
    """Sliding up a rough wall gives a spin, R w = 5/2 mu (1 + e) v_n in full sliding, but for the overlap."""
    contact = CALIBRATED.model_copy(update={"restitution": 0.9, "static_friction": 0.05, "rolling_friction": 0.0})
    start, velocity = [0.0949, 0.0, 0.1], [0.5, 0.0, 2.0]
    world = FewBalls(start, velocity, vessel=smooth_floor(), contact=contact, step=2e-7)
    world.run(1e-3)
    turned = math.sqrt(np.sum(world.balls.angular_velocity**2)) * 5e-3
    assert turned == pytest.approx(2.5 * 0.05 * 1.9 * 0.5, rel=1e-2)
