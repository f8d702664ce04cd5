"""The tables of docs/why/surrogate.md say what is stored of runs on several machines."""

import pandas as pd
import pytest

from millprint.run.files import read_table
from millprint.thesis.surrogate.measure_tables import BASELINES
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
