"""Verdicts of other machines: what a run says about them, and how its own are stored."""

import pandas as pd
from tools.run_tables import VALIDATION, store_tables
from tools.store_verdicts import with_run

from millprint.estimate.judge import AGREES, DIFFERS, NOT_RUN, OPEN
from millprint.run.files import read_table, write_table
from millprint.thesis.claims.conclusions import (
    EXPECTED,
    OF_MACHINE,
    UNEXPECTED,
    compare_verdicts,
    in_a_line,
    read_stored,
)
from millprint.validation.verdicts import VERDICT_COLUMNS
from tests.conftest import ROOT


def judged(**verdicts) -> pd.DataFrame:
    natures = {"runtime": "timed", "point": "arithmetic"}
    about = {"reproduced": "2", "lower": "1", "upper": "3"}
    rows = []
    for name, said in verdicts.items():
        value, interval = said if isinstance(said, tuple) else (said, said if said != OPEN else "")
        rows.append(
            {
                "id": name,
                "nature": natures.get(name, "trained"),
                "verdict": value,
                "interval_verdict": interval,
                "reason": "",
                **about,
            }
        )
    return pd.DataFrame(rows)


MACHINE = {"processor": "znver4", "instructions": "AVX-512", "commit": "0f1e2d3c", "date": "2026-11-20"}


def test_a_run_says_which_verdicts_are_others_on_another_machine(tmp_path):
    there = judged(a=AGREES, b=AGREES, c=DIFFERS, runtime=AGREES, point=AGREES, missing=OPEN)
    write_table(read_stored(ROOT / "config/data/verdicts_elsewhere.tsv").iloc[:0], tmp_path / "none.tsv")
    stored = with_run(read_stored(tmp_path / "none.tsv"), there, "thesis", MACHINE)
    assert stored["id"].tolist() == ["a", "b", "c", "runtime", "point"]
    write_table(stored, tmp_path / "stored.tsv")
    stored = read_stored(tmp_path / "stored.tsv")
    here = judged(a=(DIFFERS, OPEN), b=DIFFERS, c=DIFFERS, runtime=DIFFERS, point=AGREES)
    table = compare_verdicts(here, stored, "thesis").set_index("id")
    assert table["reason"].to_dict() == {"a": EXPECTED, "b": UNEXPECTED, "runtime": OF_MACHINE}
    assert table.loc["a", ["verdict", "verdict_elsewhere", "processor"]].tolist() == ["differs", "agrees", "znver4"]
    said = in_a_line(table.reset_index(), stored, "thesis")
    assert said.startswith(
        "verdicts of other machines (5 of znver4, AVX-512, 0f1e2d3c, 2026-11-20): 3 differ here, 1 of them not"
    )
    assert "a (differs here, agrees there: an interval decides nothing)" in said
    assert in_a_line(compare_verdicts(there, stored, "thesis"), stored, "thesis").endswith("none differs here")
    assert in_a_line(table, stored, "smoke") == "verdicts of other machines: none is stored of the run smoke"
    # The same machine again takes the place of its earlier verdicts; another one is added.
    assert with_run(stored, here, "thesis", MACHINE).set_index("id")["verdict"]["a"] == DIFFERS
    assert len(with_run(stored, here, "thesis", MACHINE | {"processor": "other"})) == 10


def test_a_run_takes_the_place_of_the_set_ups_that_it_predicted(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs/why").mkdir(parents=True)
    (tmp_path / "validation").mkdir()

    def stored(date: str, **reasons: str) -> pd.DataFrame:
        about = dict.fromkeys(VERDICT_COLUMNS, 1.0) | {"class": "measured"}
        rows = [about | {"setup": setup, "reason": reason} for setup, reason in reasons.items()]
        write_table(pd.DataFrame(rows), tmp_path / "validation/verdicts.tsv")
        assert store_tables(tmp_path, MACHINE | {"date": date}) == [VALIDATION]
        return read_table(VALIDATION)

    assert stored("2026-11-20", bond_mill="off", slice_mill="near", drum_90cm=NOT_RUN)["setup"].tolist() == [
        "bond_mill",
        "slice_mill",
    ]
    table = stored("2026-11-21", slice_mill="off", bond_mill=NOT_RUN)
    assert table[["setup", "reason", "date"]].to_numpy().tolist() == [
        ["bond_mill", "off", "2026-11-20"],
        ["slice_mill", "off", "2026-11-21"],
    ]
