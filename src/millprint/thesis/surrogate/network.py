"""The signed-distance graph network (thesis Eqs 6.22 to 6.27), its normalisation, and files of tensors.

Training of the network (thesis Sec. 6.2.2); stopped after any step, it continues exactly as without the stop.
"""

import hashlib
import io
import itertools
import json
import logging
import math
import pickle
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pandas as pd
import torch
from llvmlite import binding
from torch import Tensor, nn
from torch.nn.functional import linear, smooth_l1_loss
from torch_geometric.nn import MessagePassing
from torch_geometric.utils import scatter

from millprint.config.errors import ConfigError, TrainingError
from millprint.config.section import Section
from millprint.config.surrogate import EdgeConfig, GraphConfig, NetworkConfig, Recipe, TrainingConfig
from millprint.run.files import checksum_header, read_checksummed, whole_file
from millprint.run.job import progress
from millprint.thesis.surrogate.dataset import (
    BALL_CHANNELS,
    VELOCITY,
    WALL_CHANNELS,
    Graphs,
    Snapshots,
    TrainingRun,
    edges_at,
    graphs_at,
    on_device,
    read_dataset,
)

logger = logging.getLogger("millprint")

BUDGET = {"wall_time_max_s", "checkpoint_every_s", "threads"}


def choose_device(threads: int) -> torch.device:
    """A GPU when there is one, otherwise `threads` threads of the processor."""
    torch.set_num_threads(threads)
    if torch.cuda.is_available():
        return torch.device("cuda")
    choose_products()
    return torch.device("cpu")


def choose_products() -> None:
    """Let oneDNN multiply matrices on processors of AMD, where MKL uses vectors of half the width (AVX-512).

    torch gives products to oneDNN only if their factors may be rounded to bfloat16. Where the processor has no fast
    products of these, nothing is rounded; where it has, MKL goes on: with rounded factors trainings end with larger
    losses.
    """
    torch.set_float32_matmul_precision("medium")
    if not (binding.get_host_cpu_name().startswith("znver") and has_single_products()):
        torch.set_float32_matmul_precision("highest")


def has_single_products() -> bool:
    """Whether products of matrices are as exact as sums in single precision; with rounded factors they are 2e-3 off."""
    factor = torch.linspace(1, 2, 256**2).view(256, 256)
    exact = factor.double() @ factor.double()
    return bool((factor @ factor - exact).abs().max() < 1e-5 * exact.max())


def identity(settings: Section, data: Iterable[np.ndarray]) -> str:
    """A hash of the settings of a training and of its data: only a checkpoint of the same may be resumed.

    How long to train, how often to save and on how many threads is left out: a training may go on with more.
    """
    content = settings.model_dump(mode="json", exclude={"training": BUDGET})
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    for part in data:
        total.update(part.tobytes())
    return total.hexdigest()


def _as_bytes(content: dict) -> bytes:
    """The bytes that torch writes. In a file they would contain the file's name, with a process number."""
    memory = io.BytesIO()
    torch.save(content, memory)
    return memory.getvalue()


def read_checkpoint(path: str | Path, own_identity: str, device: torch.device) -> dict | None:
    """The checkpoint at `path` if there is one of this `identity`, otherwise None, with a line in the log."""
    if not Path(path).exists():
        return None
    try:
        content = torch.load(io.BytesIO(read_checksummed(path)), map_location=device, weights_only=True)
        fits = content["identity"] == own_identity
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        logger.warning("%s cannot be read (%s): starting again", path, " ".join(str(error).split()))
        return None
    if not fits:
        logger.info("%s belongs to other settings or data: starting again", path)
    return content if fits else None


# What is normalised, and its number of channels.
CHANNELS = {
    "ball": BALL_CHANNELS,
    "wall": WALL_CHANNELS,
    "pair": 3,
    "wall_edge": 3,
    "acceleration": 3,
    "dissipation": 1,
}


