"""Effect of each choice that the thesis leaves open on the metrics of the locked split."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.yields import TrainingConfig
from millprint.files import write_table
from millprint.job import job
from millprint.predict.choices import compare_choices, describe_search
from millprint.predict.model_files import load_model
from millprint.predict.tables import read_rows
from millprint.progress import progress


def main(inputs, choices_path: str, settings: TrainingConfig, again: list[tuple[str, str, str]]) -> None:
    """Write one row for each model and for each of its alternatives.

    again: regressor, strategy and choice of every model in inputs.otherwise, in the same order.
    """
    train, test, outside = (read_rows(path) for path in (inputs.train, inputs.test, inputs.outside))
    tables = []
    with threadpool_limits(1), progress(len(inputs.models), "comparing choices", "model") as bar:
        for path in inputs.models:
            model = load_model(path)
            tables.append(compare_choices(model, train, test, outside, settings))
            for (*own, choice), other in zip(again, inputs.otherwise, strict=True):
                if own == [model.name, model.strategy]:
                    tables.append(describe_search(load_model(other), test, outside, choice, settings))
            bar.update()
    write_table(pd.concat(tables, ignore_index=True), choices_path)


if "snakemake" in globals():
    with job(snakemake.log[0], "compare yield choices"):
        main(
            snakemake.input,
            snakemake.output.choices,
            TrainingConfig(**snakemake.params.training),
            snakemake.params.searched_again,
        )
