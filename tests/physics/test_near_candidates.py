"""The list of the candidates that are near leaves out none that would have opened."""

import numpy as np
import pytest

from millprint.dem.advance import advance
from millprint.dem.laws.registry import mark_of
from millprint.dem.layout import COUNTER, LANE, LANES
from millprint.dem.neighbours import SLACK_SHARE
from millprint.dem.recording import make_table, silent_recorder
from tests.physics.setups import CALIBRATED, FewBalls, box, crowd
from tests.physics.test_threads import lively

STEPS = 800


def near_of(candidates) -> np.ndarray:
    """The numbers of the candidates that are listed as near."""
    begins = [*candidates.first_wall[:, 0], 0]
    return np.concatenate([candidates.near[a:b] for a, b in zip(begins, candidates.near_end, strict=True)])


def state_after(simulation, steps_a_call: int) -> tuple[list[np.ndarray], list[float]]:
    """The state after STEPS steps, and the share of candidates that were near at the end of each call."""
    table, recorder, shares, mark = make_table(20_000), silent_recorder(), [], mark_of(simulation.contact)
    for last in range(steps_a_call - 1, STEPS, steps_a_call):
        advance(
            simulation.balls, simulation.candidates, simulation.contacts, simulation.laws, mark,
            simulation.walls, simulation.clock, simulation.totals, simulation.counters, table, recorder, last, None,
        )  # fmt: skip
        near = len(near_of(simulation.candidates))
        shares.append(near / simulation.candidates.first_wall[-1, -1])
    assert simulation.counters[COUNTER.step] == STEPS
    ended = int(simulation.counters[COUNTER.records])
    assert ended > 50
    values = [table.first[:ended], table.second[:ended], table.value[:ended]]
    return [simulation.balls.position, simulation.balls.velocity, simulation.totals, *values], shares


