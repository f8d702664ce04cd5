"""Predicts yields of new conditions: python scripts/predict_yields.py MODEL conditions.tsv out.tsv"""

import argparse
import sys
from pathlib import Path

from threadpoolctl import threadpool_limits

from millprint.config.load import check_model, read_yaml
from millprint.config.proposals import PredictionConfig
from millprint.config.yields import TrainingConfig, YieldConfig
from millprint.errors import ConfigError, MillprintError
from millprint.files import write_table
from millprint.job import job
from millprint.predict.domain import MillCurves
from millprint.predict.new_conditions import predict_conditions
from millprint.predict.tables import read_rows


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
        folds = settings.honest.conformal_folds
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
    with job(snakemake.log[0], "predict yields"):
        main(
            snakemake.input.model,
            snakemake.input.conditions,
            snakemake.output.predicted,
            PredictionConfig(**snakemake.params.settings),
            TrainingConfig(**snakemake.params.training),
            snakemake.params.conformal_folds,
            snakemake.params.interval_level,
            extrapolate=False,
            mill=snakemake.input.mill,
        )
elif __name__ == "__main__":
    raise SystemExit(command_line())
