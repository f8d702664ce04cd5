"""The compiled roll-out of the graph network against its steps in torch, and a step against double precision."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
import yaml

from millprint.config.surrogate import NetworkConfig
from millprint.run.kernel import array_maker
from millprint.thesis.surrogate.compiled import CompiledSurrogate, open_graph_surrogate, packed
from millprint.thesis.surrogate.dataset import Graphs, featurise, threshold_edges
from millprint.thesis.surrogate.graph_surrogate import GraphSurrogate
from millprint.thesis.surrogate.kernels import PANEL, PIECE, WORD, add_product
from millprint.thesis.surrogate.network import NormalisedNetwork, feature_statistics, write_weights
from millprint.thesis.surrogate.rollout import read_scene
from tests.unit.surrogate_samples import CONTACTS, circle, simulate, small_recipe, sphere_scene, write_run

ROOT = Path(__file__).parents[2]

CPU = torch.device("cpu")

BALLS, WINDOW, SNAP_BACK_M = 8, 3, -0.0049

STARTS = [0.004, 0.012, 0.018]

# All balls of a graph joined: more edges in a batch than one piece holds.
CROWD = CONTACTS.model_copy(update={"ball_threshold_m": 0.06, "wall_threshold_m": -0.02})


@pytest.fixture(scope="module", params=["emax", "emax_post"])
def world(request, tmp_path_factory):
    """Scene and balls of a jar without and with a post, and their file; half of the balls are beyond its floor."""
    path = tmp_path_factory.mktemp(request.param) / "run.h5"
    files = f"mills/{request.param}.yaml", "contacts/calibrated.yaml"
    mill, contact = (yaml.safe_load((ROOT / "config" / name).read_text()) for name in files)
    config = {"mill": mill, "contact": contact, "case": {"ball_diameter_m": 0.01, "speed_hz": 5.0}}
    run = simulate(200, BALLS)
    write_run(run, path, config)
    scene = read_scene(path)
    wall = scene.wall_position(run.time_s)
    low = np.array([0.0, 0.0, 0.005])
    place = run.position_m - circle(run.time_s)[:, None] + wall[:, None] + low
    run = replace(run, position_m=place, wall_position_m=wall)
    write_run(run, path, config)
    return scene, run, path


def network(world, rounds: int, layers: int, width: int) -> tuple[NormalisedNetwork, object]:
    """Random weights and, other than at the start of a training, random biases."""
    scene, run, _ = world
    size = NetworkConfig(width=width, mlp_layers=layers, interaction_layers=rounds)
    recipe = small_recipe(window=WINDOW).model_copy(update={"network": size})
    torch.manual_seed(rounds + 10 * layers + width)
    statistics = feature_statistics([(featurise(run, scene), torch.arange(3, 190))], recipe.graph, CONTACTS)
    model = NormalisedNetwork(recipe, statistics).eval()
    for name, value in model.named_parameters():
        if name.endswith("bias"):
            torch.nn.init.normal_(value, std=0.3)
    return model, recipe


def both(world, model, edges=CONTACTS, snap_back_m=SNAP_BACK_M) -> tuple[CompiledSurrogate, GraphSurrogate]:
    scene, run, _ = world
    values = (model, scene, run, WINDOW, edges, snap_back_m, CPU)
    return CompiledSurrogate(*values), GraphSurrogate(*values)


def in_double(surrogate: GraphSurrogate, state, rounding: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations and dissipation from the same weights and single-precision states, in double precision.

    rounding: a seed, to move each weight by about what single precision rounds off.
    """
    now, model = surrogate.graphs(state), deepcopy(surrogate.model).double()
    place, ball = (torch.from_numpy(part.astype(np.float32)).double() for part in (state.position_m, state.ball))
    edges = threshold_edges(place, ball[:, :, -1], surrogate.edges, surrogate.scene.ball_radius_m)
    with torch.inference_mode():
        if rounding is not None:
            generator = torch.Generator().manual_seed(rounding)
            for weight in model.parameters():
                weight *= 1 + 2.0**-24 * torch.randn(weight.shape, generator=generator)
        acceleration, dissipation = model(Graphs(now.ball.double(), now.wall.double(), edges, now.balls))
    return acceleration.numpy(), dissipation.numpy()