@pytest.mark.slow
@pytest.mark.parametrize(("mill", "speed_rpm"), [("emax", 1200), ("attritor", 350)])
def test_a_look_in_every_step_gives_the_same_bits(mills, contacts, mill, speed_rpm):
    """Each call begins with a look, so that calls of one step check every candidate that is near at that moment."""
    alone, _ = state_after(lively(mills, contacts, 1, mill=mill, speed_hz=speed_rpm / 60), 1)
    together, shares = state_after(lively(mills, contacts, 1, mill=mill, speed_hz=speed_rpm / 60), STEPS // 4)
    for each, other in zip(alone, together, strict=True):
        assert np.array_equal(each, other)
    assert max(shares) < 0.8


def gaps_of(simulation) -> np.ndarray:
    """From the surface of each candidate's ball to its partner's, or to the plane of its wall, which is at rest [m]."""
    candidates, place = simulation.candidates, simulation.balls.position
    listed = int(candidates.first_wall[-1, -1])
    ball, partner = candidates.ball[:listed], candidates.partner[:listed]
    plane, origin = candidates.plane[:listed], simulation.clock.motions.pose[0, :3]
    to_wall = ((place[ball] - origin) * plane[:, :3]).sum(axis=1) - plane[:, 3]
    to_ball = np.linalg.norm(place[ball] - place[np.maximum(partner, 0)], axis=1) - simulation.radius
    return np.where(partner < 0, to_wall, to_ball) - simulation.radius


@pytest.mark.slow
def test_what_is_closed_and_within_the_slack_is_near(mills, contacts):
    """Also what was open at the last look. No ball goes as far as the slack between a look and the end of a call."""
    simulation, table = lively(mills, contacts, 1), make_table(20_000)
    candidates, counters = simulation.candidates, simulation.counters
    # Before step 0 the mill stands still.
    counters[COUNTER.step], just_closed = -STEPS, 0
    for last in range(1 - STEPS, 0, 2):
        was_open, rebuilds = candidates.lane >= 0, counters[COUNTER.rebuilds]
        advance(
            simulation.balls, candidates, simulation.contacts, simulation.laws, mark_of(simulation.contact),
            simulation.walls, simulation.clock, simulation.totals, counters, table, silent_recorder(), last, None,
        )  # fmt: skip
        gaps = gaps_of(simulation)
        must = np.flatnonzero((candidates.lane[: len(gaps)] < 0) & (gaps < 0.5 * SLACK_SHARE * simulation.clock.skin))
        assert np.isin(must, near_of(candidates)).all()
        if counters[COUNTER.rebuilds] == rebuilds:
            just_closed += (was_open[must] & (candidates.partner[must] < 0)).sum()
    assert just_closed > 0


def test_a_crowd_is_listed_and_pushed_as_by_hand():
    """Balls of two sizes in a full box, more than ALL_PAIRS, after one step: each pair and wall by its distance."""
    skin, elastic = 6e-4, CALIBRATED.model_copy(update={"restitution": 1.0, "static_friction": 0.0})
    world = crowd(elastic, 1e-7, skin)
    place, speed, radius = (*map(np.copy, (world.balls.position, world.balls.velocity)), world.balls.radius)
    radius = radius[world.balls.species]
    world.run(1e-7)
    first, second = np.triu_indices(240, 1)
    away = place[first] - place[second]
    apart = np.linalg.norm(away, axis=1)
    gap, half = apart - radius[first] - radius[second], [1.5, 0.03, 0.025]
    out, at = np.array([1.0, -1.0]), place - [0.0, 0.0, 0.025]
    wall_gap = half - at[..., None, :] * out[:, None] - radius[:, None, None]
    force, reduced = np.zeros((240, 3)), radius[first] * radius[second] / (radius[first] + radius[second])
    spring = 4 / 3 * 2.05e9 / (2 * (1 - 0.235**2))
    push = (spring * np.sqrt(reduced) * np.maximum(-gap, 0) ** 1.5 / apart)[:, None] * away
    np.add.at(force, first, push)
    np.add.at(force, second, -push)
    force -= (spring * np.sqrt(radius)[:, None, None] * np.maximum(-wall_gap, 0) ** 1.5 * out[:, None]).sum(axis=1)
    mass = 7700 * 4 / 3 * np.pi * radius**3
    assert world.balls.velocity - speed == pytest.approx(force / mass[:, None] * 1e-7, rel=1e-6, abs=1e-12)
    assert world.balls.position - place == pytest.approx(1e-7 * world.balls.velocity, abs=1e-15)
    candidates, walls = world.candidates, int(world.candidates.first_wall[0, 0])
    pairs = set(zip(candidates.ball[:walls].tolist(), candidates.partner[:walls].tolist(), strict=True))
    assert pairs == set(zip(first[gap < skin].tolist(), second[gap < skin].tolist(), strict=True))
    opened = (gap < 0).sum() + (wall_gap < 0).sum()
    resistance = world.open_contacts.lanes[:, LANE.history.resistance * LANES : (LANE.history.resistance + 1) * LANES]
    assert world.counters[COUNTER.opened] == opened and (resistance.ravel()[:opened] == 1).all()
    of_walls = candidates.ball[walls : candidates.first_wall[0, -1]]
    assert np.bincount(of_walls, minlength=240).tolist() == (wall_gap <= skin / 2).sum(axis=(1, 2)).tolist()
    # What may come within reach before the next look is near: both partners at twice the speed of the fastest.
    before_look = 2 * np.linalg.norm(speed, axis=1).max() * 1e-7 * world.counters[COUNTER.look_in]
    near, own = near_of(candidates), dict(zip(zip(first.tolist(), second.tolist(), strict=True), gap, strict=True))
    gaps = np.array([own[pair] for pair in zip(candidates.ball[:walls], candidates.partner[:walls], strict=True)])
    assert np.isin(np.flatnonzero(gaps < 2 * before_look), near).all() and gaps[near[near < walls]].max() < 0.2 * skin
    assert (wall_gap < before_look).sum() <= (near >= walls).sum() <= (wall_gap < 0.2 * skin).sum()


def test_pairs_of_a_layer_are_listed_once():
    """More balls than ALL_PAIRS, and so low a box that there is one layer of cells."""
    place = np.stack(np.meshgrid(0.01 * np.arange(20), 0.01 * np.arange(10), [0.006], indexing="ij"), axis=-1)
    world = FewBalls(place.reshape(-1, 3) - [0.095, 0.045, 0.0], vessel=box(0.2, 0.1, 0.012), skin=1e-4)
    world.run(1e-5)
    candidates, first = world.candidates, np.triu_indices(200, 1)
    apart = np.linalg.norm(world.balls.position[first[0]] - world.balls.position[first[1]], axis=1)
    near = np.transpose(first)[apart < 0.01 + 1e-4].tolist()
    walls = int(candidates.first_wall[0, 0])
    assert len(near) == 19 * 10 + 20 * 9
    pairs = zip(candidates.ball[:walls].tolist(), candidates.partner[:walls].tolist(), strict=True)
    assert sorted(map(list, pairs)) == near


def test_a_ball_that_starts_at_the_origin_has_lists_from_the_first_step():
    """With a skin of 50 mm the lists were to be made after a way of 25 mm from the origin; the floor is nearer."""
    world = FewBalls([0.0, 0.0, 5.2e-3], [0.0, 0.0, -0.1], skin=0.05, gravity=0.0)
    world.run(0.01)
    assert world.balls.velocity[0, 2] == pytest.approx(0.1 * CALIBRATED.restitution, rel=0.05)
