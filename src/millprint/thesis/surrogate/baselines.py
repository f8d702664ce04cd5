"""A network next to its baselines: nothing learned, a longer step of the DEM, and another seed of the DEM."""

import pandas as pd

from millprint.thesis.surrogate.ablations import DISSIPATION
from millprint.thesis.surrogate.spread import failed_tests

# Roll-outs of controls.tsv in which nothing is learned, and that of another seed.
UNLEARNED, OTHER_SEED = ("no_network", "long_step"), "other_seed"
BASELINES = (*UNLEARNED, OTHER_SEED)
# What is shown of each, next to the length of its roll-out.
SHOWN = (DISSIPATION, "mean_square_speed_ratio", "increments_5ms_r", "balls_left")
# Whether the motion of the jar in a test is that of the training.
OF_THE_TRAINING, UNSEEN = "of the training", "unseen"
BASELINE_COLUMNS = ["test", "motion", "model", "training", "length_s", *SHOWN, "ran_away", "thesis_percent"]


def with_motion(table: pd.DataFrame, trained_test: str) -> pd.DataFrame:
    """The same with a column `motion` after `test`; trained_test: the test on the motion of the training."""
    motion = [OF_THE_TRAINING if test == trained_test else UNSEEN for test in table["test"]]
    own = table.assign(motion=motion)
    own.insert(list(table.columns).index("test") + 1, "motion", own.pop("motion"))
    return own


def with_machine(stored: pd.DataFrame, table: pd.DataFrame, machine: str) -> pd.DataFrame:
    """The stored rows with those of a machine in place of its earlier ones, in a column `measured_on`."""
    others = stored[stored["measured_on"] != machine]
    return pd.concat([others, table.assign(measured_on=machine)], ignore_index=True)


def baseline_rows(controls: pd.DataFrame) -> pd.DataFrame:
    """The rows of controls.tsv in which nothing is learned, as rows of metrics.tsv."""
    own = controls[controls["rollout"].isin(UNLEARNED)]
    return own.rename(columns={"rollout": "variant"}).drop(columns="met").reset_index(drop=True)


def _seed_rows(controls: pd.DataFrame) -> pd.DataFrame:
    """Another seed as a variant: its mean against both runs that it shares nothing with, as in `dem_reference`."""
    own = controls[controls["rollout"] == OTHER_SEED]
    return own.assign(variant=OTHER_SEED, value=own["dem_reference"].fillna(own["value"]))


def baseline_table(
    trainings: pd.DataFrame, controls: pd.DataFrame, printed: dict[str, float], trained_test: str
) -> pd.DataFrame:
    """A row for each test and training of a variant or baseline, with BASELINE_COLUMNS.

    trainings: as `millprint.thesis.surrogate.spread.tabulate_trainings`; controls: rows of controls.tsv; printed: the
    error of the dissipation that the thesis states, by test [%]; trained_test: as in `with_motion`. The measures of a
    roll-out that ran away are left empty.
    """
    baselines = pd.concat([baseline_rows(controls), _seed_rows(controls)]).assign(training=1)
    rows = pd.concat([trainings, baselines], ignore_index=True)
    table = []
    for test in controls["test"].unique():
        own = rows[rows["test"] == test]
        for (model, training), part in own.groupby(["variant", "training"], sort=False):
            value = part.set_index("measure")["value"]
            away = test in failed_tests(part)
            row = {"test": test, "model": model, "training": training, "length_s": part["length_s"].max()}
            row |= {name: None if away and name != "balls_left" else value.get(name) for name in SHOWN}
            table.append(row | {"ran_away": "yes" if away else "no", "thesis_percent": printed.get(test)})
    return with_motion(pd.DataFrame(table), trained_test)[BASELINE_COLUMNS]
