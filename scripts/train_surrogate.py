"""Trains one variant of the surrogate, of any kind; continues from the last checkpoint after a kill."""

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
    with job(snakemake.log[0], f"train the surrogate {snakemake.wildcards.variant}"):
        main(
            snakemake.params.kind,
            snakemake.input.dataset,
            snakemake.output.weights,
            snakemake.output.history,
            snakemake.params.settings,
            threads=snakemake.threads,
        )
