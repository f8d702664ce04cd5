"""Training of one network of the ensemble: on states of the DEM, then also on states that it reaches itself."""

import logging
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from millprint.config.contact_surrogate import ContactTrainingConfig, PredictorConfig
from millprint.job import progress
from millprint.surrogate.checkpoint import write_checkpoint
from millprint.surrogate.contact import samples as columns
from millprint.surrogate.contact.dataset import Samples
from millprint.surrogate.contact.network import Graph, Predictor, targets
from millprint.surrogate.contact.scratch import Weights, make_weights

logger = logging.getLogger("millprint")

# Balls of one state are numbered from a multiple of this.
STRIDE = 4096
# Weight of the absolute error beside its square, and where it turns into a square, in units of the contact: small
# forces of balls that lie count beside those of impacts.
ABSOLUTE, ROUNDED = 0.05, 0.01
# Weight of the rounds before the last.
EARLIER = 0.3

Validate = Callable[[Weights], dict[str, float]]
PushForward = Callable[[Weights], Samples]


def batch_of(parts: list[Tensor]) -> tuple[Tensor, Graph]:
    """Contacts of several states as one graph."""
    rows = torch.cat(parts)
    number = torch.repeat_interleave(torch.arange(len(parts)), torch.tensor([len(part) for part in parts]))
    offset = STRIDE * number.to(rows.device)
    first, second = rows[:, columns.FIRST].long(), rows[:, columns.SECOND].long()
    graph = Graph(rows, first + offset, torch.where(second < 0, -1, second + offset), STRIDE * len(parts))
    return rows, graph


def loss_of(rows: Tensor, graph: Graph, predicted: list[tuple[Tensor, Tensor]]) -> dict[str, Tensor]:
    """Errors of the mean force and its tilt, squared and absolute, in units of each contact; `total` is minimised."""
    mean, tilt = targets(rows, graph)
    total = rows.new_zeros(())
    for number, (expected, tilted) in enumerate(predicted):
        squares = ((expected - mean) ** 2).sum(1) + 0.25 * ((tilted - tilt) ** 2).sum(1)
        absolute = torch.sqrt(squares + ROUNDED**2) - ROUNDED
        last = number == len(predicted) - 1
        total = total + (1.0 if last else EARLIER) * (squares + ABSOLUTE * absolute).mean()
    return {
        "total": total,
        "mean_force": ((predicted[-1][0] - mean) ** 2).sum(1).mean(),
        "tilt": ((predicted[-1][1] - tilt) ** 2).sum(1).mean(),
    }


