"""Tables of the smoke run that follow from printed numbers: kept in tests/data/smoke, and compared with those of a run.

A table that changes on purpose is copied there from a smoke run.
"""

from pathlib import Path

import pandas as pd

from millprint.thesis.claims.evidence import CERTAIN
from tests.conftest import ROOT

STORED = ROOT / "tests/data/smoke"


def compare_tables(results: Path) -> int:
    """Hold the tables of a folder against the stored ones, and count them; of claims, those that are arithmetic."""
    places = {path: results / path.relative_to(STORED) for path in sorted(STORED.rglob("*.tsv"))}
    made = {path: place for path, place in places.items() if place.exists()}
    for path, place in made.items():
        expected, found = (pd.read_csv(each, sep="\t") for each in (path, place))
        if "nature" in found:
            found = found[found["nature"].isin(CERTAIN)]
        found = found[found["curves"] == "published"] if "curves" in found else found
        found = found[list(expected.columns)].reset_index(drop=True)
        pd.testing.assert_frame_equal(found, expected, check_dtype=False, rtol=1e-4, atol=1e-12, obj=str(place))
    return len(made)
