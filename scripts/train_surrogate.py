"""Trains variants of the surrogate; continues from the last checkpoint after a kill."""

import logging
from pathlib import Path

from millprint.config.surrogate import Recipe
from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.checkpoint import choose_device, write_tensors
from millprint.surrogate.thesis.training import train

logger = logging.getLogger("millprint")


def main(dataset: str, weights: str, history: str, recipe: Recipe, threads: int) -> None:
    # Not an output of the rule, because Snakemake removes the outputs of a killed job.
    checkpoint = Path(weights).with_suffix(".checkpoint.pt")
    content, losses = train(dataset, checkpoint, recipe, choose_device(threads))
    write_table(losses, history)
    write_tensors(weights, content)
    for finished in checkpoint.parent.glob(f"{checkpoint.stem}*.pt"):
        finished.unlink()


if "snakemake" in globals():
    own, made = snakemake.params, snakemake.output
    with job(snakemake.log[0], f"train {', '.join(own.variants)}"):
        for (variant, recipe), weights, history in zip(own.variants.items(), made.weights, made.histories, strict=True):
            logger.info("%s", variant)
            main(snakemake.input.dataset, weights, history, Recipe(**recipe), threads=snakemake.threads)
