"""The roll-out of a graph network as one kernel: its weights, folded where no ReLU is between linear layers.

No ReLU stands between the last linear layer of one multi-layer perceptron and the first of the next, nor between a
message and the mean over messages (Eq. 6.25). With x the last hidden values of a perceptron, its last layer L x + b and
a block W of the next one's first layer,
    W (L x + b) = (W L) x + W b,   mean_j(L x_j + b) = L mean_j(x_j) + b where there is a message, and 0 elsewhere.
So each perceptron hands on its last hidden values, and W L and W b are computed once, in double precision. The first
layer of a message, W_i v_i + W_j v_j + W_e e (Eq. 6.24), is computed once a node and once an edge, as in `network`,
whose results these are but for rounding.
"""

from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

from millprint.config.surrogate import EdgeConfig
from millprint.mill.distance import SignedDistance
from millprint.run.cache_lines import aligned
from millprint.thesis.surrogate.dataset import ball_reach
from millprint.thesis.surrogate.graph_surrogate import GraphSurrogate, State, Sums, no_sums
from millprint.thesis.surrogate.kernels import PANEL, Batch, Rules, make_scratch, roll
from millprint.thesis.surrogate.network import CHANNELS, NormalisedNetwork, read_weights
from millprint.thesis.surrogate.rollout import read_scene, read_trajectory


class Hidden(NamedTuple):
    """The layers of perceptrons between the first and the last; several rounds are the first axis."""

    weight: np.ndarray  # (..., layers, width, width) inputs first
    bias: np.ndarray  # (..., layers, width)


class Entry(NamedTuple):
    """The layers of a perceptron up to its last one."""

    first: np.ndarray  # (inputs, width)
    first_bias: np.ndarray  # (width,)
    hidden: Hidden


class Folded(NamedTuple):
    """Weights with inputs first, (inputs, outputs), in single precision, and what the features are normalised with.

    Outputs are packed in panels, see `packed`.

    `mean` and `deviation` (6, 7): a row for each kind of CHANNELS, in its order.
    """

    mean: np.ndarray
    deviation: np.ndarray
    node: Entry  # the encoder of nodes, from (window * 7) inputs
    edge: Entry  # the encoder of edges, from 3
    to_target: np.ndarray  # (rounds, width, width) from the node that receives a message, into its first layer
    to_source: np.ndarray  # from the node that sends it
    to_edge: np.ndarray
    message_bias: np.ndarray  # (rounds, width)
    message: Hidden
    own: np.ndarray  # (rounds, width, width) into the node's new values, from its old ones
    own_bias: np.ndarray
    received: np.ndarray  # (rounds, width, width) from the mean of its messages
    received_bias: np.ndarray  # (rounds, width) where there is a message
    updated: Hidden
    decoder: Entry
    decoder_last: np.ndarray  # (width, 3)
    decoder_last_bias: np.ndarray
    readout: Entry  # from the mean of the balls that have an edge
    readout_any_bias: np.ndarray  # (width,) where any ball has one
    readout_last: np.ndarray  # (width, 1)
    readout_last_bias: np.ndarray


