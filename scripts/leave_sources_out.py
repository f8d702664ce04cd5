"""Predicts the runs of every source by models that were trained on the runs of all other sources."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.design import Factor
from millprint.config.other_sources import OtherSourcesConfig
from millprint.config.proposals import PredictionConfig
from millprint.config.yields import EvaluationConfig, TrainingConfig
from millprint.files import write_table
from millprint.job import job
from millprint.predict.other_runs import GIVEN, read_other_runs, with_other_runs
from millprint.predict.other_sources import leave_sources_out, score_sources, sources_out
from millprint.predict.procedures import procedure_of
from millprint.predict.regressors import AVERAGED, PRIMARY, TWO_STEP
from millprint.predict.tables import read_parts
from millprint.progress import progress

# The averaged Gaussian process, the best model of Table 5.6, and its baseline.
MODELS = [(AVERAGED, PRIMARY), ("gpr", TWO_STEP), ("linear", PRIMARY)]


def main(
    own: pd.DataFrame,
    others: pd.DataFrame,
    output,
    name: str,
    training: TrainingConfig,
    budget: EvaluationConfig,
    averaging: AveragingConfig,
    limits: PredictionConfig,
    level: float,
) -> None:
    """Write the runs of all sources, their held-out predictions, and the scores of every source."""
    rows = with_other_runs(own, others, name)
    procedures = {key: procedure_of(*key, training, budget, averaging) for key in MODELS}
    with threadpool_limits(1), progress(len(sources_out(rows)) * len(MODELS), "leaving sources out", "fit") as bar:
        predictions = leave_sources_out(rows, procedures, limits, level, bar.update)
    # Ours are the descriptors of the screening table.
    origins = [*[GIVEN] * len(own), *others["descriptors"]]
    write_table(rows.assign(descriptors=origins), output.runs)
    write_table(predictions, output.predictions)
    write_table(score_sources(predictions, rows, budget, level), output.scores)


if "snakemake" in globals():
    with job(snakemake.log[0], "leave sources out"):
        factors = [Factor(**factor) for factor in snakemake.params.factors]
        parts = read_parts(snakemake.input.screening, snakemake.input.split, factors)
        own = pd.concat(parts, ignore_index=True)
        settings = OtherSourcesConfig(**snakemake.params.other_sources)
        main(
            own,
            read_other_runs(settings, {snakemake.input.screening: own["case"]}, "the configuration"),
            snakemake.output,
            settings.own,
            TrainingConfig(**snakemake.params.training),
            EvaluationConfig(**snakemake.params.honest),
            AveragingConfig(**snakemake.params.averaging),
            PredictionConfig(**snakemake.params.prediction),
            snakemake.params.interval_level,
        )
