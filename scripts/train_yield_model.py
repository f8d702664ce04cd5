"""Tunes and fits one yield model on the training rows."""

from threadpoolctl import threadpool_limits

from millprint.config.yields import SearchConfig, TrainingConfig
from millprint.doe.runs import YIELD
from millprint.job import job, progress
from millprint.predict.store import save_model
from millprint.predict.tables import read_rows
from millprint.predict.training import evaluations_of, train


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
    total = evaluations_of(model, strategy, settings, budget)
    with threadpool_limits(threads), progress(total, f"tuning {model} {strategy}", "set") as bar:
        yields = rows[YIELD].to_numpy(float)
        fitted, found = train(model, strategy, rows, yields, settings, budget, threads, bar.update)
    save_model(fitted, found, rows, settings.choices, settings.seed, model_path)


if "snakemake" in globals():
    with job(snakemake.log[0], f"train yield model {snakemake.wildcards.model} {snakemake.wildcards.strategy}"):
        main(
            snakemake.input.train,
            snakemake.output.model,
            snakemake.wildcards.model,
            snakemake.wildcards.strategy,
            TrainingConfig(**snakemake.params.training),
            SearchConfig(**snakemake.params.search),
            threads=snakemake.threads,
        )