class Perceptron(nn.Sequential):
    """A multi-layer perceptron of `layers` linear layers with ReLU between them.

    Weights start as He et al. (2015) have them for ReLU. The default of torch shrinks the signal by 0.4 a layer, and
    after the twelve layers between input and output too little is left to learn from.
    """

    def __init__(self, inputs: int, width: int, outputs: int, layers: int):
        super().__init__()
        for inner, outer in itertools.pairwise([inputs, *[width] * (layers - 1), outputs]):
            layer = nn.Linear(inner, outer)
            nn.init.kaiming_normal_(layer.weight, nonlinearity="relu")
            nn.init.zeros_(layer.bias)
            self.extend([layer, nn.ReLU(inplace=True)])
        del self[-1]

    @property
    def first(self) -> nn.Linear:
        """The first linear layer."""
        return cast(nn.Linear, self[0])

    @property
    def last(self) -> nn.Linear:
        """The last linear layer."""
        return cast(nn.Linear, self[-1])

    def between(self, values: Tensor) -> Tensor:
        """From what the first linear layer gives, which is overwritten, to what the last one takes: (n, width)."""
        for module in list(self)[1:-1]:
            values = module(values)
        return values


def in_one(first: nn.Linear, second: nn.Linear, values: Tensor) -> Tensor:
    """Values (n, inputs) through two linear layers without a ReLU between them, whose weights are multiplied first."""
    bias = torch.addmv(second.bias, second.weight, first.bias)
    return linear(values, second.weight @ first.weight, bias)


class InteractionLayer(MessagePassing):
    """One round of message passing with mean aggregation (Eqs 6.24 to 6.26).

    The first linear layer of a message, on [v_i, v_j, e_ij], is W_i v_i + W_j v_j + W_e e_ij: what nodes add is
    computed once a node. No ReLU follows the last one, so the mean over messages is taken before it. The same holds
    for what a node and its messages add to its new values: a node without messages is given none.
    """

    def __init__(self, width: int, layers: int):
        super().__init__(aggr="mean")
        self.message_mlp = Perceptron(3 * width, width, width, layers)
        self.node_mlp = Perceptron(2 * width, width, width, layers)

    def forward(self, node: Tensor, edge_index: Tensor, edge: Tensor) -> Tensor:
        """node (n, width), edge_index (2, e) source and target, edge (e, width); returns (n, width)."""
        return self.node_mlp.last(self.hidden(node, edge_index, edge, len(node)))

    def hidden(self, node: Tensor, edge_index: Tensor, edge: Tensor, updated: int) -> Tensor:
        """What the last linear layer of the nodes takes, of the first `updated` nodes; no others receive messages."""
        message, update = self.message_mlp, self.node_mlp
        to_target, to_source, along = message.first.weight.chunk(3, dim=1)
        own, received = update.first.weight.chunk(2, dim=1)
        (sources, source), (targets, target) = (torch.unique(ends, return_inverse=True) for ends in edge_index)
        mean = self.propagate(
            torch.stack([source, target]),
            node=(linear(node[sources], to_source), linear(node[targets], to_target)),
            edge=linear(edge, along, message.first.bias),
            size=(len(sources), len(targets)),
        )
        values = linear(node[:updated], own, update.first.bias)
        values.index_add_(0, targets, linear(message.last(mean), received))
        return update.between(values)

    def message(self, node_i: Tensor, node_j: Tensor, edge: Tensor) -> Tensor:
        """Hidden values of the message into node i from node j, Eq. 6.24, from what both and the edge add to it."""
        return self.message_mlp.between(node_i + node_j + edge)


