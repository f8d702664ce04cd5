"""The contact surrogate: properties that hold for any network, and training that continues where it stopped."""

from functools import partial

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from millprint.columns import span_of
from millprint.config.contact_surrogate import ContactRecipe, ValidationConfig
from millprint.dem.compilation import TINY_CONTACT, TINY_MILL
from millprint.dem.layout import COUNTER, LANES, TOTAL
from millprint.surrogate.checkpoint import write_tensors
from millprint.surrogate.contact import samples
from millprint.surrogate.contact.coarse import CoarseSimulation, coarse_step
from millprint.surrogate.contact.dataset import Samples, follow, read_dataset, truths, write_dataset
from millprint.surrogate.contact.ensemble import ensemble_content, reached_states, read_ensemble, roll_out_errors
from millprint.surrogate.contact.pair import PAIR, PAIR_WIDTH
from millprint.surrogate.contact.scratch import make_weights, no_weights
from millprint.surrogate.contact.step import gather_all, predict
from millprint.surrogate.contact.training import ContactTrainer, batch_of
from tests.unit.contact_samples import COARSE, NETWORK, TRACE, TRAINING, in_mid_air, random_network, tiny_tracer

RADIUS = TRACE.ball_diameter_mm / 2e3
VALIDATION = ValidationConfig(starts=2, length_s=0.01, position_s=0.005)


@pytest.fixture(scope="module")
def tracer():
    return tiny_tracer()


@pytest.fixture(scope="module")
def followed(tracer) -> Samples:
    return follow(tracer, TRACE)


def small_simulation(balls: int) -> CoarseSimulation:
    step = coarse_step(TINY_CONTACT, RADIUS, COARSE.rayleigh_multiple, 1e-3)
    coarse = CoarseSimulation(TINY_MILL, TINY_CONTACT, TRACE.speed_rpm, RADIUS, balls, step, COARSE.substeps)
    coarse.weights = make_weights(random_network().arrays())
    return coarse


def some_states(followed: Samples, count: int) -> list[torch.Tensor]:
    return [part for part in torch.from_numpy(followed.rows).double().split(followed.sizes.tolist()) if len(part)][
        :count
    ]


@pytest.mark.parametrize("reflect", [False, True])
def test_what_is_expected_turns_with_the_jar(followed, reflect):
    rows, graph = batch_of(some_states(followed, 20))
    turn = Rotation.random(random_state=3).as_matrix() * (-1 if reflect else 1)
    matrix, sign = torch.from_numpy(turn), np.sign(np.linalg.det(turn))
    turned = rows.clone()
    for column in (
        samples.AWAY,
        samples.VELOCITY,
        samples.FORCE,
        samples.BASE,
        samples.ANGULAR_VELOCITY,
        samples.OTHER_ANGULAR_VELOCITY,
    ):
        # Angular velocities are axial: they keep their sense where space is mirrored.
        axial = column in (samples.ANGULAR_VELOCITY, samples.OTHER_ANGULAR_VELOCITY)
        turned[:, column : column + 3] = rows[:, column : column + 3] @ matrix.T * (sign if axial else 1)
    model = random_network().double()
    _, turned_graph = batch_of([turned])
    turned_graph.first, turned_graph.second, turned_graph.balls = graph.first, graph.second, graph.balls
    for before, after in zip(model(graph), model(turned_graph), strict=True):
        for vector, other in zip(before, after, strict=True):
            assert vector.abs().max() > 1e-4
            torch.testing.assert_close(vector @ matrix.T, other, rtol=1e-7, atol=1e-10)


def test_exchanging_the_partners_turns_the_force_round(followed):
    rows, graph = batch_of(some_states(followed, 60))
    pairs = rows[:, samples.SECOND] >= 0
    assert pairs.any()
    swapped = rows.clone()
    for column in (samples.AWAY, samples.VELOCITY, samples.FORCE):
        swapped[pairs, column : column + 3] *= -1
    for one, other, width in (
        (samples.ANGULAR_VELOCITY, samples.OTHER_ANGULAR_VELOCITY, 3), (samples.ARM, samples.OTHER_ARM, 1),
        (samples.INVERSE_MASS, samples.OTHER_INVERSE_MASS, 1),
        (samples.INVERSE_INERTIA, samples.OTHER_INVERSE_INERTIA, 1),
    ):  # fmt: skip
        swapped[pairs, one : one + width] = rows[pairs, other : other + width]
        swapped[pairs, other : other + width] = rows[pairs, one : one + width]
    _, other_graph = batch_of([swapped])
    other_graph.first = torch.where(pairs, graph.second, graph.first)
    other_graph.second = torch.where(pairs, graph.first, graph.second)
    other_graph.balls = graph.balls
    model = random_network().double()
    sign = torch.where(pairs, -1.0, 1.0)[:, None]
    torch.testing.assert_close(model(graph)[-1][0], sign * model(other_graph)[-1][0], rtol=1e-7, atol=1e-10)


