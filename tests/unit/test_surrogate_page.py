"""The tables of docs/why/surrogate.md say what is stored of runs on several machines."""

import pandas as pd
import pytest

from millprint.run.files import read_table
from millprint.thesis.surrogate.measure_tables import BASELINE_COLUMNS, BASELINES
from tests.conftest import ROOT

PAGE = (ROOT / "docs/why/surrogate.md").read_text()
STORED = read_table(ROOT / "docs/why/surrogate_baselines.tsv", text=["test", "motion", "model", "measured_on"])
MOTIONS = {
    "trained": "of the training",
    "motion1": "unseen: motion 1",
    "motion2": "unseen: motion 2",
    "post": "unseen: jar with a post",
}
NETWORK = "thesis"


def cell(rows: pd.DataFrame, measure: str) -> str:
    """The values of a measure over the trainings of a model, as the page has them."""
    ordered = rows.sort_values("training").itertuples()
    values = ["ran away" if row.ran_away == "yes" else f"{getattr(row, measure):.3g}" for row in ordered]
    return ", ".join(values).replace("nan", "none")


def table_row(test: str, measure: str) -> str:
    """A row of the page: networks by machine, the baselines, and for the dissipation what is printed."""
    own = STORED[STORED["test"] == test]
    # Some runs have kept only some of the measures.
    kept = (
        STORED[STORED["model"] == NETWORK].groupby("measured_on", sort=False).filter(lambda rows: rows[measure].any())
    )
    networks = [cell(rows, measure) for _, rows in kept[kept["test"] == test].groupby("measured_on", sort=False)]
    cells = [MOTIONS[test], f"{own['length_s'].iloc[0]:g} s", *networks]
    cells += [cell(own[own["model"] == name], measure) for name in BASELINES]
    if measure == "dissipation_error_percent":
        printed = own["thesis_percent"].dropna()
        cells.append(f"{printed.iloc[0]:g}" if len(printed) else "not stated")
    return f"| {' | '.join(cells)} |"


@pytest.mark.parametrize("measure", ["dissipation_error_percent", "mean_square_speed_ratio", "increments_5ms_r"])
@pytest.mark.parametrize("test", MOTIONS)
def test_the_page_has_what_is_stored(test, measure):
    assert table_row(test, measure) in PAGE


def test_the_sentences_below_the_errors_hold():
    errors = STORED.set_index(["test", "model"])["dissipation_error_percent"].dropna()
    network, power, longer, seed = (
        errors.xs(name, level="model") for name in (NETWORK, "no_network", "long_step", "other_seed")
    )
    assert (network["trained"] < seed["trained"]).sum() == 2 and network["trained"].max() > power["trained"]
    assert all(network[test].max() < power[test] for test in ("motion1", "motion2"))
    assert (network["post"] < power["post"]).sum() == 1
    nearer = {test: (network[test] < longer[test]).sum() for test in ("motion1", "motion2", "post")}
    assert nearer == {"motion1": 1, "motion2": 0, "post": 0}


def test_the_balls_of_all_networks_are_too_slow_and_out_of_step():
    networks = STORED[(STORED["model"] == NETWORK) & (STORED["ran_away"] == "no")]
    assert networks["mean_square_speed_ratio"].max() < 0.7
    assert (networks.loc[networks["motion"] == "unseen", "increments_5ms_r"] < 0).all()


def test_the_page_says_which_motions_are_unseen_as_the_table_does():
    stored = STORED.drop_duplicates("test").set_index("test")["motion"]
    assert {test: motion.split(":")[0] for test, motion in MOTIONS.items()} == stored[list(MOTIONS)].to_dict()


def test_what_is_stored_is_of_one_length_and_of_every_baseline():
    assert list(STORED.columns) == [*BASELINE_COLUMNS, "measured_on"]
    for _, rows in STORED.groupby("test"):
        assert rows["length_s"].nunique() == 1 and set(BASELINES) <= set(rows["model"])


def test_the_first_trainings_are_those_whose_verdicts_are_stored():
    """The verdicts of a run on a machine are of its first training."""
    verdicts = read_table(ROOT / "config/data/verdicts_elsewhere.tsv", text=["id", "processor", "reproduced"])
    claims = {"trained": "6.energy", "motion1": "6.energy.motion1", "motion2": "6.energy.motion2"}
    first = STORED[(STORED["model"] == NETWORK) & (STORED["training"] == 1)].set_index(["measured_on", "test"])
    known = verdicts[verdicts["id"].isin(claims.values())].set_index(["processor", "id"])["reproduced"]
    for (machine, test), row in first.iterrows():
        if test in claims and (machine, claims[test]) in known.index:
            assert row["dissipation_error_percent"] == pytest.approx(float(known[machine, claims[test]]), rel=0.01)
