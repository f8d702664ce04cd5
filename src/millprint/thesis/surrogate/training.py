"""A training that can be stopped after any step, and continues from its checkpoint exactly as without the stop."""

import logging
import math
import time
from abc import ABC, abstractmethod
from pathlib import Path

import pandas as pd
import torch
from torch import Tensor, nn

from millprint.config.errors import TrainingError
from millprint.config.surrogate import TrainingConfig
from millprint.run.progress import progress
from millprint.thesis.surrogate.checkpoint import read_checkpoint, write_checkpoint

logger = logging.getLogger("millprint")


class ResumableTraining(ABC):
    """Steps and epochs around a model. Subclasses take a step and validate, and say what else a step depends on."""

    settings: TrainingConfig
    identity: str
    model: nn.Module
    optimiser: torch.optim.Optimizer
    # Column of the history that the progress bar shows.
    headline: str

    def __init__(self) -> None:
        self.epoch, self.cursor, self.elapsed_s = 0, 0, 0.0
        self.sums: dict[str, float] = {}
        self.history: list[dict] = []

    @property
    def finished(self) -> bool:
        """Whether every epoch is over."""
        return self.epoch >= self.settings.epochs

    @abstractmethod
    def epoch_steps(self) -> int:
        """Steps of the present epoch."""

    @abstractmethod
    def step(self) -> dict[str, Tensor]:
        """Step `cursor` of the present epoch; returns the terms of its loss."""

    @abstractmethod
    def validate(self) -> dict[str, float]:
        """Columns of the history, at the end of an epoch."""

    @abstractmethod
    def subject(self) -> str:
        """What the present step is about, in words for an error."""

    @abstractmethod
    def further_state(self) -> dict:
        """What the next step depends on besides the model, its optimiser and the place in the epoch."""

    @abstractmethod
    def restore(self, content: dict) -> None:
        """Take over what `further_state` returned."""

    def train(self, checkpoint: str | Path | None = None, max_steps: int | None = None) -> bool:
        """Train until it is finished, the wall-time limit or `max_steps` more steps; True if it is finished.

        With a path, a checkpoint is written every `checkpoint_every_s` and at the end. Raises TrainingError at the
        first loss that is not finite.
        """
        settings, total = self.settings, self.epoch_steps()
        started = saved = time.perf_counter()
        started -= self.elapsed_s
        left = math.inf if max_steps is None else max_steps
        done = self.epoch * total + self.cursor
        with progress(settings.epochs * total, None, "step", initial=done) as bar:
            while not self.finished and left and self.elapsed_s < settings.wall_time_max_s:
                terms = {name: value.item() for name, value in self.step().items()}
                self.check_finite(terms, f"step {self.cursor + 1}, {self.subject()}")
                for name, value in terms.items():
                    self.sums[name] = self.sums.get(name, 0.0) + value
                self.cursor, left = self.cursor + 1, left - 1
                self.elapsed_s = time.perf_counter() - started
                bar.update()
                if self.cursor == self.epoch_steps():
                    self.end_epoch()
                    bar.set_postfix(refresh=False, **{self.headline: f"{self.history[-1][self.headline]:.4g}"})
                    self.elapsed_s = time.perf_counter() - started
                if checkpoint and time.perf_counter() - saved > settings.checkpoint_every_s:
                    self.save(checkpoint)
                    saved = time.perf_counter()
        finished = self.finished
        self.stop()
        if checkpoint:
            self.save(checkpoint)
        return finished

    def stop(self) -> None:  # noqa: B027
        """What is left to do where the training stops: nothing, unless a subclass says so."""

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

    def history_table(self) -> pd.DataFrame:
        """A row an epoch: losses on training and validation data, and seconds since the start."""
        return pd.DataFrame(self.history)

    def save(self, path: str | Path) -> None:
        """Write everything that the next step needs."""
        names = ("epoch", "cursor", "elapsed_s", "sums", "history", "identity")
        states = {"model": self.model.state_dict(), "optimiser": self.optimiser.state_dict()}
        write_checkpoint(path, {name: getattr(self, name) for name in names} | states | self.further_state())

    def resume(self, path: str | Path, device: torch.device) -> bool:
        """Go on from the checkpoint at `path`; False if there is none of the same settings and data."""
        content = read_checkpoint(path, self.identity, device)
        if content is None:
            return False
        self.model.load_state_dict(content["model"])
        self.optimiser.load_state_dict(content["optimiser"])
        for name in ("epoch", "cursor", "elapsed_s", "sums", "history"):
            setattr(self, name, content[name])
        self.restore(content)
        return True
