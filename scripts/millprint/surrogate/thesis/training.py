"""Training of the network on snapshots of simulations (thesis Sec. 6.2.2)."""

import logging
import time
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor

from millprint.config.surrogate import Recipe, TrainingConfig
from millprint.errors import ConfigError
from millprint.job import progress
from millprint.surrogate.checkpoint import identity, read_checkpoint, write_checkpoint
from millprint.surrogate.thesis.dataset import Snapshots, TrainingRun, on_device, read_dataset
from millprint.surrogate.thesis.graphs import graphs_at
from millprint.surrogate.thesis.network import NormalisedNetwork, feature_statistics, target, weights_content

logger = logging.getLogger("millprint")

Batch = tuple[int, Tensor]


def huber(error: Tensor, delta: float) -> Tensor:
    """Huber penalty, Eq. 6.30: e^2 / (2 delta) below delta, |e| - delta / 2 from there on. Elementwise."""
    size = error.abs()
    return torch.where(size < delta, error * error / (2 * delta), size - delta / 2)


def losses(
    predicted: tuple[Tensor, Tensor], targets: tuple[Tensor, Tensor], settings: TrainingConfig
) -> dict[str, Tensor]:
    """Loss of accelerations (Eq. 6.29a), of dissipation (Eq. 6.29b) and their weighted sum `total` (Eq. 6.28).

    Both pairs hold normalised accelerations (n, 3) and normalised dissipation (graphs,).
    """
    acceleration = huber(predicted[0] - targets[0], settings.huber_delta).mean()
    dissipation = huber(predicted[1] - targets[1], settings.huber_delta).mean()
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