def distances(compiled, torch_, state) -> dict[str, float]:
    """How far accelerations are from those in double precision, over the largest one: of the kernel, of torch, and of
    double precision itself with weights rounded once, the farthest of four times.
    """
    exact, _ = in_double(torch_, state)
    rounded = [in_double(torch_, state, seed)[0] for seed in range(4)]
    found = {"rounding": float(np.abs(rounded - exact).max() / np.abs(exact).max())}
    for name, surrogate in (("kernel", compiled), ("torch", torch_)):
        after, _ = surrogate.advance_many(state, 1)
        acceleration = (after.velocity_m_s - state.velocity_m_s) / surrogate.step_s
        found[name] = float(np.abs(acceleration - exact).max() / np.abs(exact).max())
    return found


def assert_same_step(compiled, torch_, state) -> None:
    """Accelerations and dissipation are those in double precision to a millionth, and everything else is torch's."""
    apart = distances(compiled, torch_, state)
    assert apart["kernel"] < max(1e-6, 2 * apart["rounding"]), apart
    (now, sums), (known, known_sums) = compiled.advance_many(state, 1), torch_.advance_many(state, 1)
    _, dissipation = in_double(torch_, state)
    spread = float(torch_.model.dissipation_std)
    np.testing.assert_allclose(sums.dissipated_J, dissipation, rtol=1e-6, atol=1e-6 * spread)
    np.testing.assert_allclose(sums.dissipated_J, known_sums.dissipated_J, rtol=1e-5, atol=1e-5 * spread)
    np.testing.assert_array_equal(sums.edges, known_sums.edges)
    np.testing.assert_array_equal(sums.crossed, known_sums.crossed)
    np.testing.assert_array_equal(now.time_s, known.time_s)
    np.testing.assert_allclose(now.position_m, known.position_m, rtol=1e-12)
    for name in ("ball", "wall"):
        np.testing.assert_allclose(getattr(now, name), getattr(known, name), rtol=1e-5, atol=1e-7)


@pytest.mark.slow
def test_the_thesis_size_is_nearer_to_double_precision_than_torch(world):
    """A sum of 256 numbers in parts loses less than one after the other."""
    compiled, torch_ = both(world, network(world, 1, 4, 256)[0])
    apart = distances(compiled, torch_, torch_.first_state(STARTS))
    assert apart["kernel"] < 1e-6, apart
    assert apart["kernel"] < apart["torch"], apart


@pytest.mark.parametrize(("rounds", "layers", "width"), [(1, 4, 16), (2, 2, 16), (3, 4, 16), (1, 3, 18), (2, 5, 6)])
@pytest.mark.slow
def test_every_depth_and_width_equals_torch(world, rounds, layers, width):
    compiled, torch_ = both(world, network(world, rounds, layers, width)[0])
    assert_same_step(compiled, torch_, torch_.first_state(STARTS))


@pytest.mark.parametrize("snap_back_m", [None, SNAP_BACK_M])
@pytest.mark.parametrize("edges", [CROWD, CONTACTS.model_copy(update={"ball_threshold_reading": "centre_distance"})])
def test_every_rule_equals_torch(world, edges, snap_back_m):
    compiled, torch_ = both(world, network(world, 2, 4, 16)[0], edges, snap_back_m)
    state = torch_.first_state(STARTS)
    assert_same_step(compiled, torch_, state)
    joined = len(torch_.graphs(state).edges.pair[0])
    assert joined > 2 * PIECE if edges is CROWD else joined == 0


def test_a_graph_without_edges_equals_torch(world):
    far = CONTACTS.model_copy(update={"ball_threshold_reading": "centre_distance", "wall_threshold_m": -1e-9})
    compiled, torch_ = both(world, network(world, 1, 4, 16)[0], far)
    state = torch_.first_state(STARTS)
    state.ball[0, :, :, 3] = -0.01
    assert not (torch_.graphs(state).edges.wall < BALLS).any()
    assert_same_step(compiled, torch_, state)