class SignedDistanceNetwork(nn.Module):
    """Normalised graphs to the normalised acceleration of each ball and dissipation of each graph.

    One MLP encodes balls and walls, one both kinds of edges, as in Eqs 6.22 and 6.23. A wall edge carries messages
    both ways; the wall's own output is not used, so nothing is sent to it in the last round.
    """

    def __init__(self, window: int, size: NetworkConfig):
        super().__init__()
        width, layers = size.width, size.mlp_layers
        self.node_encoder = Perceptron(7 * window, width, width, layers)
        self.edge_encoder = Perceptron(3, width, width, layers)
        self.processor = nn.ModuleList(InteractionLayer(width, layers) for _ in range(size.interaction_layers))
        self.decoder = Perceptron(width, width, 3, layers)
        self.readout = Perceptron(width, width, 1, layers)

    def forward(self, graphs: Graphs) -> tuple[Tensor, Tensor]:
        """Normalised acceleration (graphs * balls, 3) and dissipation (graphs,)."""
        edges, balls = graphs.edges, len(graphs.ball)
        *earlier, last = cast(Iterable[InteractionLayer], self.processor)
        node = self.node_encoder(torch.cat([graphs.ball, graphs.wall]))
        edge = self.edge_encoder(torch.cat([edges.pair_vector, edges.wall_vector]))
        wall = graphs.graph_of_ball[edges.wall] + balls
        into_balls = torch.cat([edges.pair, torch.stack([wall, edges.wall])], dim=1)
        into_walls = torch.stack([edges.wall, wall])
        for layer in earlier:
            both_ways = torch.cat([edge, edge[len(edges.pair_vector) :]])
            node = layer(node, torch.cat([into_balls, into_walls], dim=1), both_ways)
        hidden = last.hidden(node, into_balls, edge, balls)
        decoder, update = self.decoder, last.node_mlp.last
        acceleration = decoder.last(decoder.between(in_one(update, decoder.first, hidden)))
        return acceleration, self._dissipation(hidden, update, into_balls[1], graphs)

    def _dissipation(self, hidden: Tensor, update: nn.Linear, touched: Tensor, graphs: Graphs) -> Tensor:
        """Mean of the balls with an edge, through the readout; a graph without any pools to zero."""
        balls = touched.unique()
        graph = graphs.graph_of_ball[balls]
        pooled = update(scatter(hidden[balls], graph, dim_size=graphs.count, reduce="mean"))
        any_edge = torch.zeros(graphs.count, 1, dtype=torch.bool, device=hidden.device)
        any_edge[graph] = True
        return self.readout(torch.where(any_edge, pooled, 0)).squeeze(1)


def target(run: Snapshots, graph: GraphConfig) -> Tensor:
    """The acceleration that the network is asked for, (n, balls, 3) [m/s2]."""
    return getattr(run, graph.acceleration)


def feature_statistics(
    parts: list[tuple[Snapshots, Tensor]], graph: GraphConfig, rule: EdgeConfig | None
) -> dict[str, Tensor]:
    """Mean and standard deviation of each kind of quantity over the given rows of each run, and no others.

    Returns `KIND_mean` and `KIND_std` for the keys of CHANNELS. A channel that does not vary (the wall's speed, its
    padding) keeps a deviation of 1, so that nothing is divided by zero.
    """
    from sklearn.preprocessing import StandardScaler

    samples: dict[str, list[Tensor]] = {kind: [] for kind in CHANNELS}
    for run, rows in parts:
        edges = edges_at(run, rows, rule)
        nodes, edge_vectors = (run.ball[rows], run.wall[rows]), (edges.pair_vector, edges.wall_vector)
        seen = (*nodes, *edge_vectors, target(run, graph)[rows], run.dissipation[rows])
        for kind, value in zip(CHANNELS, seen, strict=True):
            samples[kind].append(value)
    statistics = {}
    for kind, values in samples.items():
        table = torch.cat([part.reshape(-1, CHANNELS[kind]) for part in values]).double().numpy()
        # Where no two balls ever touch there are no pairs: their mean is 0 and their deviation 1.
        scaler = StandardScaler().fit(table if len(table) else np.zeros((1, CHANNELS[kind])))
        statistics[f"{kind}_mean"] = torch.from_numpy(scaler.mean_).float()
        statistics[f"{kind}_std"] = torch.from_numpy(scaler.scale_).float()
    return statistics


