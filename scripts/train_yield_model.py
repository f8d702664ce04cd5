"""Tunes and fits yield models on the training rows."""

from threadpoolctl import threadpool_limits

from millprint.config.yields import SearchConfig, TrainingConfig
from millprint.doe.runs import YIELD
from millprint.job import job
from millprint.predict.model_files import save_model
from millprint.predict.search import Trainer
from millprint.predict.tables import read_rows
from millprint.progress import progress


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
    chosen = snakemake.params.trained
    with job(snakemake.log[0], f"train yield models {', '.join(dict.fromkeys(name for name, *_ in chosen))}") as log:
        for (name, strategy, settings), path in zip(chosen, snakemake.output.models, strict=True):
            main(
                snakemake.input.train,
                path,
                name,
                strategy,
                TrainingConfig(**settings),
                SearchConfig(**snakemake.params.search),
                threads=snakemake.threads,
            )
            log.info("trained: %s", path)