class Trainer:
    """One training, which can be stopped after any step and go on as if it had not been."""

    def __init__(self, runs: list[TrainingRun], recipe: Recipe, device: torch.device):
        self.recipe, self.device = recipe, device
        window, settings = recipe.graph.window, recipe.training
        self.rows = [run.training_rows(window) for run in runs]
        if not sum(map(len, self.rows)):
            raise ConfigError(f"surrogate.snapshots.train_until_s: no {window} snapshots in a row to train on")
        # Statistics never see a row that is not trained on.
        parts = [(run.snapshots, rows) for run, rows in zip(runs, self.rows, strict=True)]
        statistics = feature_statistics(parts, recipe.graph, recipe.edges)
        self.validation = [run.validation_rows(window) for run in runs]
        self.runs = [on_device(run, device) for run in runs]
        torch.manual_seed(settings.seed)
        self.model = NormalisedNetwork(recipe, statistics).to(device)
        self.optimiser = torch.optim.Adam(self.model.parameters(), lr=settings.learning_rate, fused=True)
        self.noise = torch.Generator().manual_seed(settings.seed)
        steps = settings.epochs * len(self._batches(0))
        decay = (settings.final_learning_rate / settings.learning_rate) ** (1 / steps)
        self.scheduler = torch.optim.lr_scheduler.ExponentialLR(self.optimiser, decay)
        self.steps = steps
        self.identity = identity(recipe, [statistics[name].cpu().numpy() for name in sorted(statistics)])
        self.epoch, self.cursor, self.elapsed_s = 0, 0, 0.0
        self.sums: dict[str, float] = {}
        self.history: list[dict] = []

    def _batches(self, epoch: int) -> list[Batch]:
        settings = self.recipe.training
        seed = settings.seed + 1_000_003 * epoch
        return draw_epoch(self.rows, settings.snapshots_per_epoch, settings.batch_size, seed)

    def train(self, checkpoint: str | Path | None = None, max_steps: int | None = None) -> bool:
        """Train until the last epoch, the wall-time limit or `max_steps` more steps; True if every epoch was done.

        With a path, a checkpoint is written every `checkpoint_every_s` and at the end.
        """
        settings = self.recipe.training
        started, saved, done_s = time.perf_counter(), time.perf_counter(), self.elapsed_s
        done = self.epoch * len(self._batches(0)) + self.cursor
        left = max_steps if max_steps is not None else self.steps
        with progress(self.steps, "train", "step", initial=done) as bar:
            while self.epoch < settings.epochs and left and self.elapsed_s < settings.wall_time_max_s:
                batches = self._batches(self.epoch)
                while self.cursor < len(batches) and left and self.elapsed_s < settings.wall_time_max_s:
                    self._step(*batches[self.cursor])
                    self.cursor, left = self.cursor + 1, left - 1
                    self.elapsed_s = done_s + time.perf_counter() - started
                    bar.update()
                    if checkpoint and time.perf_counter() - saved > settings.checkpoint_every_s:
                        self.save(checkpoint)
                        saved = time.perf_counter()
                if self.cursor == len(batches):
                    self._end_epoch(len(batches))
                    bar.set_postfix(refresh=False, loss=f"{self.history[-1]['training_total']:.4f}")
        finished = self.epoch == settings.epochs
        if self.cursor and self.elapsed_s >= settings.wall_time_max_s:
            self._end_epoch(self.cursor)
        if checkpoint:
            self.save(checkpoint)
        return finished

    def _step(self, number: int, rows: Tensor) -> None:
        snapshots = self.runs[number].snapshots
        shape = (len(rows) * snapshots.ball.shape[1], self.recipe.graph.window, 3)
        noise = self.recipe.training.velocity_noise * torch.randn(shape, generator=self.noise)
        terms, _ = self._losses(snapshots, rows.to(self.device), noise.to(self.device))
        self.optimiser.zero_grad()
        terms["total"].backward()
        self.optimiser.step()
        self.scheduler.step()
        for name, value in terms.items():
            self.sums[name] = self.sums.get(name, 0.0) + value.item()

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

    def _end_epoch(self, batches: int) -> None:
        row = {f"training_{name}": value / batches for name, value in self.sums.items()}
        row |= {f"validation_{name}": value for name, value in self._validate().items()}
        rate = self.scheduler.get_last_lr()[0]
        self.epoch, self.cursor, self.sums = self.epoch + 1, 0, {}
        self.history.append({"epoch": self.epoch, "learning_rate": rate, "seconds": self.elapsed_s, **row})
        logger.info("epoch %d: %s", self.epoch, ", ".join(f"{key} {value:.4g}" for key, value in row.items()))

    def _validate(self) -> dict[str, float]:
        """Losses without noise, and the mean squared error, on snapshots after those of the training."""
        settings = self.recipe.training
        sums: dict[str, float] = {}
        count = 0
        with torch.inference_mode():
            for number, rows in draw_epoch(self.validation, settings.validation_snapshots, 256, settings.seed):
                terms, mean_square = self._losses(self.runs[number].snapshots, rows.to(self.device))
                for name, value in (terms | {"mean_square": mean_square}).items():
                    sums[name] = sums.get(name, 0.0) + value.item() * len(rows)
                count += len(rows)
        return {name: value / count for name, value in sums.items()}

    def history_table(self) -> pd.DataFrame:
        """A row an epoch: losses on training and validation snapshots, learning rate, seconds since the start."""
        return pd.DataFrame(self.history).rename(columns={"seconds": "elapsed_s"})

    def save(self, path: str | Path) -> None:
        """Write everything that the next step depends on."""
        write_checkpoint(
            path,
            {
                "identity": self.identity,
                "model": self.model.state_dict(),
                "optimiser": self.optimiser.state_dict(),
                "scheduler": self.scheduler.state_dict(),
                "noise": self.noise.get_state(),
                "place": {"epoch": self.epoch, "cursor": self.cursor, "elapsed_s": self.elapsed_s},
                "sums": self.sums,
                "history": self.history,
            },
        )

    def resume(self, path: str | Path) -> bool:
        """Go on from the checkpoint at `path`; False if there is none of the same recipe and data."""
        content = read_checkpoint(path, self.identity, self.device)
        if content is None:
            return False
        self.model.load_state_dict(content["model"])
        self.optimiser.load_state_dict(content["optimiser"])
        self.scheduler.load_state_dict(content["scheduler"])
        self.noise.set_state(content["noise"].cpu())
        self.epoch, self.cursor = content["place"]["epoch"], content["place"]["cursor"]
        self.elapsed_s, self.sums, self.history = content["place"]["elapsed_s"], content["sums"], content["history"]
        return True


def train(dataset: str, checkpoint: Path, recipe: Recipe, device: torch.device) -> tuple[dict, pd.DataFrame]:
    """Train a network on a data set, from its checkpoint if there is one of the same recipe and data.

    Returns the content of the weights file, and a row of losses an epoch. Raises ConfigError without a full window of
    snapshots to train on.
    """
    trainer = Trainer(read_dataset(dataset), recipe, device)
    if trainer.resume(checkpoint):
        logger.info("going on from epoch %d, step %d of %s", trainer.epoch, trainer.cursor, checkpoint)
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
    return weights_content(trainer.model, recipe), trainer.history_table()
