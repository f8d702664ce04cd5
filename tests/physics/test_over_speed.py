"""Restitution and friction over the speed of the hit: impacts against the table, forms against their laws."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from millprint.config.contact_set import RestitutionForm, RestitutionTable, plastic, viscoelastic
from millprint.dem.ledger import closure
from tests.physics.setups import CALIBRATED, FewBalls

TABLE = RestitutionTable(speeds_m_s=(0.05, 0.5, 2.0), values=(0.15, 0.4, 0.8))
WALL = RestitutionTable(speeds_m_s=(0.1, 1.0), values=(0.9, 0.5))
OVER_SPEED = CALIBRATED.model_copy(update={"restitution": TABLE, "wall_restitution": WALL})
RADIUS, STEP = 5e-3, 1e-6


def pair_at(speed: float, contact=OVER_SPEED) -> FewBalls:
    """Two balls after a head-on hit."""
    world = FewBalls(
        [[-RADIUS, 0, 0.1], [RADIUS, 0, 0.1]], [[speed / 2, 0, 0], [-speed / 2, 0, 0]], contact=contact, step=STEP
    )
    world.run(2e-3)
    return world


@pytest.mark.parametrize("speed", [0.02, 0.05, 0.2, 0.5, 1.5, 4.0])
@pytest.mark.slow
def test_two_balls_rebound_by_the_table(speed):
    constant = CALIBRATED.model_copy(update={"restitution": TABLE.at(speed)})
    velocity = pair_at(speed).balls.velocity
    assert -np.diff(velocity[:, 0])[0] / -speed == pytest.approx(TABLE.at(speed), abs=2e-3)
    assert abs(velocity.sum(axis=0)).max() < 1e-14
    np.testing.assert_allclose(velocity, pair_at(speed, constant).balls.velocity, rtol=1e-9)


@pytest.mark.parametrize("speed", [0.05, 0.3, 2.0])
def test_a_wall_has_its_own_table_and_friction_follows_the_speed(speed):
    friction = {"speeds_m_s": (0.1, 1.0), "values": (0.1, 0.3)}
    contact = type(OVER_SPEED)(**{**OVER_SPEED.model_dump(), "static_friction": friction, "rolling_friction": 0.0})
    world = FewBalls([[0, 0, RADIUS]], [[6.0, 0, -speed]], contact=contact, step=STEP)
    world.run(2e-3)
    (along, _, up) = world.balls.velocity[0]
    restitution, mu = WALL.at(speed), contact.value_of("static_friction", speed)
    assert up / speed == pytest.approx(restitution, abs=2e-3)
    # It slides throughout: the impulse along the wall is mu (1 + e) m v.
    assert (6.0 - along) / speed == pytest.approx(mu * (1 + restitution), rel=5e-3)


def test_the_balance_of_many_hits_closes():
    rng = np.random.default_rng(1)
    places = np.stack(np.meshgrid(*[np.linspace(-0.02, 0.02, 3)] * 2, [0.02, 0.04]), axis=-1).reshape(-1, 3)
    world = FewBalls(places, rng.normal(0, 0.7, places.shape), contact=OVER_SPEED, step=2e-6, gravity=9.81)
    series = world.run(0.15, sample_every=500)
    assert closure(series) < 4e-3
    assert len(world.contacts) > 30


def test_a_contact_set_without_a_table_has_no_table():
    assert FewBalls([[0, 0, 0.1]]).laws.by_speed is None


@pytest.mark.parametrize("place", [1e-6, 1e-4, 1e-2, 0.1])
def test_the_viscoelastic_form_is_that_of_the_equation_of_motion(place):
    """x'' + x^1.5 + 1.5 a x^0.5 x' = 0, from Kuwabara and Kono; it ends where the force does (Schwager, Poeschel 2008).

    With a stiffness, a mass and a speed of 1, the form's place is (3/2 a)^5.
    """
    damping = place**0.2 / 1.5

    def force(_, state):
        x, v = state
        return [v, -(max(x, 0.0) ** 1.5) - 1.5 * damping * max(x, 0.0) ** 0.5 * v]

    def parted(_, state):
        return state[0] + 1.5 * damping * state[1]

    parted.terminal, parted.direction = True, -1
    found = solve_ivp(force, (0, 20), [1e-12, 1.0], events=parted, rtol=1e-9, atol=1e-12)
    assert -found.y[1, -1] == pytest.approx(viscoelastic(place), rel=1e-2)


def test_forms_pass_through_the_known_value_and_have_their_limits():
    for form in ("viscoelastic", "plastic"):
        table = RestitutionForm(form=form, value=0.7, at_speed_m_s=0.3).table
        assert table.at(0.3) == pytest.approx(0.7, abs=1e-3)
        assert (np.diff(table.values) <= 0).all() and table.values[0] <= 1
    assert [plastic(0.5), plastic(1.0)] == pytest.approx([1, 1])
    assert plastic(1e6) == pytest.approx(1.185 * 1e6**-0.25, rel=1e-3)
    slow = np.array([viscoelastic(1e-15), viscoelastic(32e-15)])
    assert (1 - slow[1]) / (1 - slow[0]) == pytest.approx(2, rel=0.01)
