"""The spread of a surrogate's measures over its trainings: one training is a single draw, like one run of a mill."""

import pandas as pd

from millprint.thesis.surrogate.measures import RUNAWAY

MEASURE = ["test", "measure"]
SPREAD = ["trainings", "lowest", "highest"]
TRAINING_COLUMNS = ["variant", "training", "test", "length_s", "measure", "value"]


def tabulate_trainings(metrics: pd.DataFrame, trainings: dict[str, list[str]]) -> pd.DataFrame:
    """A row for each variant, training (1 is the first), test and measure, with TRAINING_COLUMNS.

    metrics: rows of metrics.tsv of all trainings; trainings: by variant, the names of its trainings, its own first.
    """
    place = {name: (base, number) for base, names in trainings.items() for number, name in enumerate(names, start=1)}
    own = metrics[metrics["variant"].isin(place)]
    where = pd.DataFrame(own["variant"].map(place).tolist(), columns=["variant", "training"], index=own.index)
    return own.assign(**{name: where[name] for name in where})[TRAINING_COLUMNS].reset_index(drop=True)


def with_spread(metrics: pd.DataFrame, trainings: dict[str, list[str]]) -> pd.DataFrame:
    """The rows of the first trainings, with SPREAD: how many trainings, and the lowest and highest of their values."""
    table = tabulate_trainings(metrics, trainings)
    groups = table.groupby(["variant", *MEASURE], sort=False)["value"]
    spread = groups.agg(trainings="size", lowest="min", highest="max").reset_index()
    return metrics[metrics["variant"].isin(trainings)].merge(spread, how="left", on=["variant", *MEASURE])


def failed_tests(metrics: pd.DataFrame) -> set[str]:
    """The tests in which the roll-out of one training lost balls and ran away. metrics: its rows of metrics.tsv."""
    measures = metrics.pivot(index="test", columns="measure", values="value")
    measures = measures.reindex(columns=["balls_left", "mean_square_speed_ratio"])
    lost, calm = measures["balls_left"] > 0, measures["mean_square_speed_ratio"] < RUNAWAY
    return set(measures.index[lost & ~calm])
