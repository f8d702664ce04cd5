"""Networks of one recipe with different seeds. Where their predictions differ, none of them is reliable."""

import logging
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import torch

from millprint.config.contact_surrogate import (
    ContactRecipe,
    ContactSurrogateConfig,
    ContactTrainingConfig,
    ValidationConfig,
)
from millprint.config.section import Section
from millprint.dem.layout import TOTAL_WIDTH
from millprint.dem.recording import all_works
from millprint.surrogate.checkpoint import identity, read_tensors
from millprint.surrogate.contact.coarse import CoarseSimulation
from millprint.surrogate.contact.dataset import CHANNELS, Samples, TracedModels, Truth, open_tracer, read_dataset
from millprint.surrogate.contact.network import Predictor
from millprint.surrogate.contact.scratch import Weights, make_weights, no_weights
from millprint.surrogate.contact.tracer import Tracer
from millprint.surrogate.contact.training import ContactTrainer

logger = logging.getLogger("millprint")

# Error assigned to a roll-out that has lost a ball [%].
LOST_PERCENT = 1e6


class ContactTrainingJob(Section):
    """Input for the training of an ensemble: its settings, and the models of its traces."""

    settings: ContactSurrogateConfig
    models: TracedModels


def dissipated_works(coarse: CoarseSimulation) -> np.ndarray:
    """Normal and tangential work of a coarse simulation since its state was loaded, (2,) [J]."""
    out = np.zeros(TOTAL_WIDTH)
    all_works(coarse.contacts, coarse.counters, coarse.totals, out)
    return out[CHANNELS]


def roll_out_errors(
    coarse: CoarseSimulation, weights: Weights, truths: list[Truth], settings: ValidationConfig
) -> dict[str, float]:
    """Roll-outs against the DEM: errors of the normal and tangential works and of the positions after a while [%].

    The works are summed over all roll-outs and their absolute errors over the channels, relative to both channels
    together; the position's root mean square error is relative to the ball's radius. roll_out_score is their sum.
    """
    coarse.weights = weights
    works, true_works, squares = np.zeros(2), np.zeros(2), []
    first_steps = round(settings.position_s / coarse.step)
    for truth in truths:
        coarse.load(truth.begin)
        kept_all = coarse.run(first_steps)
        squares.append(((coarse.balls.position - truth.position_m) ** 2).sum(axis=1).mean())
        if not (kept_all and coarse.run(round(settings.length_s / coarse.step) - first_steps)):
            names = ("score", "dissipation_percent", "position_percent")
            return {f"roll_out_{name}": LOST_PERCENT for name in names}
        works += dissipated_works(coarse)
        true_works += truth.works_J
    dissipation = 100 * np.abs(works - true_works).sum() / true_works.sum()
    position = 100 * np.sqrt(np.mean(squares)) / coarse.radius
    return {
        "roll_out_score": float(dissipation + position),
        "roll_out_dissipation_percent": float(dissipation),
        "roll_out_position_percent": float(position),
    }


def reached_states(tracers: list[Tracer], weights: Weights, settings: ContactTrainingConfig) -> Samples:
    """Samples of states that the network reaches in every traced case, an equal share of each."""
    share = max(1, settings.push_forward_states // len(tracers))
    steps = settings.push_forward_steps
    return Samples.joined([tracer.push_forward(weights, steps, steps, share) for tracer in tracers])


def train(dataset: str, checkpoint: Path, job: ContactTrainingJob, device: torch.device) -> tuple[dict, pd.DataFrame]:
    """Train every member of an ensemble from its own seed, on a data set.

    Returns the content of the weights file, with the best epochs, and a row of losses an epoch and member. Each member
    has a checkpoint of its own; one that was finished is read and not trained again.
    """
    settings = job.settings
    parts, truths = read_dataset(dataset)
    tracers = [open_tracer(trace, job.models, settings.coarse, settings.judge.position_s) for trace in settings.traces]
    validate = partial(roll_out_errors, tracers[0].coarse, truths=truths, settings=settings.judge)
    logger.info("without a network: %s", validate(no_weights()))
    members, tables = [], []
    for number in range(settings.members):
        training = settings.training.model_copy(update={"seed": settings.training.seed + number})
        own = identity(settings.model_copy(update={"training": training, "members": 1}), [part.rows for part in parts])
        reach = partial(reached_states, tracers, settings=training)
        trainer = ContactTrainer(parts, settings.network, training, validate, reach, own, device)
        path = checkpoint.with_suffix(f".{number}.pt")
        if trainer.resume(path, device):
            logger.info("member %d continues from epoch %d, step %d", number, trainer.epoch, trainer.cursor)
        finished = trainer.train(path)
        logger.info(
            "member %d: %s after %d epochs, %.0f s; best roll-out %.3g %% in epoch %d", number,
            "finished" if finished else "stopped by training.wall_time_max_s", trainer.epoch, trainer.elapsed_s,
            trainer.best["score"], trainer.best["epoch"],
        )  # fmt: skip
        members.append(trainer.best_model)
        tables.append(trainer.history_table().assign(member=number))
    recipe = ContactRecipe(**{name: getattr(settings, name) for name in ContactRecipe.model_fields})
    return ensemble_content(members, recipe), pd.concat(tables, ignore_index=True)


def ensemble_content(members: list[dict], recipe: ContactRecipe) -> dict:
    """Content of a weights file: the weights of every member, with the recipe that gives them a shape."""
    weights = [{name: value.cpu() for name, value in member.items()} for member in members]
    return {"kind": "contact", "recipe": recipe.model_dump(mode="json"), "members": weights}


def read_ensemble(path: str | Path) -> tuple[list[Weights], ContactRecipe]:
    """The members' weights as the kernels take them, and the recipe. Raises ConfigError for a damaged file."""
    content = read_tensors(path)
    recipe = ContactRecipe(**content["recipe"])
    members = []
    for member in content["members"]:
        model = Predictor(recipe.network.width, recipe.network.rounds)
        model.load_state_dict(member)
        members.append(make_weights(model.arrays()))
    return members, recipe
