"""Symmetries of the equations: the whole set-up moved, turned, mirrored or run again."""

import numpy as np
import pytest

from millprint.dem.layout import COUNTER
from tests.physics.contact_run import TURNED, UPRIGHT
from tests.physics.setups import FewBalls, box, uniform
from tests.physics.test_over_speed import OVER_SPEED

G = 9.81
STILL = np.zeros(3)
MIRROR = np.diag([1.0, -1.0, 1.0])
# Balls of three sizes that fall on the floor and hit each other within 30 ms.
RADIUS = np.array([5e-3, 3e-3, 5e-3, 4e-3])
POSITION = np.array([[0, 0, 0.012], [9e-3, 2e-3, 0.016], [-0.02, 2e-3, 0.012], [1e-3, -0.012, 0.013]])
VELOCITY = np.array([[-0.2, 0.1, -0.6], [-0.9, 0.1, -0.8], [0.8, 0.1, -0.5], [0.1, 0.9, -0.7]])
SPIN = np.array([[10.0, -40, 70], [0, 60, -20], [-50, 0, 30], [20, 20, 90]])


def world(frame=UPRIGHT, reflection=UPRIGHT, drift=STILL, order=slice(None), **options) -> FewBalls:
    """The set-up, mirrored, then turned, in a vessel that drifts at a velocity [m/s], the balls in some order."""
    move = frame @ reflection
    spin = np.linalg.det(reflection) * SPIN @ move.T
    return FewBalls(
        (POSITION @ move.T)[order], (VELOCITY @ move.T + drift)[order], spin[order], RADIUS[order], OVER_SPEED,
        vessel=box(0.07, 0.07, 0.1, frame), gravity=-G * frame[:, 2], motion=uniform(drift), step=1e-6, **options,
    )  # fmt: skip


@pytest.fixture(scope="module")
def still() -> FewBalls:
    made = world()
    made.run(0.03)
    # Otherwise the symmetries would be those of free flight.
    partners = made.contacts["second"]
    assert (partners >= 0).sum() >= 4
    assert (partners < 0).sum() >= 3
    return made


def assert_same(one: FewBalls, other: FewBalls, move: np.ndarray, drift=STILL, sense=1.0, tolerance=1e-11) -> None:
    """Positions [m], velocities and rim speeds [m/s] of `one` are those of `other`, moved and drifted."""
    assert one.balls.position - 0.03 * drift == pytest.approx(other.balls.position @ move.T, abs=tolerance)
    assert one.balls.velocity - drift == pytest.approx(other.balls.velocity @ move.T, abs=1e3 * tolerance)
    assert one.balls.angular_velocity == pytest.approx(
        sense * other.balls.angular_velocity @ move.T, abs=1e5 * tolerance
    )


def test_a_vessel_in_uniform_motion_is_a_vessel_at_rest(still):
    speed = np.array([1.5, -0.7, 0.2])
    moving = world(drift=speed)
    moving.run(0.03)
    assert_same(moving, still, UPRIGHT, drift=speed)


def test_the_ledger_of_a_vessel_in_uniform_motion_closes_with_the_work_of_its_walls():
    """In a frame where the walls move they do work, normal and tangential, and dissipation is what it is at rest."""
    works = ["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]
    rest, moving = (world(drift=drift).run(0.03, sample_every=100) for drift in (STILL, np.array([1.5, -0.7, 0.2])))
    energy = rest["kinetic_J"].iloc[0]
    assert np.abs(rest["wall_work_J"]).max() == 0
    assert np.abs(moving["wall_work_J"]).max() > 0.1 * energy
    assert (moving[works] - rest[works]).abs().to_numpy().max() < 1e-9 * energy
    for series in (rest, moving):
        assert np.abs(series["imbalance_J"]).max() < 2e-4 * energy


def test_a_set_up_turned_as_a_whole_turns_the_result(still):
    turned = world(frame=TURNED)
    turned.run(0.03)
    assert_same(turned, still, TURNED)


def test_a_mirrored_set_up_is_mirrored_in_the_result(still):
    """Spins are axial: mirrored, they change their sense as well."""
    mirrored = world(reflection=MIRROR)
    mirrored.run(0.03)
    assert_same(mirrored, still, MIRROR, sense=-1.0)


def test_the_order_of_the_balls_does_not_matter(still):
    order = np.array([2, 0, 3, 1])
    shuffled = world(order=order)
    shuffled.run(0.03)
    assert shuffled.balls.position == pytest.approx(still.balls.position[order], abs=1e-11)
    assert shuffled.balls.angular_velocity == pytest.approx(still.balls.angular_velocity[order], abs=1e-6)


def test_the_same_start_gives_the_same_end_to_the_last_bit(still):
    again = world()
    again.run(0.03)
    for name in ("position", "velocity", "angular_velocity"):
        assert np.array_equal(getattr(again.balls, name), getattr(still.balls, name))
    assert all(np.array_equal(one, other) for one, other in zip(again.collisions, still.collisions, strict=True))


@pytest.mark.parametrize(("skin", "is_new"), [(6e-4, False), (6e-4, True), (1e-4, False), (0.02, False)])
def test_neither_parts_of_a_run_nor_its_lists_change_it(still, skin, is_new):
    """Lists made anew between the parts or not; six times as often, or hardly ever."""
    parts = world(skin=skin)
    for _ in range(30):
        parts.counters[COUNTER.check_in] *= not is_new
        parts.run(0.001)
    tolerance = 1e-11 if is_new or skin != 6e-4 else 0
    assert_same(parts, still, UPRIGHT, tolerance=tolerance)
    assert parts.counters[COUNTER.opened] == still.counters[COUNTER.opened]