class _Perceptron:
    """The layers of a torch perceptron in double precision, inputs first."""

    def __init__(self, state: dict[str, np.ndarray], name: str):
        numbers = sorted(int(key.split(".")[-2]) for key in state if key.startswith(f"{name}.") and "weight" in key)
        self.weights = [state[f"{name}.{number}.weight"].T for number in numbers]
        self.biases = [state[f"{name}.{number}.bias"] for number in numbers]

    def hidden(self) -> Hidden:
        """What is between the first layer and the last."""
        width = len(self.biases[0])
        weight = np.array(self.weights[1:-1]).reshape(-1, width, width)
        return Hidden(weight, np.array(self.biases[1:-1]).reshape(-1, width))

    def entry(self, first: np.ndarray | None = None, added: np.ndarray | float = 0.0) -> Entry:
        """What is up to the last layer, with another first one and with something added to its bias."""
        return Entry(self.weights[0] if first is None else first, self.biases[0] + added, self.hidden())

    def into(self, block: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The last layer, followed by a block (width, width) of the next perceptron's first: weight and bias."""
        return self.weights[-1] @ block, self.biases[-1] @ block


def fold(model: NormalisedNetwork) -> Folded:
    """The folded weights of a network."""
    state = {name: value.detach().cpu().double().numpy() for name, value in model.network.state_dict().items()}
    encoder, edge = _Perceptron(state, "node_encoder"), _Perceptron(state, "edge_encoder")
    decoder, readout = _Perceptron(state, "decoder"), _Perceptron(state, "readout")
    rounds: list[dict[str, Any]] = []
    before = encoder
    for number in range(len(model.network.processor)):
        message, update = (_Perceptron(state, f"processor.{number}.{name}") for name in ("message_mlp", "node_mlp"))
        rounds.append(_round(before, edge, message, update))
        before = update
    decoder_first, decoder_bias = before.into(decoder.weights[0])
    readout_first, readout_any_bias = before.into(readout.weights[0])
    arrays: dict[str, Any] = {
        "node": encoder.entry(),
        "edge": edge.entry(),
        **{name: _stacked([part[name] for part in rounds]) for name in rounds[0]},
        "decoder": decoder.entry(decoder_first, decoder_bias),
        "decoder_last": decoder.weights[-1],
        "decoder_last_bias": decoder.biases[-1],
        "readout": readout.entry(readout_first),
        "readout_any_bias": readout_any_bias,
        "readout_last": readout.weights[-1],
        "readout_last_bias": readout.biases[-1],
    }
    arrays_in_panels = {name: packed(name, value) for name, value in arrays.items()}
    return Folded(mean=_table(model, "mean"), deviation=_table(model, "std"), **arrays_in_panels)


def _round(before: _Perceptron, edge: _Perceptron, message: _Perceptron, update: _Perceptron) -> dict[str, Any]:
    """The arrays of one round of messages; before: the perceptron whose hidden values the nodes hold."""
    target, source, along = np.split(message.weights[0], 3)
    own, received = np.split(update.weights[0], 2)
    to_target, to_source, to_edge = before.into(target), before.into(source), edge.into(along)
    keeps, takes = before.into(own), message.into(received)
    return {
        "to_target": to_target[0],
        "to_source": to_source[0],
        "to_edge": to_edge[0],
        "message_bias": message.biases[0] + to_target[1] + to_source[1] + to_edge[1],
        "message": message.hidden(),
        "own": keeps[0],
        "own_bias": update.biases[0] + keeps[1],
        "received": takes[0],
        "received_bias": takes[1],
        "updated": update.hidden(),
    }


def _stacked(values: list[Any]) -> Any:
    """The same array of every round in one."""
    if isinstance(values[0], Hidden):
        return Hidden(*(np.stack(parts) for parts in zip(*values, strict=True)))
    return np.stack(values)


def packed(name: str, value: Any) -> Any:
    """In single precision, with zeros for outputs that fill up the last panel: (..., outputs) of a bias as it is, and
    (..., inputs, outputs) of a weight as (..., panels, inputs, PANEL).
    """
    if isinstance(value, Hidden | Entry):
        return type(value)(*(packed(field, part) for field, part in value._asdict().items()))
    filled = np.pad(value, [(0, 0)] * (value.ndim - 1) + [(0, -value.shape[-1] % PANEL)]).astype(np.float32)
    if name.endswith("bias"):
        return filled
    panels = filled.reshape(*filled.shape[:-1], filled.shape[-1] // PANEL, PANEL)
    return aligned(panels.swapaxes(-3, -2))


def _table(model: NormalisedNetwork, name: str) -> np.ndarray:
    """What each kind of feature or target is normalised with, a row a kind, filled up with ones."""
    table = np.ones((len(CHANNELS), max(CHANNELS.values())), dtype=np.float32)
    for row, (kind, channels) in zip(table, CHANNELS.items(), strict=True):
        row[:channels] = getattr(model, f"{kind}_{name}").cpu().numpy()
    return table


class CompiledSurrogate(GraphSurrogate):
    """A graph network whose steps are compiled. Its model is a NormalisedNetwork, and its vessel one of facets."""

    @cached_property
    def weights(self) -> Folded:
        """The weights of the model. Raises TypeError for a model that is not this network."""
        if not isinstance(self.model, NormalisedNetwork):
            raise TypeError(f"the compiled step knows NormalisedNetwork, not {type(self.model).__name__}")
        return fold(self.model)

    @cached_property
    def rules(self) -> Rules:
        """The rules of the recursion as the kernel takes them."""
        return Rules(
            step_s=self.step_s,
            speed_rpm=self.scene.speed_rpm,
            reach_squared_m2=np.float32(ball_reach(self.edges, self.scene.ball_radius_m) ** 2),
            wall_threshold_m=np.float32(self.edges.wall_threshold_m),
            snap_back_m=np.inf if self.snap_back_m is None else self.snap_back_m,
        )

    def batch(self, state: State) -> Batch:
        """A state for the kernel to write over; the state itself stays as it is."""
        position, velocity, ball, wall = (
            np.array(values, order="C") for values in (state.position_m, state.velocity_m_s, state.ball, state.wall)
        )
        return Batch(position, velocity, ball, wall, *no_sums(state))

    def advance_many(self, state: State, steps: int) -> tuple[State, Sums]:
        """The state some steps later, and what is added up over them. Raises TypeError for a wall without facets."""
        distance = self.scene.distance
        if not isinstance(distance, SignedDistance):
            raise TypeError(f"the compiled step knows the walls of SignedDistance, not {type(distance).__name__}")
        graphs, balls, _ = state.position_m.shape
        # Added up step by step, as a clock does.
        later = np.full((steps, graphs), self.step_s)
        times_s = np.cumsum(np.concatenate([state.time_s[None], later]), axis=0)[1:]
        batch = self.batch(state)
        panels, inputs, panel = self.weights.node.first.shape
        scratch = make_scratch(graphs, balls, inputs, panels * panel)
        walls = np.ascontiguousarray(self.scene.wall_position(times_s))
        roll(self.weights, scratch, distance.surface, self.rules, batch, walls)
        after = State(times_s[-1], batch.position, batch.velocity, batch.ball, batch.wall)
        return after, Sums(batch.dissipated, batch.crossed, batch.edges)


def open_graph_surrogate(
    weights: str | Path,
    run: str | Path,
    edges: EdgeConfig,
    snap_back_m: float | None,
    device: torch.device,
    until_s: float,
) -> GraphSurrogate:
    """The network of a weights file in the scene of a simulation, which gives its first states.

    edges, snap_back_m: as of GraphSurrogate; until_s: first states are taken up to this time of motion [s]. Raises
    ConfigError for a damaged file.
    """
    model, recipe = read_weights(weights, device)
    source = read_trajectory(run, until_s=until_s)
    # A graphics card has no kernels of ours.
    stepped = CompiledSurrogate if device.type == "cpu" else GraphSurrogate
    return stepped(model, read_scene(run), source, recipe.graph.window, edges, snap_back_m, device)
