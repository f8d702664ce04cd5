"""Cohesion as a constant pull: what it holds, what it stores, when a hit sticks, and a drum whose balls go round."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from millprint.config.contact_set import CohesionConfig, ContactConfig, RestitutionTable
from millprint.config.errors import SimulationError
from millprint.config.sweep import Case, DemConfig
from millprint.dem.laws.hertz import CohesiveHertz, Hertz
from millprint.dem.ledger import closure
from millprint.dem.run import simulate
from millprint.dem.simulation import Simulation
from millprint.fingerprint.descriptors import STUCK
from tests.physics.setups import CALIBRATED, FewBalls

RADIUS, HEIGHT, GRAVITY = 5e-3, 0.2, 9.81
MASS = CALIBRATED.density_kg_m3 * 4 / 3 * math.pi * RADIUS**3
WEIGHT = MASS * GRAVITY
# 4/3 E*; with the root of R*, Hertz's stiffness [N/m^2].
STIFFNESS = 4 / 3 * 2.05e9 / (2 * (1 - 0.235**2))


def sticky(restitution: float = 0.3, **cohesion: float) -> ContactConfig:
    """As a table, by which it is the same at any speed: other tests need the kernels of cohesion with tables too."""
    table = RestitutionTable(speeds_m_s=(0.1, 1.0), values=(restitution, restitution))
    return CALIBRATED.model_copy(update={"cohesion": CohesionConfig(**cohesion), "restitution": table})


@pytest.mark.parametrize(("share", "hangs"), [(1.02, True), (0.98, False)])
@pytest.mark.parametrize("key", ["ball_wall_N", "ball_wall_J_m2"])
@pytest.mark.slow
def test_a_ball_hangs_from_the_ceiling_if_the_pull_exceeds_its_weight(key, share, hangs):
    pull = share * WEIGHT / (2 * math.pi * RADIUS if key.endswith("m2") else 1)
    world = FewBalls([[0, 0, HEIGHT - RADIUS + 1e-8]], contact=sticky(**{key: pull}), step=5e-6, gravity=GRAVITY)
    world.run(0.1)
    assert (world.balls.position[0, 2] > HEIGHT - RADIUS) == hangs


def pressed(force: float, radius: float) -> float:
    """Overlap at which the springs carry a force."""
    return (force / (STIFFNESS * math.sqrt(radius))) ** (2 / 3)


@pytest.mark.parametrize(("share", "hangs"), [(1.02, True), (0.98, False)])
def test_a_ball_hangs_from_another_by_their_own_pull(share, hangs):
    """R* is half of the radius, so that the same work of adhesion holds half."""
    contact = sticky(ball_wall_N=10 * WEIGHT, ball_ball_J_m2=share * WEIGHT / (math.pi * RADIUS))
    upper = HEIGHT - RADIUS + pressed((10 - 1 - share) * WEIGHT, RADIUS)
    lower = upper - 2 * RADIUS + pressed(max(share - 1, 0) * WEIGHT, RADIUS / 2) + 1e-9
    world = FewBalls([[0, 0, upper], [0, 0, lower]], contact=contact, step=5e-6, gravity=GRAVITY)
    world.run(0.1)
    upper, lower = world.balls.position[:, 2]
    assert upper > HEIGHT - RADIUS and (upper - lower < 2 * RADIUS) == hangs


def test_a_hit_without_damping_gives_its_energy_back():
    """The pull begins and ends at some place within a step: an error of both signs, as large as a step's work."""
    speed, step, pull = 0.2, 1e-6, 1.0
    gains = []
    for phase in np.linspace(0, 1, 12, endpoint=False):
        start = [[0, 0, RADIUS + (10 + phase) * speed * step]]
        world = FewBalls(start, [[0, 0, -speed]], contact=sticky(restitution=1.0, ball_wall_N=pull), step=step)
        world.run(1.5e-3)
        assert world.balls.velocity[0, 2] > 0
        gains.append(0.5 * MASS * (world.balls.velocity[0, 2] ** 2 - speed**2))
    assert np.abs(gains).max() < pull * speed * step
    assert abs(np.mean(gains)) < 0.2 * pull * speed * step


def released(speed: float, contact: ContactConfig) -> bool:
    world = FewBalls([[0, 0, RADIUS + 1e-9]], [[0, 0, -speed]], contact=contact, step=5e-7)
    world.run(2e-3)
    return bool(world.balls.position[0, 2] > RADIUS)


