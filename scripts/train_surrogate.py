"""Trains variants of the surrogate, of one kind; continues from the last checkpoint after a kill."""

import logging
from pathlib import Path

from millprint.files import write_table
from millprint.job import job
from millprint.surrogate.checkpoint import choose_device, write_tensors
from millprint.surrogate.kinds import kind_of

logger = logging.getLogger("millprint")


def main(kind: str, dataset: str, weights: str, history: str, settings: dict, threads: int) -> None:
    logger.info("%s", kind_of(kind).title)
    # Not an output of the rule, because Snakemake removes the outputs of a killed job.
    checkpoint = Path(weights).with_suffix(".checkpoint.pt")
    content, losses = kind_of(kind).train(dataset, checkpoint, settings, choose_device(threads))
    write_table(losses, history)
    write_tensors(weights, content)
    for finished in checkpoint.parent.glob(f"{checkpoint.stem}*.pt"):
        finished.unlink()


if "snakemake" in globals():
    own, made = snakemake.params, snakemake.output
    with job(snakemake.log[0], f"train {', '.join(own.variants)}"):
        for (variant, settings), weights, history in zip(
            own.variants.items(), made.weights, made.histories, strict=True
        ):
            logger.info("%s", variant)
            main(own.kind, snakemake.input.dataset, weights, history, settings, threads=snakemake.threads)
