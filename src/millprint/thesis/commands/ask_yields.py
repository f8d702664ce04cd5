"""Predicts yields of new conditions by a stored model.

millprint yields results/yield/models/averaged_gpr_final.json conditions.tsv out.tsv
"""

import sys
from pathlib import Path

from millprint.cli.commands import parser_of
from millprint.config.arguments import check_written, value_of
from millprint.config.errors import ConfigError
from millprint.config.included import SOURCES
from millprint.config.load import check_model, read_yaml
from millprint.config.section import Fraction
from millprint.config.yields import YieldConfig
from millprint.run.files import read_table


def read_settings(path: str) -> YieldConfig:
    """The section `yields` of a configuration file."""
    content = read_yaml(path)
    if not isinstance(content, dict) or "yields" not in content:
        raise ConfigError(f"{path}: section yields is missing")
    return check_model(content["yields"], YieldConfig, f"{path}: yields")


def check_table(path: str) -> None:
    """Raise ConfigError, in one line, for a model in place of a table, and for settings in place of energies."""
    from millprint.thesis.yields.features import NORMAL

    if Path(path).suffix == ".json":
        raise ConfigError(
            f"{path}: is not a table; write the model first: millprint yields MODEL.json TABLE.tsv OUT.tsv"
        )
    names = read_table(path)
    if NORMAL not in names and "fill_ratio" in names:
        raise ConfigError(
            f"{path}: has settings, and {NORMAL} and the like are needed; `millprint.predict(MILL, table)` in Python "
            "gives them in J (docs/reference/python.md)"
        )


def main(arguments: list[str], name: str = "yields") -> None:
    """Read the arguments and predict."""
    parser = parser_of(name, __doc__)
    parser.add_argument("model", help="a stored model, results/yield/models/*.json")
    parser.add_argument("conditions", help="table with case and the six conditions")
    parser.add_argument("out", help="table to write")
    parser.add_argument(
        "--config", default=SOURCES.find("config/config.yaml"), help="configuration with the section yields"
    )
    parser.add_argument(
        "--mill", help="curves that the descriptors are compared with; default mill.json next to the model"
    )
    parser.add_argument(
        "--level", type=value_of("level", Fraction), help="level of the intervals [-]; default yields.interval_level"
    )
    parser.add_argument("--extrapolate", action="store_true", help="predict outside the domain of the model too")
    given = parser.parse_args(arguments)
    from millprint.thesis.yields.new_conditions import write_predictions

    check_written(given.out, given.model, given.conditions, given.config)
    check_table(given.conditions)
    settings = read_settings(given.config)
    level = given.level or settings.interval_level
    own = (settings.prediction, settings.training, settings.evaluation.conformal_folds, level, given.extrapolate)
    stored = Path(given.model).parent / "mill.json"
    mill = given.mill or (str(stored) if stored.exists() else None)
    refused = write_predictions(given.model, given.conditions, given.out, *own, mill)
    if mill is None:
        print(f"{stored}: no such file: the descriptors are not compared with the curves of a mill", file=sys.stderr)
    if refused:
        print(
            f"{refused} rows are outside the domain of the model and have no prediction; see column warning",
            file=sys.stderr,
        )