class NormalisedNetwork(nn.Module):
    """The network with its normalisation: features and targets in physical units outside, normalised inside."""

    def __init__(self, recipe: Recipe, statistics: dict[str, Tensor] | None = None):
        super().__init__()
        self.window = recipe.graph.window
        self.network = SignedDistanceNetwork(recipe.graph.window, recipe.network)
        for kind, channels in CHANNELS.items():
            for name, blank in ((f"{kind}_mean", torch.zeros(channels)), (f"{kind}_std", torch.ones(channels))):
                self.register_buffer(name, statistics[name] if statistics else blank)

    def normalised(self, values: Tensor, kind: str) -> Tensor:
        """Values less their mean, over their standard deviation; a window repeats both for each snapshot."""
        mean, deviation = getattr(self, f"{kind}_mean"), getattr(self, f"{kind}_std")
        repeats = values.shape[-1] // len(mean)
        return (values - mean.repeat(repeats)) / deviation.repeat(repeats)

    def normalise(self, graphs: Graphs, velocity_noise: Tensor | None = None) -> Graphs:
        """Normalised features; `velocity_noise` (graphs * balls, window, 3) is added to normalised velocities."""
        ball = self.normalised(graphs.ball, "ball")
        if velocity_noise is not None:
            ball = ball.view(len(ball), -1, BALL_CHANNELS)
            ball[..., VELOCITY] += velocity_noise
            ball = ball.view(len(ball), -1)
        edges = replace(
            graphs.edges,
            pair_vector=self.normalised(graphs.edges.pair_vector, "pair"),
            wall_vector=self.normalised(graphs.edges.wall_vector, "wall_edge"),
        )
        return Graphs(ball, self.normalised(graphs.wall, "wall"), edges, graphs.balls)

    def forward(self, graphs: Graphs) -> tuple[Tensor, Tensor]:
        """Acceleration (graphs, balls, 3) [m/s2] and dissipation of the step (graphs,) [J]."""
        acceleration, dissipation = self.network(self.normalise(graphs))
        acceleration = acceleration * self.acceleration_std + self.acceleration_mean
        dissipation = dissipation * self.dissipation_std + self.dissipation_mean
        return acceleration.view(graphs.count, graphs.balls, 3), dissipation


def write_weights(path: str | Path, model: NormalisedNetwork, recipe: Recipe) -> None:
    """Write finished weights, with the recipe that gives them a shape, readable by `torch.load` with weights_only."""
    state = {name: value.cpu() for name, value in model.state_dict().items()}
    with whole_file(path) as partial:
        partial.write_bytes(_as_bytes({"recipe": recipe.model_dump(mode="json"), "state": state}))


def read_weights(path: str | Path, device: torch.device) -> tuple[NormalisedNetwork, Recipe]:
    """The model with its weights, ready to predict, and its recipe. Raises ConfigError for a damaged file."""
    try:
        content = torch.load(path, map_location=device, weights_only=True)
    except (OSError, ValueError, RuntimeError, EOFError, pickle.UnpicklingError) as error:
        what = str(error).split("\n", 1)[0][:100]
        raise ConfigError(f"{path}: truncated or damaged ({what}); delete it and run the same command again") from None
    recipe = Recipe(**content["recipe"])
    model = NormalisedNetwork(recipe)
    model.load_state_dict(content["state"])
    return model.to(device).eval(), recipe


Batch = tuple[int, Tensor]


def losses(
    predicted: tuple[Tensor, Tensor], targets: tuple[Tensor, Tensor], settings: TrainingConfig
) -> dict[str, Tensor]:
    """Loss of accelerations (Eq. 6.29a), of dissipation (Eq. 6.29b) and their weighted sum `total` (Eq. 6.28).

    Both pairs hold normalised accelerations (n, 3) and normalised dissipation (graphs,). The penalty of Eq. 6.30,
    e^2 / (2 delta) below delta and |e| - delta / 2 from there on, is the smooth L1 loss of torch.
    """
    acceleration, dissipation = (
        smooth_l1_loss(*pair, reduction="none", beta=settings.huber_delta).mean()
        for pair in zip(predicted, targets, strict=True)
    )
    total = settings.acceleration_weight * acceleration + settings.dissipation_weight * dissipation
    return {"total": total, "acceleration": acceleration, "dissipation": dissipation}


