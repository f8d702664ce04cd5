"""Judges the trained models: the locked split, leave-one-out, runs outside the domain, and the open choices."""

import pandas as pd

from millprint.config.yields import TrainingConfig, YieldConfig
from millprint.doe.runs import YIELD
from millprint.files import read_table, write_table
from millprint.job import job, progress
from millprint.predict.choices import compare_choices
from millprint.predict.evaluation import bootstrap_metrics, coverage, time_variance
from millprint.predict.honest import SCHEME
from millprint.predict.metrics import YieldWeights
from millprint.predict.model import YieldModel
from millprint.predict.report import hyperparameters, locked_metrics, predictions
from millprint.predict.store import load_model, stored_search
from millprint.predict.tables import read_rows

HELD_OUT = ["yield_percent", "predicted_percent"]


def read_held_out(paths: list[str], models: list[YieldModel]) -> pd.DataFrame:
    """Leave-one-out predictions of all models in one table; `paths` in the order of `models`."""
    tables = []
    for path, model in zip(paths, models, strict=True):
        table = read_table(path, numeric=HELD_OUT, text=["case"])
        tables.append(table.assign(model=model.algorithm, strategy=model.strategy, scheme=SCHEME))
    return pd.concat(tables, ignore_index=True)


def judge(held_out: pd.DataFrame, weigh: YieldWeights, settings: YieldConfig) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Metrics with bootstrap intervals, and the coverage of predictive intervals, by model, strategy and scheme."""
    honest, covered = [], []
    for keys, rows in held_out.groupby(["model", "strategy", "scheme"], sort=False):
        about = dict(zip(("model", "strategy", "scheme"), keys, strict=True))
        truth, predicted = rows["yield_percent"].to_numpy(float), rows["predicted_percent"].to_numpy(float)
        budget = settings.honest
        table = bootstrap_metrics(truth, predicted, weigh, budget.resamples, budget.level, budget.seed)
        honest.append(table.assign(**about))
        deviation = rows["deviation_pp"].to_numpy(float)
        if not pd.isna(deviation).any():
            covered.append(coverage(truth, predicted, deviation, budget.nominal).assign(**about))
    order = ["model", "strategy", "scheme"]
    return (
        pd.concat(honest, ignore_index=True)[[*order, "metric", "value", "lower", "upper"]],
        pd.concat(covered, ignore_index=True)[[*order, "nominal", "covered", "width_pp"]],
    )


def compare(
    models: list[YieldModel], train: pd.DataFrame, test: pd.DataFrame, settings: TrainingConfig, weigh: YieldWeights
) -> pd.DataFrame:
    """What each open choice does to each model."""
    tables = []
    with progress(len(models), "comparing choices", "model") as bar:
        for model in models:
            tables.append(compare_choices(model, train, test, settings.choices, settings.seed, weigh))
            bar.update()
    return pd.concat(tables, ignore_index=True)


def main(inputs, output, settings: YieldConfig) -> None:
    """Write every table of the chapter but the SHAP values."""
    training = settings.training
    weigh = YieldWeights(training.high_yield_percent, training.high_yield_weight)
    train, test = read_rows(inputs.train), read_rows(inputs.test)
    models = [load_model(path) for path in inputs.models]
    write_table(hyperparameters(models, [stored_search(path) for path in inputs.models]), output.hyperparameters)
    write_table(locked_metrics(models, test, weigh), output.locked)
    rows = pd.concat([train.assign(role="train"), test.assign(role="test")], ignore_index=True)
    predicted = predictions(models, rows, settings.interval_level)
    write_table(predicted, output.predictions)
    outside = read_rows(settings.out_of_domain)
    write_table(predictions(models, outside, settings.interval_level), output.out_of_domain)
    locked = predicted[predicted["role"] == "test"].assign(scheme="locked")
    held_out = read_held_out(inputs.held_out, models)
    honest, covered = judge(pd.concat([locked, held_out], ignore_index=True), weigh, settings)
    write_table(honest, output.honest)
    write_table(covered, output.coverage)
    write_table(time_variance(rows["time_h"].to_numpy(float), rows[YIELD].to_numpy(float)), output.time_variance)
    write_table(compare(models, train, test, training, weigh), output.choices)


if "snakemake" in globals():
    with job(snakemake.log[0], "evaluate yield models"):
        main(snakemake.input, snakemake.output, YieldConfig(**snakemake.params.settings))
