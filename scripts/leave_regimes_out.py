"""Errors of the yield models at new fill ratios, without and with one or two cases of them in the training rows."""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.averaging import AveragingConfig
from millprint.config.mill import MillConfig
from millprint.config.yields import HeldOutConfig, TrainingConfig
from millprint.files import write_table
from millprint.fingerprint.condition import Condition
from millprint.fingerprint.regimes import read_regimes
from millprint.job import job
from millprint.predict.procedures import procedure_of
from millprint.predict.regimes import leave_regimes_out, reference_of_mill, regime_rows, summarise_regimes
from millprint.predict.regressors import AVERAGED, PRIMARY, TWO_STEP
from millprint.predict.tables import read_rows
from millprint.progress import progress

# The averaged Gaussian process with and without the tangential share, and the two models of Table 5.8.
PROCEDURES = {
    (AVERAGED, "power and share"): (AVERAGED, PRIMARY, False),
    (AVERAGED, "power alone"): (AVERAGED, PRIMARY, True),
    ("gpr two_step", "energies and frequency"): ("gpr", TWO_STEP, False),
    ("xgb two_step", "energies and frequency"): ("xgb", TWO_STEP, False),
}


def main(
    parts: list[str],
    cases: pd.DataFrame,
    output,
    reference: Condition[float],
    training: TrainingConfig,
    budget: HeldOutConfig,
    averaging: AveragingConfig,
    level: float,
) -> None:
    """Write predictions for every regime left out, and their summary."""
    screening = pd.concat([read_rows(path) for path in parts], ignore_index=True)
    rows = regime_rows(cases, reference)
    procedures = {
        name: (procedure_of(model, strategy, training, budget, averaging), hidden)
        for name, (model, strategy, hidden) in PROCEDURES.items()
    }
    with threadpool_limits(1), progress(len(procedures) * 12, "leaving regimes out", "fit") as bar:
        table = leave_regimes_out(screening, rows, procedures, level, bar.update)
    write_table(table, output.regimes)
    write_table(summarise_regimes(table), output.summary)


if "snakemake" in globals():
    with job(snakemake.log[0], "leave regimes out"):
        cases = read_regimes(snakemake.input.regimes)
        main(
            [snakemake.input.train, snakemake.input.test],
            cases,
            snakemake.output,
            reference_of_mill(cases, MillConfig(**snakemake.params.mill), **snakemake.params.machine),
            TrainingConfig(**snakemake.params.training),
            HeldOutConfig(**snakemake.params.honest),
            AveragingConfig(**snakemake.params.averaging),
            snakemake.params.interval_level,
        )
