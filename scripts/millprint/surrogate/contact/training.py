"""Training of one network of the ensemble: on states of the DEM, later also on states that it has reached itself."""

import logging
from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from millprint.config.contact_surrogate import ContactTrainingConfig, PredictorConfig
from millprint.surrogate.contact import samples as columns
from millprint.surrogate.contact.dataset import Samples
from millprint.surrogate.contact.network import Graph, Predictor, targets
from millprint.surrogate.contact.scratch import Weights, make_weights
from millprint.surrogate.training import ResumableTraining

logger = logging.getLogger("millprint")

# Balls of one state are numbered from a multiple of this.
STRIDE = 4096
# Weight of the absolute error beside its square, and where it turns into a square, in units of the contact: so the
# small forces of resting balls count beside those of impacts.
ABSOLUTE, ROUNDED = 0.05, 0.01
# Weight of the rounds before the last.
EARLIER = 0.3


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


class ContactTrainer(ResumableTraining):
    """One member. A step depends only on the seed and its number, so that a killed training can continue."""

    headline = "roll_out_score"
    settings: ContactTrainingConfig
    model: Predictor

    def __init__(
        self, parts: list[Samples], network: PredictorConfig, settings: ContactTrainingConfig,
        roll_out_errors: Callable[[Weights], dict[str, float]], push_forward: Callable[[Weights], Samples],
        identity: str, device: torch.device,
    ):  # fmt: skip
        super().__init__()
        self.settings, self.roll_out_errors, self.push_forward = settings, roll_out_errors, push_forward
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
        self.best = {"score": float("inf"), "epoch": 0}
        self.best_model = {name: value.clone() for name, value in self.model.state_dict().items()}

    def _states(self, part: Samples) -> list[Tensor]:
        rows = torch.from_numpy(part.rows).to(self.device)
        return [state for state in rows.split(part.sizes.tolist()) if len(state)]

    @property
    def finished(self) -> bool:
        """Whether all epochs are done, or no roll-out has been better for `patience` epochs."""
        settled = self.epoch > self.settings.push_forward_after + self.settings.patience
        stale = settled and self.epoch - self.best["epoch"] > self.settings.patience
        return self.epoch >= self.settings.epochs or stale

    def epoch_steps(self) -> int:
        """Steps of every epoch."""
        return self.settings.steps_per_epoch

    def step(self) -> dict[str, Tensor]:
        """One batch of states, at a learning rate that falls exponentially."""
        settings = self.settings
        number, total = self.epoch * settings.steps_per_epoch + self.cursor, settings.epochs * settings.steps_per_epoch
        if number == settings.push_forward_after * settings.steps_per_epoch:
            self._add_own(self.push_forward(self.weights()))
        rate = settings.learning_rate * (settings.final_learning_rate / settings.learning_rate) ** (number / total)
        for group in self.optimiser.param_groups:
            group["lr"] = rate
        chosen = np.random.default_rng([settings.seed, number]).integers(len(self.states), size=settings.batch_size)
        rows, graph = batch_of([self.states[place] for place in chosen])
        terms = loss_of(rows, graph, self.model(graph))
        self.optimiser.zero_grad()
        terms["total"].backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimiser.step()
        return terms

    def _add_own(self, own: Samples) -> None:
        self.own = own
        self.states = self.states + self._states(own)
        logger.info("%d states that the surrogate has reached itself join the training", len(own.sizes))

    def validate(self) -> dict[str, float]:
        """Losses on states that were held out, and errors of roll-outs; the best network so far is kept."""
        with torch.no_grad():
            rows, graph = batch_of(self.validation[:512])
            found = loss_of(rows, graph, self.model(graph))
        row = {f"validation_{name}": value.item() for name, value in found.items()}
        row |= self.roll_out_errors(self.weights())
        if row["roll_out_score"] < self.best["score"]:
            self.best = {"score": row["roll_out_score"], "epoch": self.epoch}
            self.best_model = {name: value.clone() for name, value in self.model.state_dict().items()}
        return row

    def weights(self) -> Weights:
        """The present network as the kernels take it."""
        return make_weights(self.model.arrays())

    def further_state(self) -> dict:
        """The best network so far, and the states that the surrogate has reached itself."""
        own = {} if self.own is None else {"rows": torch.from_numpy(self.own.rows), "sizes": self.own.sizes.tolist()}
        return {"best": self.best, "best_model": self.best_model, "own": own}

    def restore(self, content: dict) -> None:
        """Take over the best network so far, and the states that the surrogate has reached itself."""
        self.best, self.best_model = content["best"], content["best_model"]
        if content["own"]:
            self._add_own(Samples(content["own"]["rows"].cpu().numpy(), np.array(content["own"]["sizes"])))
