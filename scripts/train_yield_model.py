"""Tunes and fits a yield model on the training rows.

Settings: yields.training, yields.search; regressor and strategy.
Inputs: `train`: the rows.
Outputs: `model`, as JSON.
"""

from threadpoolctl import threadpool_limits

from millprint.config.yields import SearchConfig, TrainingConfig
from millprint.run.job import job, progress
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.stored_models import save_model
from millprint.thesis.yields.yield_model import Trainer


def main(
    train_path: str,
    model_path: str,
    model: str,
    strategy: str,
    settings: TrainingConfig,
    budget: SearchConfig,
    threads: int = 1,
) -> None:
    """Train only on the rows of `train_path`, and write the model."""
    rows = read_rows(train_path)
    total = Trainer(settings, budget).evaluations(model, strategy)
    with threadpool_limits(threads), progress(total, f"tuning {model} {strategy}", "set") as bar:
        trainer = Trainer(settings, budget, threads, bar.update)
        fitted, results = trainer.train(model, strategy, rows, rows[YIELD].to_numpy(float))
    save_model(fitted, results, rows, settings, model_path)


if "snakemake" in globals():
    own, (name, strategy, settings) = snakemake.params, snakemake.params.trained
    with job(snakemake.log[0], f"train yield model {snakemake.wildcards.trained}"):
        budgets = TrainingConfig(**settings), SearchConfig(**own.search)
        main(snakemake.input.train, snakemake.output.model, name, strategy, *budgets, threads=snakemake.threads)
