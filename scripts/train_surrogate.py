"""Trains one variant of the surrogate, and goes on from its last checkpoint if it was killed."""

import logging
from pathlib import Path

from millprint.config.surrogate import Recipe
from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.device import choose_device
from millprint.surrogate.thesis.dataset import read_dataset
from millprint.surrogate.thesis.store import write_weights
from millprint.surrogate.thesis.training import Trainer

logger = logging.getLogger("millprint")


def main(dataset: str, weights: str, history: str, recipe: Recipe, threads: int) -> None:
    # Beside the outputs and none of them: Snakemake removes the outputs of a job that was killed.
    checkpoint = Path(weights).with_suffix(".checkpoint.pt")
    device = choose_device(threads)
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
        threads,
    )
    write_table(trainer.history_table(), history)
    write_weights(weights, trainer.model, recipe)
    checkpoint.unlink(missing_ok=True)


if "snakemake" in globals():
    with job(snakemake.log[0], f"train the surrogate {snakemake.wildcards.variant}"):
        main(
            snakemake.input.dataset,
            snakemake.output.weights,
            snakemake.output.history,
            Recipe(**snakemake.params.settings),
            threads=snakemake.threads,
        )