def draw_epoch(rows: list[Tensor], snapshots: int, batch_size: int, seed: int) -> list[Batch]:
    """Batches of one epoch: `snapshots` rows drawn from all runs without replacement, each batch from one run."""
    generator = torch.Generator().manual_seed(seed)
    sizes = torch.tensor([len(part) for part in rows])
    chosen = torch.randperm(int(sizes.sum()), generator=generator)[:snapshots]
    ends = torch.cumsum(sizes, 0)
    run = torch.searchsorted(ends, chosen, right=True)
    batches = []
    for number, part in enumerate(rows):
        own = part[chosen[run == number] - (ends[number] - sizes[number])]
        batches += [(number, batch) for batch in own.split(batch_size)]
    return [batches[place] for place in torch.randperm(len(batches), generator=generator)]


def check_data(run: TrainingRun, graph: GraphConfig) -> None:
    """Raise TrainingError for the first snapshot of a run with a feature or target that is not a finite number."""
    snapshots, end = run.snapshots, run.validation_end
    read = {"ball": snapshots.ball, "wall": snapshots.wall, "position": snapshots.position}
    read |= {graph.acceleration: target(snapshots, graph), "dissipation": snapshots.dissipation}
    for name, values in read.items():
        finite = torch.isfinite(values[:end]).reshape(end, -1).all(dim=1)
        if not finite.all():
            row = int(torch.argmin(finite.int()))
            raise TrainingError(
                f"surrogate.training: before epoch 1, run {run.case}: {name} of snapshot {row} is not a finite number; "
                "delete its run.h5 and run the same command again"
            )


# What a training counts and adds up.
COUNTED = ("epoch", "cursor", "elapsed_s", "sums", "history")