class ContactTrainer:
    """One member. What a step does depends on the seed and its number alone, so that a killed training goes on."""

    def __init__(
        self, parts: list[Samples], network: PredictorConfig, settings: ContactTrainingConfig,
        validate: Validate, push_forward: PushForward, identity: str, device: torch.device,
    ):  # fmt: skip
        self.settings, self.validate, self.push_forward = settings, validate, push_forward
        self.identity, self.device, seed = identity, device, settings.seed
        states = [state for part in parts for state in self._states(part)]
        order = np.random.default_rng(seed).permutation(len(states))
        held_out = max(1, len(states) // 20)
        self.validation = [states[place] for place in order[:held_out]]
        self.states = [states[place] for place in order[held_out:]]
        self.own: Samples | None = None
        torch.manual_seed(seed)
        self.model = Predictor(network.width, network.rounds).to(device)
        self.optimiser = torch.optim.Adam(self.model.parameters(), lr=settings.learning_rate)
        self.step, self.elapsed_s = 0, 0.0
        self.sums: dict[str, float] = {}
        self.history: list[dict] = []
        self.best = {"score": float("inf"), "epoch": 0}
        self.best_model = {name: value.clone() for name, value in self.model.state_dict().items()}

    def _states(self, part: Samples) -> list[Tensor]:
        rows = torch.from_numpy(part.rows).to(self.device)
        return [state for state in rows.split(part.sizes.tolist()) if len(state)]

    @property
    def epoch(self) -> int:
        """How many epochs are over."""
        return self.step // self.settings.steps_per_epoch

    @property
    def finished(self) -> bool:
        """Whether every epoch is done, or no roll-out has become better for long."""
        settled = self.epoch > self.settings.push_forward_after + self.settings.patience
        stale = settled and self.epoch - self.best["epoch"] > self.settings.patience
        return self.epoch >= self.settings.epochs or stale

    def train(self, checkpoint: str | Path | None = None, max_steps: int | None = None) -> bool:
        """Train until it is finished, the wall-time limit or `max_steps` more steps; True if it is finished."""
        settings = self.settings
        started, saved, done_s = time.perf_counter(), time.perf_counter(), self.elapsed_s
        last = self.step + max_steps if max_steps is not None else np.inf
        with progress(settings.epochs * settings.steps_per_epoch, "train", "step", initial=self.step) as bar:
            while not self.finished and self.step < last and self.elapsed_s < settings.wall_time_max_s:
                self._step()
                bar.update()
                if self.step % settings.steps_per_epoch == 0:
                    self._end_epoch(done_s + time.perf_counter() - started)
                    bar.set_postfix(refresh=False, roll_out=f"{self.best['score']:.3g} %")
                self.elapsed_s = done_s + time.perf_counter() - started
                if checkpoint and time.perf_counter() - saved > settings.checkpoint_every_s:
                    self.save(checkpoint)
                    saved = time.perf_counter()
        if checkpoint:
            self.save(checkpoint)
        return self.finished

    def _step(self) -> None:
        settings = self.settings
        total = settings.epochs * settings.steps_per_epoch
        if self.step == settings.push_forward_after * settings.steps_per_epoch:
            self._add_own(self.push_forward(self.weights()))
        rate = settings.learning_rate * (settings.final_learning_rate / settings.learning_rate) ** (self.step / total)
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        chosen = np.random.default_rng([settings.seed, self.step]).integers(len(self.states), size=settings.batch_size)
        rows, graph = batch_of([self.states[place] for place in chosen])
        terms = loss_of(rows, graph, self.model(graph))
        self.optimiser.zero_grad()
        terms["total"].backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimiser.step()
        for name, value in terms.items():
            self.sums[name] = self.sums.get(name, 0.0) + value.item()
        self.step += 1

    def _add_own(self, own: Samples) -> None:
        self.own = own
        self.states = self.states + self._states(own)
        logger.info("%d states that the surrogate has reached itself join the training", len(own.sizes))

    def _end_epoch(self, elapsed_s: float) -> None:
        """Validation and a roll-out; the best network so far is kept."""
        with torch.no_grad():
            rows, graph = batch_of(self.validation[:512])
            found = loss_of(rows, graph, self.model(graph))
        row = {f"training_{name}": value / self.settings.steps_per_epoch for name, value in self.sums.items()}
        row |= {f"validation_{name}": value.item() for name, value in found.items()}
        row |= self.validate(self.weights())
        self.sums = {}
        self.history.append({"epoch": self.epoch, "elapsed_s": elapsed_s, **row})
        if row["roll_out_score"] < self.best["score"]:
            self.best = {"score": row["roll_out_score"], "epoch": self.epoch}
            self.best_model = {name: value.clone() for name, value in self.model.state_dict().items()}
        logger.info("epoch %d: %s", self.epoch, ", ".join(f"{key} {value:.4g}" for key, value in row.items()))

    def weights(self) -> Weights:
        """The present network as the kernels take it."""
        return make_weights(self.model.arrays())

    def history_table(self) -> pd.DataFrame:
        """A row an epoch: losses, roll-outs and seconds since the start."""
        return pd.DataFrame(self.history)

    def save(self, path: str | Path) -> None:
        """Write everything that the next step depends on."""
        own = {} if self.own is None else {"rows": torch.from_numpy(self.own.rows), "sizes": self.own.sizes.tolist()}
        content = {
            "identity": self.identity, "model": self.model.state_dict(), "optimiser": self.optimiser.state_dict(),
            "step": self.step, "elapsed_s": self.elapsed_s, "sums": self.sums, "history": self.history,
            "best": self.best, "best_model": self.best_model, "own": own,
        }  # fmt: skip
        write_checkpoint(path, content)

    def resume(self, content: dict) -> None:
        """Go on from what `save` wrote."""
        self.model.load_state_dict(content["model"])
        self.optimiser.load_state_dict(content["optimiser"])
        self.step, self.elapsed_s = content["step"], content["elapsed_s"]
        self.sums, self.history = content["sums"], content["history"]
        self.best, self.best_model = content["best"], content["best_model"]
        if content["own"]:
            self._add_own(Samples(content["own"]["rows"].cpu().numpy(), np.array(content["own"]["sizes"])))
