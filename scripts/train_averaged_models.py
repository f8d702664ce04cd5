"""Fits the averaged Gaussian process on the training rows, and on every run that is collected for the final model.

Settings: yields.averaging, yields.proposals, partition (the machine); the mill.
Inputs: `train`, `test`, `regimes`, and `curves` if there are any.
Outputs: `rows`, `mill`, and two `models`.
"""

import pandas as pd
from threadpoolctl import threadpool_limits

from millprint.config.mill import MillConfig
from millprint.config.yields import AveragingConfig, ProposalConfig
from millprint.observables.condition import Condition
from millprint.observables.definitions import BASIC
from millprint.run.files import read_table, write_table
from millprint.run.job import job
from millprint.thesis.doe.factorial_designs import YIELD
from millprint.thesis.regimes import design_cases, read_regimes
from millprint.thesis.yields.averaging import fit_averaged
from millprint.thesis.yields.experiments import DONE, Mill, check_region, experiment_rows, read_experiments, read_rows
from millprint.thesis.yields.features import CONDITIONS
from millprint.thesis.yields.groups import reference_of_mill, regime_rows
from millprint.thesis.yields.new_conditions import MillCurves
from millprint.thesis.yields.stored_models import save_averaged


def main(path: str, model_path: str, settings: AveragingConfig) -> None:
    """Train only on the rows of one table."""
    rows = read_rows(path)
    with threadpool_limits(1):
        model = fit_averaged(rows, rows[YIELD].to_numpy(float), settings)
        save_averaged(model, rows, settings.margin, model_path)


def collect(
    given, made, cases: pd.DataFrame, table: pd.DataFrame, reference: Condition[float], name: str, volume: float,
    settings: ProposalConfig,
) -> None:  # fmt: skip
    """Write the rows of the final model, and the mill with its curves.

    table: of the curves; name, volume: of the mill [m3].
    """
    check_region(settings.region, table, "config")
    machine = Mill(reference.density_kg_m3, reference.amplitude_m, volume)
    known = [read_rows(given.train), read_rows(given.test), regime_rows(cases, reference)]
    speeds = [*settings.region.speed_rpm, *(60 * design_cases(cases, reference)["speed_hz"])]
    sizes = {*settings.region.ball_diameter_mm, 1e3 * reference.ball_diameter_m}
    if settings.experiments:
        taken = pd.concat(known)["case"].astype(str)
        told = read_experiments(settings.experiments, table, taken)
        known.append(experiment_rows(told, DONE, table, machine))
        speeds += told["speed_rpm"].tolist()
        sizes |= set(told["ball_diameter_mm"])
    kept = [part[["case", *CONDITIONS, YIELD]] for part in known if len(part)]
    write_table(pd.concat(kept, ignore_index=True), made.rows)
    own = MillCurves(name, table, machine.density, machine.amplitude, tuple(sorted(sizes)), (min(speeds), max(speeds)))
    own.write(made.mill)


if "snakemake" in globals():
    given, made, own = snakemake.input, snakemake.output, snakemake.params
    with job(snakemake.log[0], "train averaged models") as log:
        cases = read_regimes(given.regimes)
        mill = MillConfig(**own.mill)
        reference = reference_of_mill(cases, mill, **own.machine)
        table = read_table(given.curves, numeric=["fill_ratio", *BASIC]) if given.get("curves") else cases
        collect(given, made, cases, table, reference, mill.name, own.volume_m3, ProposalConfig(**own.proposals))
        log.info("collected: %s", made.rows)
        for rows, model in zip((given.train, made.rows), made.models, strict=True):
            main(rows, model, AveragingConfig(**own.averaging))
            log.info("trained: %s", model)
