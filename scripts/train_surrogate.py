"""Trains a variant of the surrogate; continues from the last checkpoint after a kill.

Settings: graph, network and training of the variant in surrogate.
Inputs: `dataset`: features and targets.
Outputs: `weights` and `history`.
"""

from pathlib import Path

from millprint.config.surrogate import Recipe
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.surrogate.device import choose_device
from millprint.thesis.surrogate.network import write_weights
from millprint.thesis.surrogate.training import train

if "snakemake" in globals():
    made, recipe = snakemake.output, Recipe(**snakemake.params.recipe)
    with job(snakemake.log[0], f"train {snakemake.wildcards.variant}"):
        # Not an output of the rule, because Snakemake removes the outputs of a killed job.
        checkpoint = Path(made.weights).with_suffix(".checkpoint.pt")
        model, losses = train(snakemake.input.dataset, checkpoint, recipe, choose_device(snakemake.threads))
        write_table(losses, made.history)
        write_weights(made.weights, model, recipe)
        for finished in checkpoint.parent.glob(f"{checkpoint.stem}*.pt"):
            finished.unlink()
