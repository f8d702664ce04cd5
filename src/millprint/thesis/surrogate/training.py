"""Training of the network (thesis Sec. 6.2.2); stopped after any step, it continues exactly as without the stop."""

import hashlib
import io
import json
import logging
import math
import pickle
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from scipy.constants import hour as HOUR
from torch import Tensor
from torch.nn.functional import smooth_l1_loss

from millprint.config.errors import ConfigError, TrainingError
from millprint.config.section import Section
from millprint.config.surrogate import GraphConfig, Recipe, TrainingConfig
from millprint.run.files import checksum_header, read_checksummed, whole_file
from millprint.run.job import progress
from millprint.thesis.surrogate.dataset import (
    Snapshots,
    TrainingRun,
    graphs_at,
    on_device,
    read_dataset,
)
from millprint.thesis.surrogate.network import NormalisedNetwork, as_bytes, feature_statistics, target

logger = logging.getLogger("millprint")

BUDGET = {"wall_time_max_s", "checkpoint_every_s", "threads"}
Batch = tuple[int, Tensor]


def identity(settings: Section, data: Iterable[np.ndarray]) -> str:
    """A hash of the settings of a training and of its data: only a checkpoint of the same may be resumed.

    How long to train, how often to save and on how many threads is left out: a training may go on with more.
    """
    content = settings.model_dump(mode="json", exclude={"training": BUDGET})
    total = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    for part in data:
        total.update(part.tobytes())
    return total.hexdigest()


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
            f"{pace_s * self.settings.epochs / HOUR:.3g} h; training.wall_time_max_s = {limit_s:g} allows {allowed}"
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
        payload = as_bytes(content | {"noise": self.noise.get_state()})
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
