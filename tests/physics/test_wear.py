"""Load times sliding distance from the friction work, against closed forms of a ball that slides under a known load."""

import numpy as np
import pytest
from scipy.constants import g

from millprint.dose.wear import BALL_BALL, BALL_WALL, archard_mass, load_distance, sliding_of_contacts, worn_load
from tests.physics.setups import CALIBRATED, FewBalls, box

SLIPPERY = CALIBRATED.model_copy(update={"rolling_friction": 0.0})
MU, RADIUS = SLIPPERY.static_friction, 5e-3
MASS = SLIPPERY.density_kg_m3 * 4 / 3 * np.pi * RADIUS**3


def work_of(world: FewBalls) -> dict[str, float]:
    """Sliding work [J] by kind of the contacts that ended."""
    contacts = world.contacts
    return sliding_of_contacts(contacts["second"].to_numpy(), contacts["sliding_J"].to_numpy())


def test_a_ball_sliding_on_a_floor_wears_by_its_weight_times_its_way():
    """Thrown flat at v0, it slips until it rolls: the slip 7/2 mu g t uses up v0, over the way v0^2 / (7 mu g)."""
    speed = 0.5
    # The overlap at which the floor bears the weight, so that the ball does not bounce.
    reduced = SLIPPERY.young_modulus_gpa * 1e9 / (2 * (1 - SLIPPERY.poisson_ratio**2))
    sunk = (3 * MASS * g / (4 * reduced * np.sqrt(RADIUS))) ** (2 / 3)
    world = FewBalls([[-0.05, 0, RADIUS - sunk]], [[speed, 0, 0]], contact=SLIPPERY, gravity=[0, 0, -g])
    stop = 2 * speed / (7 * MU * g)
    ledger = world.run(1.3 * stop, sample_every=100)
    way = speed**2 / (7 * MU * g)
    found = load_distance(ledger["sliding_J"].iloc[-1], MU)
    assert found == pytest.approx(MASS * g * way, rel=0.01)
    lost = archard_mass(found, 1e-5, 5.4e9, 7700)
    assert lost == pytest.approx(7700 * 1e-5 * MASS * g * way / 5.4e9, rel=0.01)


def oblique(normal: float, tangential: float) -> float:
    """F s of an impact that slides from first to last touch: J (u - 7/4 mu J / m*), here for m* = 1."""
    impulse = (1 + SLIPPERY.restitution) * normal
    assert 3.5 * MU * impulse < tangential
    return impulse * (tangential - 1.75 * MU * impulse)


def test_an_impact_on_a_wall_counts_for_the_wall_alone():
    normal, tangential = 0.3, 1.2
    world = FewBalls([[-0.05, 0, 1.01 * RADIUS]], [[tangential, 0, -normal]], contact=SLIPPERY, gravity=[0, 0, 0])
    world.run(0.01)
    works = work_of(world)
    assert works[BALL_BALL] == 0
    assert load_distance(works[BALL_WALL], MU) == pytest.approx(MASS * oblique(normal, tangential), rel=0.01)


def test_an_impact_of_two_balls_counts_for_both_of_them():
    # Slow, since the line of centres turns while fast balls touch.
    normal, tangential = 0.03, 0.12
    # All but touching: on the way to each other they would also pass each other.
    centres = np.array([[-1.00001 * RADIUS, 0, 0.1], [1.00001 * RADIUS, 0, 0.1]])
    velocity = 0.5 * np.array([[normal, tangential, 0], [-normal, -tangential, 0]])
    world = FewBalls(centres, velocity, contact=SLIPPERY, gravity=[0, 0, 0], vessel=box(0.4, 0.4, 0.4))
    world.run(0.01)
    works = work_of(world)
    load = {kind: load_distance(work, MU) for kind, work in works.items()}
    assert load[BALL_WALL] == 0
    assert load[BALL_BALL] == pytest.approx(MASS / 2 * oblique(normal, tangential), rel=0.015)
    assert worn_load(load) == 2 * load[BALL_BALL]
