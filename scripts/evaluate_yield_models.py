"""Evaluates the trained models on the locked split, on held-out runs and outside the trained domain; explains trees;
compares other seeds.

Settings: yields.training, yields.evaluation, yields.interval_level.
Inputs: `train`, `test`, `outside`; `models`, `averaged`, `explained`, `searched_again`; `held_out` predictions and
`intervals`.
Outputs: `locked`, `scores_by_scheme`, `coverage`, `predictions`, `out_of_domain`, `time_variance`,
`scores`, `pit`, `differences`, `shap`, `shap_ranking`, `seeds`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import PRIMARY, EvaluationConfig, TrainingConfig
from millprint.run.files import read_table, write_table
from millprint.run.job import job, progress
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.yields.evaluation import (
    MODEL_KEYS,
    compare_seeds,
    coverage_table,
    labelled,
    locked_metrics,
    paired_differences,
    pit_histogram,
    predictions,
    rank_features,
    score_distributions,
    score_table,
    shap_values,
    time_variance,
)
from millprint.thesis.yields.experiments import read_rows
from millprint.thesis.yields.features import YieldWeights
from millprint.thesis.yields.held_out import INTERVAL_COLUMNS, PREDICTION_COLUMNS
from millprint.thesis.yields.regressors import AVERAGED, BASELINES
from millprint.thesis.yields.stored_models import load_averaged, load_model

TEXT = ["scheme", "case", "distribution"]
# The scheme of Table 5.6: the locked split, with models trained at the full search budget.
LOCKED = "locked"


def read_held_out(paths: list[str], models: list[tuple[str, str]], columns: list[str]) -> pd.DataFrame:
    """The tables of all models (name and strategy), joined; `paths` are in the order of `models`."""
    text = [name for name in columns if name in (*TEXT, "method")]
    tables = []
    for path, model in zip(paths, models, strict=True):
        table = read_table(path, numeric=[name for name in columns if name not in text], text=text)
        tables.append(table.assign(**dict(zip(MODEL_KEYS, model, strict=True)))[[*MODEL_KEYS, *table]])
    return pd.concat(tables, ignore_index=True)


def main(inputs, output, training: TrainingConfig, budget: EvaluationConfig, level: float) -> None:
    """Write every table that compares models, except the SHAP values. `level`: level of the predictive intervals."""
    weigh = YieldWeights.of(training)
    train, test = read_rows(inputs.train), read_rows(inputs.test)
    printed = [load_model(path) for path in inputs.models]
    models = [*printed, load_averaged(inputs.averaged)]
    write_table(locked_metrics(models, test, weigh), output.locked)
    rows = pd.concat([train.assign(role="train"), test.assign(role="test")], ignore_index=True)
    predicted = predictions(models, rows, level)
    write_table(predicted, output.predictions)
    outside = read_rows(inputs.outside)
    write_table(predictions(models, outside, level), output.out_of_domain)
    locked = predicted[predicted["role"] == "test"].assign(scheme=LOCKED, repeat=0)
    compared = [*((model.name, model.strategy) for model in models), *((name, PRIMARY) for name in BASELINES)]
    held_out = read_held_out(inputs.held_out, compared, PREDICTION_COLUMNS)
    write_table(score_table(pd.concat([locked, held_out], ignore_index=True), weigh, budget), output.scores_by_scheme)
    write_table(score_distributions(held_out), output.scores)
    write_table(pit_histogram(held_out), output.pit)
    against = [paired_differences(held_out, (name, PRIMARY), budget.level) for name in (AVERAGED, *BASELINES)]
    write_table(pd.concat(against, ignore_index=True), output.differences)
    intervals = read_held_out(inputs.intervals, compared, INTERVAL_COLUMNS)
    write_table(coverage_table(intervals, budget.level), output.coverage)
    write_table(time_variance(rows["time_h"].to_numpy(float), rows[YIELD].to_numpy(float)), output.time_variance)


def explain(parts: list[str], model_paths: list[str], values_path: str, ranking_path: str) -> None:
    """Explain each model of `model_paths` on the rows of `parts`, whose yields are not used."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    models = [load_model(path) for path in model_paths]
    values = pd.concat([labelled(shap_values(model, rows), model) for model in models], ignore_index=True)
    write_table(values, values_path)
    write_table(rank_features(values), ranking_path)


def compare(inputs, seeds_path: str, settings: TrainingConfig) -> None:
    """Write one row for each model and for each of its other seeds."""
    train, test, outside = (read_rows(path) for path in (inputs.train, inputs.test, inputs.outside))
    again = {(model.name, model.strategy): model for model in map(load_model, inputs.searched_again)}
    tables = []
    with threadpool_limits(1), progress(len(inputs.models), "comparing seeds", "model") as bar:
        for model in map(load_model, inputs.models):
            other = again.get((model.name, model.strategy))
            tables.append(compare_seeds(model, other, train, test, outside, settings))
            bar.update()
    write_table(pd.concat(tables, ignore_index=True), seeds_path)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    training = TrainingConfig(**own.training)
    with job(snakemake.log[0], "evaluate yield models"):
        main(given, made, training, EvaluationConfig(**own.evaluation), own.interval_level)
        explain([given.train, given.test], given.explained, made.shap, made.shap_ranking)
        compare(given, made.seeds, training)