def sticking_speed(pull: float, restitution: float) -> float:
    """The speed at which m x'' + c x^(1/4) x' + k x^(3/2) = F begins to end at x = 0 at rest; solved backwards."""
    logarithm, stiffness = math.log(restitution), STIFFNESS * math.sqrt(RADIUS)
    damping = -math.sqrt(5 * stiffness * MASS) * logarithm / math.hypot(logarithm, math.pi)

    def backwards(_, state):
        x, speed = max(state[0], 0.0), state[1]
        return [-speed, (stiffness * x**1.5 + damping * x**0.25 * speed - pull) / MASS]

    def met(_, state):
        return state[0]

    met.terminal, met.direction = True, -1
    found = solve_ivp(backwards, (0, 0.01), [1e-12, 0.0], events=met, rtol=1e-10, atol=1e-14, max_step=1e-6)
    return float(found.y[1, -1])


@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_hit_sticks_below_the_speed_of_the_equation_of_motion(restitution):
    limit, contact = sticking_speed(2.0, restitution), sticky(restitution, ball_wall_N=2.0)
    assert not released(0.97 * limit, contact) and released(1.03 * limit, contact)


def test_friction_counts_the_pull_as_load():
    """Without gravity, a ball that slides on the floor is slowed by mu times the pull."""
    pull = 0.2
    contact = sticky(ball_wall_N=pull).model_copy(update={"rolling_friction": 0.0})
    world = FewBalls([[0, 0, RADIUS - pressed(pull, RADIUS)]], [[1.0, 0, 0]], contact=contact, step=2e-6)
    world.run(5e-3)
    assert 1 - world.balls.velocity[0, 0] == pytest.approx(0.3 * pull / MASS * 5e-3, rel=0.01)


def test_the_balance_of_balls_that_stick_closes():
    rng = np.random.default_rng(3)
    places = np.stack(np.meshgrid(*[np.linspace(-0.02, 0.02, 3)] * 2, [0.02, 0.04]), axis=-1).reshape(-1, 3)
    contact = sticky(ball_wall_N=5 * WEIGHT, ball_ball_N=5 * WEIGHT)
    world = FewBalls(places, rng.normal(0, 0.5, places.shape), contact=contact, step=2e-6, gravity=GRAVITY)
    assert closure(world.run(0.15, sample_every=500)) < 4e-3


DRUM = Case(
    mill="drum", contact="calibrated", ball_diameter_m=0.01, fill_ratio=0.04, speed_hz=1.0, seed=0,
    settle_s=0.05, discard_s=0.5, window_s=0.5,
)  # fmt: skip


@pytest.mark.slow
def test_balls_that_stick_go_round_with_the_drum(mills):
    """As one layer, which needs a shorter step: hardly any work is done, by which the error of the balance counts."""
    found = [
        simulate(DRUM, mills["drum"], contact, DemConfig(time_step_s=2e-6))["speed_over_vessel"]
        for contact in (CALIBRATED, sticky(ball_wall_N=50 * WEIGHT, ball_ball_N=50 * WEIGHT))
    ]
    assert found[0] > 3 * STUCK and found[1] < 0.2 * STUCK


def test_more_cohesion_than_the_springs_carry_is_refused(mills):
    # An overlap of 0.15 of the radius.
    most = STIFFNESS * RADIUS**2 * 0.15**1.5 / (2 * math.pi * RADIUS)
    with pytest.raises(SimulationError, match=r"cohesion.ball_wall_J_m2 = \d+: its pull of .* at most") as caught:
        Simulation(DRUM, mills["drum"], sticky(ball_wall_J_m2=round(1.01 * most)), DemConfig(time_step_s=4e-6))
    assert f"at most {most:.3g} with these springs" in str(caught.value)
    Simulation(DRUM, mills["drum"], sticky(ball_wall_J_m2=round(0.99 * most)), DemConfig(time_step_s=4e-6))


def test_only_a_set_with_cohesion_is_compiled_with_it():
    assert type(FewBalls([[0, 0, 0.1]]).mark) is Hertz
    assert type(FewBalls([[0, 0, 0.1]], contact=sticky(ball_wall_N=1.0)).mark) is CohesiveHertz
