"""Sliding, sticking and rolling against closed forms."""

import numpy as np
import pytest

from tests.physics.setups import CALIBRATED, World

RADIUS = 5e-3
G = 9.81
NO_ROLLING = CALIBRATED.model_copy(update={"rolling_friction": 0.0})


def resting_overlap(world: World) -> float:
    """Overlap [m] at which the floor carries the ball."""
    return float((world.balls.mass[0] * G / world.laws.wall[0, 0]) ** (2 / 3))


@pytest.mark.parametrize("restitution", [0.3, 0.68, 1.0])
def test_sliding_impulse(restitution):
    """A ball that slides all through an impact loses mu (1 + e) v along the wall, and spins up by 5/2 of it / R."""
    contact = NO_ROLLING.model_copy(update={"restitution": restitution})
    world = World([0, 0, RADIUS + 1e-6], [5.0, 0, -1.0], contact=contact, step=2e-7)
    world.run(2e-3)
    lost = 5.0 - world.balls.velocity[0, 0]
    assert lost == pytest.approx(0.3 * (1 + restitution) * 1.0, rel=5e-3)
    # The lever is the distance to the wall, which the overlap shortens a little.
    assert world.balls.spin[0, 1] == pytest.approx(2.5 * lost / RADIUS, rel=2e-2)


def test_slip_ceases_at_five_sevenths():
    contact = NO_ROLLING.model_copy(update={"static_friction": 0.2})
    world = World([-0.05, 0, RADIUS], [0.5, 0, 0], contact=contact, step=4e-6, gravity=G)
    world.balls.position[0, 2] -= resting_overlap(world)
    world.run(0.15)
    speed = world.balls.velocity[0, 0]
    assert speed == pytest.approx(5 / 7 * 0.5, rel=2e-3)
    assert world.balls.spin[0, 1] * RADIUS == pytest.approx(speed, rel=2e-3)


def test_rolling_friction_slows_a_rolling_ball():
    """a = mu_r g / (1 + 2/5) for a ball that rolls without slipping."""
    speed = 0.3
    world = World([-0.05, 0, RADIUS], [speed, 0, 0], [0, speed / RADIUS, 0], step=4e-6, gravity=G)
    world.balls.position[0, 2] -= resting_overlap(world)
    world.run(0.02)
    first = world.balls.velocity[0, 0]
    world.run(0.2)
    assert (first - world.balls.velocity[0, 0]) / 0.2 == pytest.approx(0.045 * G / 1.4, rel=5e-3)


def test_rolling_friction_stops_a_ball_and_never_turns_it_back():
    speed = 0.02
    world = World([-0.05, 0, RADIUS], [speed, 0, 0], [0, speed / RADIUS, 0], step=4e-6, gravity=G)
    world.balls.position[0, 2] -= resting_overlap(world)
    series = world.run(0.2, sample_every=100)
    assert abs(world.balls.velocity[0, 0]) < 1e-4 * speed + 1e-6
    assert (np.diff(series["rolling_J"]) >= -1e-18).all()
    assert series["kinetic_J"].iloc[-1] < 1e-6 * series["kinetic_J"].iloc[0]


def test_spin_alone_starts_a_ball_moving():
    """A ball set down spinning ends at 2/7 of its rim speed."""
    world = World(
        [-0.05, 0, RADIUS], [0, 0, 0], [0, 100.0, 0],
        contact=NO_ROLLING.model_copy(update={"static_friction": 0.2}), step=4e-6, gravity=G,
    )  # fmt: skip
    world.balls.position[0, 2] -= resting_overlap(world)
    world.run(0.2)
    assert world.balls.velocity[0, 0] == pytest.approx(2 / 7 * 100.0 * RADIUS, rel=5e-3)


def test_oblique_pair_impact_conserves_momentum_and_angular_momentum():
    world = World(
        [[0, 0, 0.1], [9e-3, 4.4e-3, 0.1]], [[1.0, 0.2, 0.1], [-0.5, 0.0, 0]], [[10, 50, -20], [0, 0, 100]],
        contact=NO_ROLLING, step=5e-7,
    )  # fmt: skip
    balls, mass, inertia = world.balls, world.balls.mass[0], world.balls.inertia[0]

    def angular() -> np.ndarray:
        return mass * np.cross(balls.position, balls.velocity).sum(axis=0) + inertia * balls.spin.sum(axis=0)

    momentum, before = balls.velocity.sum(axis=0), angular()
    world.run(1e-3)
    assert len(world.collisions[0]) == 1
    assert balls.velocity.sum(axis=0) == pytest.approx(momentum, abs=1e-13)
    # Positions and velocities are half a step apart, so the angular momentum holds to the order of the step.
    assert angular() == pytest.approx(before, rel=1e-4)