def test_kernel_and_torch_expect_the_same(tracer):
    begin, coarse = tracer.saved(), tracer.coarse
    rows = np.zeros((2000, samples.SAMPLE_COLUMNS))
    count = tracer._sample_once(rows)
    model = random_network(size=0.2)
    _, graph = batch_of([torch.from_numpy(rows[:count].astype(np.float32))])
    mean, tilt = (value.detach().numpy() for value in model(graph)[-1])
    coarse.weights = make_weights(model.arrays())
    coarse.load(begin)
    groups = coarse.groups
    gather_all(*groups[:6], coarse.scratch, *groups[6:], begin.step * coarse.step)
    predict(coarse.balls, coarse.contacts, coarse.walls, coarse.clock, coarse.scratch, coarse.counters)
    used = [lane for lane in range(coarse.counters[COUNTER.used]) if coarse.contacts.slot[lane] >= 0]
    for quantity, expected in ((PAIR.expected_force, mean), (PAIR.expected_tilt, tilt)):
        rows = coarse.scratch.work.reshape(-1, PAIR_WIDTH, LANES)
        found = [rows[lane // LANES, span_of(quantity), lane % LANES] for lane in used]
        expected = expected * graph.unit.numpy()
        assert np.abs(expected).max() > 1e-4
        np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-5 * np.abs(expected).max())
    coarse.weights = no_weights()


def test_three_balls_that_meet_keep_their_momentum():
    coarse = small_simulation(3)
    coarse.clock.gravity[:] = 0.0
    middle = np.array([0.0095, 0.0, 0.008])
    position = middle + np.array([[-1.05 * RADIUS, 0, 0], [1.02 * RADIUS, 0, 0], [0, 1.9 * RADIUS, 0]])
    velocity = np.array([[0.8, 0.1, 0], [-0.5, 0, 0.05], [0, -1.0, 0]])
    angular_velocity = np.array([[0, 30.0, 0], [10.0, 0, -20.0], [0, 0, 5.0]])
    coarse.load(in_mid_air(coarse, position, velocity, angular_velocity))
    kept = coarse.record(60, 1)
    momentum = kept.rate[:, :, :3].sum(axis=1)
    np.testing.assert_allclose(momentum, np.broadcast_to(velocity.sum(axis=0), momentum.shape), atol=1e-12)
    assert kept.works[-1, TOTAL.normal_damping_J] > 0
    assert np.abs(kept.rate[-1, :, :3] - velocity).max() > 0.3


def test_nothing_is_dissipated_without_contact_and_balls_fall_as_they_do():
    coarse = small_simulation(1)
    position, velocity = np.array([[0.009, 0, 0.010]]), np.array([[0.02, -0.01, 0.1]])
    coarse.load(in_mid_air(coarse, position, velocity, np.zeros((1, 3))))
    kept = coarse.record(100, 1)
    time_s = coarse.step * np.arange(1, 101)[:, None]
    fall = np.array([0, 0, -9.81])
    np.testing.assert_allclose(
        kept.position[:, 0] - coarse.bodies[0].motion.position(-1.0),
        position + velocity * time_s + fall / 2 * time_s**2,
        atol=1e-12,
    )
    assert (kept.works == 0).all()
    assert (kept.ended == 0).all()


@pytest.mark.parametrize("height_radii", [1.2, 1.2003, 1.2007, 1.2011])
def test_a_bounce_does_not_depend_on_where_in_the_step_it_begins(height_radii):
    coarse = small_simulation(1)
    coarse.clock.gravity[:] = 0.0
    speed = 0.7
    # Away from the post and the fillets, over the flat floor.
    floor = coarse.bodies[0].vessel.bounds[0, 2]
    position = np.array([[0.008, 0.0, floor + height_radii * RADIUS]])
    coarse.load(in_mid_air(coarse, position, np.array([[0, 0, -speed]]), np.zeros((1, 3))))
    assert coarse.run(80)
    restitution = coarse.balls.rate[0, 2] / speed
    assert restitution == pytest.approx(TINY_CONTACT.restitution, rel=0.02)


def test_dissipation_never_falls_and_no_ball_leaves_an_untrained_jar(tracer):
    coarse = tracer.coarse
    coarse.weights = make_weights(random_network(seed=5).arrays())
    coarse.load(tracer.saved())
    kept = coarse.record(400, 5)
    coarse.weights = no_weights()
    assert np.isfinite(kept.position).all()
    for channel in (TOTAL.normal_damping_J, TOTAL.tangential_damping_J, TOTAL.rolling_J):
        assert (np.diff(kept.works[:, channel]) >= 0).all()
    tangential = kept.works[:, TOTAL.tangential_work_J] - kept.works[:, TOTAL.elastic_tangential_J]
    assert tangential[-1] > 0
    body = (
        kept.position
        - coarse.bodies[0].motion.position((tracer.coarse_number + 5 * np.arange(1, 401)) * coarse.step)[:, None]
    )
    low, high = coarse.bodies[0].vessel.bounds
    assert (body > low + 0.5 * RADIUS).all()
    assert (body < high - 0.5 * RADIUS).all()


def test_coarse_steps_follow_the_dem_through_impacts(tracer):
    coarse, begin, before = tracer.coarse, tracer.saved(), tracer.works()
    coarse.load(begin)
    steps = round(0.004 / coarse.step)
    assert coarse.run(steps)
    tracer.to_step((begin.step + steps) * tracer.fine_steps)
    assert tracer.works()[TOTAL.normal_damping_J] > before[TOTAL.normal_damping_J]
    moved = np.linalg.norm(tracer.balls.position - begin.position, axis=1)
    error = np.linalg.norm(coarse.balls.position - tracer.balls.position, axis=1)
    assert np.median(error) < 0.01 * np.median(moved)


def test_followed_impulses_are_those_that_move_the_balls(tracer):
    begin = tracer.saved()
    rows = np.zeros((2000, samples.SAMPLE_COLUMNS))
    rows = rows[: tracer._sample_once(rows)]
    impulse = np.zeros((tracer.count, 3))
    first, second = rows[:, samples.FIRST].astype(int), rows[:, samples.SECOND].astype(int)
    pushed = rows[:, samples.IMPULSE : samples.IMPULSE + 3]
    np.add.at(impulse, first, pushed)
    np.subtract.at(impulse, second[second >= 0], pushed[second >= 0])
    change = tracer.balls.rate_now[:, :3] - begin.rate[:, :3] - tracer.clock.gravity * tracer.coarse.step
    mass = tracer.balls.mass[0]
    # The end of the step is half a fine step apart, and an unforeseen contact is not followed.
    assert np.median(np.linalg.norm(impulse / mass - change, axis=1)) < 2e-3 * np.abs(change).max()


def test_a_killed_training_goes_on_as_if_it_had_not_been(tracer, followed, tmp_path):
    found = truths(tracer, VALIDATION)
    write_dataset([followed], found, tmp_path / "contacts.h5")
    parts, found = read_dataset(tmp_path / "contacts.h5")
    np.testing.assert_array_equal(parts[0].rows, followed.rows)
    begin = tracer.saved()

    def fresh() -> ContactTrainer:
        def own(weights):
            tracer.load(begin)
            return reached_states([tracer], weights, TRAINING)

        validate = partial(roll_out_errors, tracer.coarse, truths=found, settings=VALIDATION)
        settings = TRAINING.model_copy(update={"seed": 7})
        return ContactTrainer(parts, NETWORK, settings, validate, own, "same", torch.device("cpu"))

    whole = fresh()
    assert whole.train()
    halves = fresh()
    # Killed in the second epoch, after states of its own have been added.
    assert not halves.train(tmp_path / "half.pt", max_steps=9)
    resumed = fresh()
    assert resumed.resume(tmp_path / "half.pt", torch.device("cpu"))
    assert resumed.own is not None
    assert resumed.train()
    for one, other in zip(whole.model.parameters(), resumed.model.parameters(), strict=True):
        torch.testing.assert_close(one, other, rtol=0, atol=0)
    assert [row["roll_out_score"] for row in whole.history] == [row["roll_out_score"] for row in resumed.history]
    assert len(whole.history) == TRAINING.epochs


def test_weights_come_back_without_pickle(tmp_path):
    models = [random_network(seed) for seed in (1, 2)]
    recipe = ContactRecipe(coarse=COARSE, network=NETWORK, training=TRAINING, members=2)
    write_tensors(tmp_path / "weights.pt", ensemble_content([model.state_dict() for model in models], recipe))
    members, read = read_ensemble(tmp_path / "weights.pt")
    assert read == recipe
    for model, weights in zip(models, members, strict=True):
        np.testing.assert_array_equal(model.arrays()[4], weights.last)