class Trainer:
    """The training of a graph network.

    Raises ConfigError without a full window of snapshots to train on, and TrainingError for data that are not finite.
    """

    def __init__(self, runs: list[TrainingRun], recipe: Recipe, device: torch.device):
        self.epoch, self.cursor, self.elapsed_s = 0, 0, 0.0
        self.sums: dict[str, float] = {}
        self.history: list[dict] = []
        self.recipe, self.device, self.settings = recipe, device, recipe.training
        window, settings = recipe.graph.window, recipe.training
        self.rows = [run.training_rows(window) for run in runs]
        if not sum(map(len, self.rows)):
            raise ConfigError(f"surrogate.snapshots.train_until_s: no {window} snapshots in a row to train on")
        for run in runs:
            check_data(run, recipe.graph)
        # Statistics never see a row that is not trained on.
        parts = [(run.snapshots, rows) for run, rows in zip(runs, self.rows, strict=True)]
        statistics = feature_statistics(parts, recipe.graph, recipe.edges)
        self.validation = [run.validation_rows(window) for run in runs]
        self.runs = [on_device(run, device) for run in runs]
        torch.manual_seed(settings.seed)
        self.model = NormalisedNetwork(recipe, statistics).to(device)
        self.optimiser = torch.optim.Adam(self.model.parameters(), lr=settings.learning_rate, fused=True)
        self.noise = torch.Generator().manual_seed(settings.seed)
        self.drawn: dict[int, list[Batch]] = {}
        decay = (settings.final_learning_rate / settings.learning_rate) ** (1 / (settings.epochs * len(self.batches())))
        self.scheduler = torch.optim.lr_scheduler.ExponentialLR(self.optimiser, decay)
        self.identity = identity(recipe, [statistics[name].cpu().numpy() for name in sorted(statistics)])

    def batches(self) -> list[Batch]:
        """Batches of the present epoch."""
        if self.epoch not in self.drawn:
            settings = self.settings
            seed = settings.seed + 1_000_003 * self.epoch
            self.drawn = {self.epoch: draw_epoch(self.rows, settings.snapshots_per_epoch, settings.batch_size, seed)}
        return self.drawn[self.epoch]

    def step(self) -> dict[str, Tensor]:
        """One batch, with noise on the velocities."""
        number, rows = self.batches()[self.cursor]
        snapshots = self.runs[number].snapshots
        shape = (len(rows) * snapshots.ball.shape[1], self.recipe.graph.window, 3)
        noise = self.settings.velocity_noise * torch.randn(shape, generator=self.noise)
        terms, _ = self._losses(snapshots, rows.to(self.device), noise.to(self.device))
        self.optimiser.zero_grad()
        terms["total"].backward()
        self.optimiser.step()
        self.scheduler.step()
        return terms

    def _losses(
        self, snapshots: Snapshots, rows: Tensor, noise: Tensor | None = None
    ) -> tuple[dict[str, Tensor], Tensor]:
        """Losses of a batch, and the mean squared error of its normalised accelerations."""
        graphs = graphs_at(snapshots, rows, self.recipe.graph.window, self.recipe.edges)
        acceleration = target(snapshots, self.recipe.graph)[rows].reshape(-1, 3)
        targets = (
            self.model.normalised(acceleration, "acceleration"),
            self.model.normalised(snapshots.dissipation[rows, None], "dissipation").squeeze(1),
        )
        predicted = self.model.network(self.model.normalise(graphs, noise))
        mean_square = (predicted[0] - targets[0]).square().mean()
        return losses(predicted, targets, self.recipe.training), mean_square

    def validate(self) -> dict[str, float]:
        """The learning rate; losses and mean squared error without noise, on snapshots after those of the training."""
        settings = self.settings
        sums: dict[str, float] = {}
        count = 0
        with torch.inference_mode():
            for number, rows in draw_epoch(self.validation, settings.validation_snapshots, 256, settings.seed):
                terms, mean_square = self._losses(self.runs[number].snapshots, rows.to(self.device))
                for name, value in (terms | {"mean_square": mean_square}).items():
                    sums[name] = sums.get(name, 0.0) + value.item() * len(rows)
                count += len(rows)
        rate = float(self.scheduler.get_last_lr()[0])
        return {"learning_rate": rate} | {f"validation_{name}": value / count for name, value in sums.items()}

    def history_table(self) -> pd.DataFrame:
        """A row an epoch: learning rate, seconds since the start, losses on training and validation snapshots."""
        table = pd.DataFrame(self.history)
        table.insert(1, "learning_rate", table.pop("learning_rate"))
        return table

    def cost(self) -> str:
        """What every epoch will take at the pace of those that are over, in words, and what the limit allows."""
        pace_s, limit_s = self.elapsed_s / self.epoch, self.settings.wall_time_max_s
        allowed = min(self.settings.epochs, int(limit_s / pace_s))
        return (
            f"{pace_s:.3g} s an epoch on {self.device.type}: {self.settings.epochs} epochs take "
            f"{pace_s * self.settings.epochs / 3600:.3g} h; training.wall_time_max_s = {limit_s:g} allows {allowed}"
        )

    @property
    def finished(self) -> bool:
        """Whether every epoch is over."""
        return self.epoch >= self.settings.epochs

    def train(self, checkpoint: str | Path | None = None, max_steps: int | None = None) -> bool:
        """Train until it is finished, the wall-time limit or `max_steps` more steps; True if it is finished.

        With a path, a checkpoint is written every `checkpoint_every_s` and at the end. Raises TrainingError at the
        first loss that is not finite.
        """
        settings, total = self.settings, len(self.batches())
        started = saved = time.perf_counter()
        started -= self.elapsed_s
        left = math.inf if max_steps is None else max_steps
        done = self.epoch * total + self.cursor
        with progress(settings.epochs * total, None, "step", initial=done) as bar:
            while not self.finished and left and self.elapsed_s < settings.wall_time_max_s:
                run = self.runs[self.batches()[self.cursor][0]]
                terms = {name: value.item() for name, value in self.step().items()}
                self.check_finite(terms, f"step {self.cursor + 1}, run {run.case}")
                for name, value in terms.items():
                    self.sums[name] = self.sums.get(name, 0.0) + value
                self.cursor, left = self.cursor + 1, left - 1
                self.elapsed_s = time.perf_counter() - started
                bar.update()
                if self.cursor == len(self.batches()):
                    self.end_epoch()
                    if self.epoch == 1:
                        logger.info("%s", self.cost())
                    bar.set_postfix(refresh=False, training_total=f"{self.history[-1]['training_total']:.4g}")
                    self.elapsed_s = time.perf_counter() - started
                if checkpoint and time.perf_counter() - saved > settings.checkpoint_every_s:
                    self.save(checkpoint)
                    saved = time.perf_counter()
        finished = self.finished
        # An epoch that the wall-time limit has cut short counts.
        if self.cursor and self.elapsed_s >= settings.wall_time_max_s:
            self.end_epoch()
        if checkpoint:
            self.save(checkpoint)
        return finished

    def end_epoch(self) -> None:
        """Validate, add a row to the history, and begin the next epoch."""
        row = {f"training_{name}": value / self.cursor for name, value in self.sums.items()}
        measured = self.validate()
        self.check_finite(measured, "validation")
        self.epoch, self.cursor, self.sums = self.epoch + 1, 0, {}
        row |= measured
        self.history.append({"epoch": self.epoch, "elapsed_s": self.elapsed_s, **row})
        logger.info("epoch %d: %s", self.epoch, ", ".join(f"{key} {value:.4g}" for key, value in row.items()))

    def check_finite(self, values: dict[str, float], where: str) -> None:
        """Raise TrainingError where one of these losses of the present epoch is not finite."""
        for name, value in values.items():
            if not math.isfinite(value):
                raise TrainingError(
                    f"surrogate.training: epoch {self.epoch + 1}, {where}: {name} is {value:g}, not a finite "
                    f"number; learning_rate = {self.settings.learning_rate:g} may be too large"
                )

    def save(self, path: str | Path) -> None:
        """Write everything that the next step needs."""
        content = {name: getattr(self, name) for name in (*COUNTED, "identity")}
        content |= {name: getattr(self, name).state_dict() for name in ("model", "optimiser", "scheduler")}
        payload = _as_bytes(content | {"noise": self.noise.get_state()})
        with whole_file(path) as partial:
            partial.write_bytes(checksum_header(payload) + payload)

    def resume(self, path: str | Path, device: torch.device) -> bool:
        """Go on from the checkpoint at `path`; False if there is none of the same settings and data."""
        content = read_checkpoint(path, self.identity, device)
        if content is None:
            return False
        for name in ("model", "optimiser", "scheduler"):
            getattr(self, name).load_state_dict(content[name])
        for name in COUNTED:
            setattr(self, name, content[name])
        self.noise.set_state(content["noise"].cpu())
        return True


def train(
    dataset: str, checkpoint: Path, recipe: Recipe, device: torch.device
) -> tuple[NormalisedNetwork, pd.DataFrame]:
    """Train a network on a data set, from its checkpoint if there is one of the same recipe and data.

    Returns the network, and a row of losses an epoch. Raises ConfigError and TrainingError as
    `Trainer` and `Trainer.train`.
    """
    trainer = Trainer(read_dataset(dataset), recipe, device)
    if trainer.resume(checkpoint, device):
        logger.info("continuing from epoch %d, step %d of %s", trainer.epoch, trainer.cursor, checkpoint)
    finished = trainer.train(checkpoint)
    logger.info(
        "%s after %d of %d epochs, %.0f s on %s with %d thread(s)",
        "finished" if finished else "stopped by training.wall_time_max_s",
        trainer.epoch,
        recipe.training.epochs,
        trainer.elapsed_s,
        device.type,
        torch.get_num_threads(),
    )
    return trainer.model, trainer.history_table()
