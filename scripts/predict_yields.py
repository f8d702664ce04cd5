"""Predicts yields of new conditions: python scripts/predict_yields.py MODEL conditions.tsv out.tsv

In the workflow it also proposes the next experiments, within the configured region.
"""

import argparse
import sys
from pathlib import Path

from threadpoolctl import threadpool_limits

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError, MillprintError
from millprint.config.load import check_model, read_yaml
from millprint.config.next_experiments import PredictionConfig, ProposalConfig
from millprint.config.yields import TrainingConfig, YieldConfig
from millprint.run.files import write_table
from millprint.run.job import job
from millprint.thesis.yields.domain import MillCurves
from millprint.thesis.yields.experiments import RUNNING, experiment_rows, read_experiments
from millprint.thesis.yields.model_files import load_averaged, training_rows
from millprint.thesis.yields.new_conditions import predict_conditions
from millprint.thesis.yields.proposals import count_reasons, propose, split_region
from millprint.thesis.yields.region import Mill, region_conditions
from millprint.thesis.yields.run_tables import read_rows


def main(
    model: str,
    conditions: str,
    out: str,
    limits: PredictionConfig,
    training: TrainingConfig,
    folds: int,
    level: float,
    extrapolate: bool,
    mill: str | None = None,
) -> int:
    """Write the predictions, and return the number of rows without one.

    mill: path of the curves of the mill that the conditions belong to; None if they are not known.
    """
    with threadpool_limits(1):
        rows, own = read_rows(conditions, yields=False), MillCurves.read(mill) if mill else None
        table = predict_conditions(model, rows, limits, training, folds, level, extrapolate, own)
    write_table(table, out)
    return int(table["predicted_percent"].isna().sum())


def propose_experiments(
    model: str,
    mill: str,
    output,
    volume: float,
    settings: ProposalConfig,
    limits: PredictionConfig,
    reaction: ChemistryConfig,
) -> str:
    """Write the proposals, and what may not be proposed with its reasons; return a line for the log.

    model: path of the final model, which predicts the proposals too; mill: path of the curves of the mill; volume: of
    its jar [m3]; limits: those of predictions.
    """
    with threadpool_limits(1):
        process, known, own = load_averaged(model), training_rows(model), MillCurves.read(mill)
        machine = Mill(own.density, own.amplitude, volume)
        conditions = region_conditions(settings.region, own.curves, machine)
        allowed, left_out = split_region(process, known, conditions, settings, limits, reaction, machine, own)
        running, taken = None, []
        if settings.experiments:
            told = read_experiments(settings.experiments, own.curves)
            running, taken = experiment_rows(told, RUNNING, own.curves, machine), told["case"].tolist()
        table = propose(process, known, allowed, settings, running, limits.curve_tolerance, taken)
    write_table(table, output.proposals)
    write_table(left_out, output.left_out)
    write_table(count_reasons(left_out, len(conditions)), output.reasons)
    free = settings.replicates + settings.centre_points + 2 * settings.runs - len(table)
    return f"{len(allowed)} of {len(conditions)} conditions may be proposed; {free} slots of the batch are left empty"


def read_settings(path: str) -> YieldConfig:
    """The section `yields` of a configuration file."""
    content = read_yaml(path)
    if not isinstance(content, dict) or "yields" not in content:
        raise ConfigError(f"{path}: section yields is missing")
    return check_model(content["yields"], YieldConfig, f"{path}: yields")


def command_line() -> int:
    """Read the arguments and predict; return 1 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", help="a stored model, results/yield/models/*.json")
    parser.add_argument("conditions", help="table with case and the six conditions")
    parser.add_argument("out", help="table to write")
    parser.add_argument("--config", default="config/config.yaml", help="configuration with the section yields")
    parser.add_argument("--mill", help="curves that the descriptors are held to; default mill.json beside the model")
    parser.add_argument("--level", type=float, help="level of the intervals [-]; default yields.interval_level")
    parser.add_argument("--extrapolate", action="store_true", help="predict outside the domain of the model too")
    given = parser.parse_args()
    if given.level is not None and not 0 < given.level < 1:
        parser.error(f"--level = {given.level:g}: must be between 0 and 1")
    try:
        settings = read_settings(given.config)
        level = given.level or settings.interval_level
        folds = settings.evaluation.conformal_folds
        own = (settings.prediction, settings.training, folds, level, given.extrapolate)
        beside = Path(given.model).parent / "mill.json"
        mill = given.mill or (str(beside) if beside.exists() else None)
        refused = main(given.model, given.conditions, given.out, *own, mill)
    except MillprintError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    if mill is None:
        print(f"{beside}: no such file: the descriptors are not held to the curves of a mill", file=sys.stderr)
    if refused:
        print(
            f"{refused} rows are outside the domain of the model and have no prediction; see column warning",
            file=sys.stderr,
        )
    return 0


if "snakemake" in globals():
    given, made, asked = snakemake.input, snakemake.output, snakemake.params
    limits = PredictionConfig(**asked.settings)
    with job(snakemake.log[0], "predict yields") as logger:
        main(
            given.model,
            given.conditions,
            made.predicted,
            limits,
            TrainingConfig(**asked.training),
            asked.conformal_folds,
            asked.interval_level,
            extrapolate=False,
            mill=given.mill,
        )
        logger.info("predicted: %s", given.conditions)
        line = propose_experiments(
            given.proposing,
            given.mill,
            made,
            asked.volume_m3,
            ProposalConfig(**asked.proposals),
            limits,
            ChemistryConfig(**asked.chemistry),
        )
        logger.info(line)
elif __name__ == "__main__":
    raise SystemExit(command_line())
