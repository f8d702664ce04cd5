"""Several networks of one recipe, from different seeds: where they part, none of them knows."""

import hashlib
import logging
from functools import partial
from pathlib import Path

import pandas as pd
import torch

from millprint.config.contact_surrogate import ContactRecipe, ContactSurrogateConfig
from millprint.surrogate.checkpoint import BUDGET, read_checkpoint
from millprint.surrogate.contact.dataset import Samples, Truth
from millprint.surrogate.contact.judge import judged, reached
from millprint.surrogate.contact.scratch import no_weights
from millprint.surrogate.contact.tracer import Tracer
from millprint.surrogate.contact.training import ContactTrainer

logger = logging.getLogger("millprint")


def recipe_of(settings: ContactSurrogateConfig) -> ContactRecipe:
    """What the weights carry with them."""
    return ContactRecipe(
        coarse=settings.coarse, network=settings.network, training=settings.training, members=settings.members
    )


def identity_of(settings: ContactSurrogateConfig, parts: list[Samples], seed: int) -> str:
    """A hash of recipe, data and seed: only a checkpoint of the same may be resumed."""
    total = hashlib.sha256(settings.model_dump_json(exclude={"training": BUDGET, "members": True}).encode())
    total.update(str(seed).encode())
    for part in parts:
        total.update(part.rows.tobytes())
    return total.hexdigest()


def train_ensemble(
    parts: list[Samples],
    truths: list[Truth],
    tracers: list[Tracer],
    settings: ContactSurrogateConfig,
    checkpoint: Path,
    device: torch.device,
) -> tuple[list[dict], pd.DataFrame]:
    """Train every member from its own seed: weights of the best epochs, and the histories under one another.

    Each member has a checkpoint of its own; one that was finished is read and not trained again.
    """
    coarse, judge = tracers[0].coarse, settings.judge
    logger.info("without a network: %s", judged(coarse, no_weights(), truths, judge))
    members, tables = [], []
    for number in range(settings.members):
        seed = settings.training.seed + number
        identity = identity_of(settings, parts, seed)
        trainer = ContactTrainer(
            parts, settings.network, settings.training, seed,
            lambda weights: judged(coarse, weights, truths, judge),
            partial(reached, tracers, settings=settings.training), identity, device,
        )  # fmt: skip
        path = checkpoint.with_suffix(f".{number}.pt")
        if content := read_checkpoint(path, identity, device):
            trainer.resume(content)
            logger.info("member %d goes on from step %d", number, trainer.step)
        finished = trainer.train(path)
        logger.info(
            "member %d: %s after %d epochs, %.0f s; best roll-out %.3g %% in epoch %d", number,
            "finished" if finished else "stopped by training.wall_time_max_s", trainer.epoch, trainer.elapsed_s,
            trainer.best["score"], trainer.best["epoch"],
        )  # fmt: skip
        members.append(trainer.best_model)
        tables.append(trainer.history_table().assign(member=number))
    return members, pd.concat(tables, ignore_index=True)
