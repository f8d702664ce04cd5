"""SHAP values of the tree models for every screening run."""

import pandas as pd

from millprint.files import write_table
from millprint.job import job
from millprint.predict.explanation import rank_features, shap_values
from millprint.predict.model_files import load_model
from millprint.predict.report import labelled
from millprint.predict.tables import read_rows


def main(parts: list[str], model_paths: list[str], values_path: str, ranking_path: str) -> None:
    """Explain each model of `model_paths` on the rows of `parts`, whose yields are not used."""
    rows = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    models = [load_model(path) for path in model_paths]
    values = pd.concat([labelled(shap_values(model, rows), model) for model in models], ignore_index=True)
    write_table(values, values_path)
    write_table(rank_features(values), ranking_path)


if "snakemake" in globals():
    with job(snakemake.log[0], "explain yield models"):
        main(
            [snakemake.input.train, snakemake.input.test],
            snakemake.input.models,
            snakemake.output.values,
            snakemake.output.ranking,
        )