def test_a_short_roll_out_equals_torch(world):
    compiled, torch_ = both(world, network(world, 1, 4, 16)[0])
    found, known = (own.run(own.first_state(STARTS), 20, 5) for own in (compiled, torch_))
    np.testing.assert_allclose(found.position_m, known.position_m, atol=1e-7)
    np.testing.assert_allclose(found.dissipated_J, known.dissipated_J, rtol=1e-4)
    np.testing.assert_array_equal(found.crossed_s, known.crossed_s)
    assert found.mean_edges == known.mean_edges and np.isfinite(found.crossed_s).any()


def test_a_lost_ball_loses_no_other(world):
    """A place that is not a number has no distance and no edges, and the ball counts as outside."""
    compiled, torch_ = both(world, network(world, 1, 4, 16)[0])
    state = torch_.first_state(STARTS)
    state.position_m[1, 2] = np.nan
    state.ball[1, 2] = np.nan
    with np.errstate(invalid="ignore"):
        (now, sums), (known, _) = compiled.advance_many(state, 1), torch_.advance_many(state, 1)
    assert np.isnan(now.position_m[1, 2]).all() and np.isnan(now.velocity_m_s[1, 2]).all() and sums.crossed[1, 2] == 1
    np.testing.assert_array_equal(np.isnan(now.ball), np.isnan(known.ball))
    rest = np.isfinite(known.position_m)
    np.testing.assert_allclose(now.position_m[rest], known.position_m[rest], rtol=1e-12)


def test_what_the_kernel_does_not_know_raises(world):
    model, _ = network(world, 1, 4, 16)
    scene, run, _ = world
    for other in ((lambda graphs: graphs, scene), (model, sphere_scene())):
        own = CompiledSurrogate(*other, run, WINDOW, CONTACTS, None, CPU)
        with pytest.raises(TypeError, match="the compiled step knows"):
            own.advance_many(own.first_state(STARTS), 1)


def test_a_processor_takes_compiled_steps(world, tmp_path):
    model, recipe = network(world, 1, 4, 16)
    write_weights(tmp_path / "weights.pt", model, recipe)
    surrogate = open_graph_surrogate(tmp_path / "weights.pt", world[2], CONTACTS, None, CPU, 0.015)
    assert type(surrogate) is CompiledSurrogate
    compiled, _ = both(world, model, snap_back_m=None)
    found, known = (own.run(own.first_state([0.004]), 4, 2).position_m for own in (surrogate, compiled))
    np.testing.assert_allclose(found, known, atol=1e-6)


@array_maker()
def product(out, weight, x, rows):
    """`add_product`, which only kernels may call."""
    add_product(out, weight, x, rows)


@pytest.mark.parametrize("rows", [1, 7, 64])
@pytest.mark.parametrize(("inputs", "outputs"), [(1, 1), (3, 16), (49, PANEL), (256, 256), (70, 100)])
@pytest.mark.parametrize("zeros", [0.0, 0.6, 1.0])
def test_a_product_equals_numpy(rows, inputs, outputs, zeros):
    random = np.random.default_rng(rows + inputs)
    width = outputs + -outputs % PANEL
    # Inputs stand in rows that are wider than what the layer takes, and in more rows than count.
    x = random.normal(size=(rows + 2, inputs + 5)).astype(np.float32)
    x[random.random(x.shape) < zeros] = 0.0
    weight, start = random.normal(size=(inputs, outputs)), random.normal(size=(rows + 2, width)).astype(np.float32)
    out = start.copy()
    product(out, packed("weight", weight), x, rows)
    expected = start[:rows, :outputs] + x[:rows, :inputs].astype(float) @ weight.astype(np.float32).astype(float)
    scale = np.abs(x[:rows, :inputs]) @ np.abs(weight)
    assert (np.abs(out[:rows, :outputs] - expected) < 3e-7 * (scale + np.abs(expected))).all()
    np.testing.assert_array_equal(out[:rows, outputs:], start[:rows, outputs:])
    np.testing.assert_array_equal(out[rows:], start[rows:])


def test_what_is_not_a_number_reaches_its_row_and_no_other():
    x, out = np.zeros((3, WORD), dtype=np.float32), np.zeros((3, PANEL), dtype=np.float32)
    x[1, 5] = np.nan
    product(out, packed("weight", np.ones((WORD, PANEL))), x, 3)
    assert np.isnan(out[1]).all() and not out[[0, 2]].any()
