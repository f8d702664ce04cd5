"""The measured tables of the yield stage: the screening runs with their split, and the runs outside their domain."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from millprint.config.design import Factor
from millprint.config.doe import DoeConfig
from millprint.config.errors import ConfigError
from millprint.config.yields import YieldConfig
from millprint.run.tables import Number, Text, read_measured
from millprint.thesis.doe.runs import PERCENT_YIELD, YIELD, read_runs
from millprint.thesis.yields.features import CONDITIONS, FEATURES

ROLES = ("train", "test")


def read_split(path: str) -> pd.DataFrame:
    """Read the locked split: columns case (text) and role (train or test), in the order in which models see the rows.

    Raises ConfigError, in one line, for a missing column, a case that appears twice, another role, or an empty part.
    """
    split = read_measured(path, [Text("case", unique=True), Text("role", choices=ROLES)])
    for role in ROLES:
        if (split["role"] == role).sum() < 2:
            raise ConfigError(f"{path}: column role: at least two cases must have the role {role}")
    return split


def read_parts(screening: str, split: str, factors: Sequence[Factor]) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The training rows and the test rows of the screening table, each in the order of the split.

    Columns: case, the six conditions, yield_percent. Raises ConfigError, in one line, for a table that read_runs
    refuses, a run without a role and a role without a run.
    """
    runs = read_runs(screening, factors, positive=list(CONDITIONS)).set_index("case")
    roles = read_split(split).set_index("case")["role"]
    for case in runs.index.difference(roles.index):
        raise ConfigError(f"{split}: column case: case {case} of {screening} has no role; must be train or test")
    for case in roles.index.difference(runs.index):
        raise ConfigError(f"{split}: column case = {case}: there is no such case in {screening}")
    rows = runs.loc[roles.index, [*CONDITIONS, YIELD]].reset_index()
    train, test = ((roles == role).to_numpy() for role in ROLES)
    return rows[train].reset_index(drop=True), rows[test].reset_index(drop=True)


def read_rows(path: str, yields: bool = True) -> pd.DataFrame:
    """Read case (text), the six conditions, and yield_percent unless `yields` is false.

    Raises ConfigError, in one line, as `read_measured`: for no rows, a case that is missing or appears twice, a
    condition that is not above 0 and a yield outside 0 to 100.
    """
    columns = [Number(name, 0, above=True) for name in CONDITIONS] + ([PERCENT_YIELD] if yields else [])
    return read_measured(path, [Text("case", unique=True), *columns])


def check_yield_tables(settings: YieldConfig, screening: str, split: str, design: DoeConfig, source: str) -> None:
    """Raise ConfigError, in one line, for the first setting or table entry with which a job would fail."""
    train, test = read_parts(screening, split, design.factors)
    read_rows(settings.out_of_domain)
    for name in settings.training.choices.linear_features:
        if name not in FEATURES:
            known = ", ".join(FEATURES)
            raise ConfigError(
                f"{source}: yields.training.choices.linear_features = {name!r}: no feature; known: {known}"
            )
    runs = len(train) + len(test)
    evaluation = settings.evaluation
    smallest = min(len(train), runs - int(np.ceil(runs / evaluation.outer_folds)))
    limits = {
        "search.folds": (settings.search.folds, len(train), "the rows to train on"),
        "evaluation.outer_folds": (evaluation.outer_folds, runs, "the runs"),
        "evaluation.folds": (evaluation.folds, smallest, "the rows that an outer fold trains on"),
        "evaluation.conformal_folds": (evaluation.conformal_folds, smallest, "the rows that an outer fold trains on"),
        "retrospective.start_runs": (
            settings.retrospective.start_runs,
            runs - 1 - settings.retrospective.targets,
            "the runs but one, without the targets",
        ),
        "retrospective.held_out_runs": (
            settings.retrospective.held_out_runs,
            runs - settings.retrospective.start_runs - 1,
            "the runs but one, without those known at the start",
        ),
        "retrospective.chosen_runs": (
            settings.retrospective.chosen_runs,
            runs - settings.retrospective.start_runs - settings.retrospective.held_out_runs,
            "the runs without those known at the start and those held out",
        ),
    }
    for key, (value, limit, rows) in limits.items():
        if value > limit:
            raise ConfigError(f"{source}: yields.{key} = {value}: at most {limit}, {rows}")
    read_rows(settings.prediction.conditions, yields=False)
