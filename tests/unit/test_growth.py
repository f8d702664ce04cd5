"""What measures growth: the time of a command, runs of many simulations, fingerprints of many conditions."""

import json
import sys

import numpy as np
import pandas as pd
import pytest
import yaml

import measure_growth
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.errors import MillprintError
from millprint.figures.growth import draw_growth
from millprint.files import write_table
from millprint.fingerprint.cases import mill_cases
from millprint.fingerprint.curves import CURVES
from millprint.growth import measure
from millprint.growth.measure import measure_pages, row
from millprint.growth.page import growth_text
from millprint.growth.planning import write_plain, write_project
from millprint.growth.spent import Spent, spent
from millprint.growth.table import GROWTH_COLUMNS, STORED, read_growth, this_machine
from millprint.growth.work import grown
from tests.conftest import ROOT


def test_a_command_takes_processor_time_and_memory_and_may_be_too_slow_or_fail(tmp_path):
    busy = "import time; a = bytearray(200_000_000)\nwhile time.process_time() < 0.6: pass"
    used = spent([sys.executable, "-c", f"{busy}\nprint('done')"], tmp_path, 100)
    assert 0.5 < used.processor_s < 5
    assert 195 < used.memory_mb < 400
    assert used.said == "done\n"
    assert spent([sys.executable, "-c", "import time; time.sleep(60)"], tmp_path, 0.3) is None
    with pytest.raises(MillprintError, match="no such thing"):
        spent([sys.executable, "-c", "raise SystemExit('no such thing')"], tmp_path, 100)


@pytest.mark.parametrize("asked", [60, 300, 3000, 30000])
def test_a_project_has_about_as_many_cases_as_asked_for(tmp_path, asked):
    count = write_project(tmp_path / "whole", ROOT / "config/mills", asked)
    mill = MillConfig(**yaml.safe_load((tmp_path / "whole/config/mills/grown.yaml").read_text()))
    assert 0.7 * asked <= count <= 1.5 * asked
    assert len(mill_cases(mill, MillsConfig(contact="calibrated"))) == count
    write_plain(tmp_path / "plain", count)
    assert f"range({count})" in (tmp_path / "plain/Snakefile").read_text()


def test_made_conditions_begin_with_the_measured_ones_and_lie_near_them():
    table = pd.DataFrame({"fill_ratio": [0.1, 0.2], **{name: [1.0, 2.0] for name in CURVES}})
    more = grown(table, 50)
    assert len(more) == 50
    pd.testing.assert_frame_equal(more[:2], table)
    assert np.abs(more["fill_ratio"] / np.tile([0.1, 0.2], 25) - 1).max() <= 0.03
    assert more["fill_ratio"].nunique() == 50


def test_the_table_and_the_figure_hold_what_was_not_measured_too(tmp_path):
    page = tmp_path / "a.html"
    page.write_text("x" * 2_000_000)
    (unopened,) = measure_pages([page], None, 10)
    assert unopened["size"] == pytest.approx(2.0)
    assert unopened["note"] == "no browser here"
    rows = [
        unopened,
        row("planning", "dry run", 300, Spent(10.0, 200.0, ""), 10, unit="cases"),
        row("planning", "dry run", 3000, None, 10, unit="cases"),
        row("simulation", "one thread", 24, Spent(10.0, 200.0, ""), 10, unit="balls", value=40.0),
    ]
    whole = pd.DataFrame([each | this_machine() for each in rows], columns=list(GROWTH_COLUMNS))
    write_table(whole, tmp_path / STORED)
    table = read_growth(tmp_path / STORED)
    assert table["note"].iloc[2] == "not within 10 s"
    text = growth_text(tmp_path)
    assert "| dry run | 300 | 10 | 200 |" in text and "| one thread | 24 | 40 | 200 |" in text
    assert "| dry run, not within 10 s | 3,000 |  |  |" in text
    draw_growth(table, tmp_path / "growth.svg", tmp_path / "growth.png")
    assert "cost model" in (tmp_path / "growth.svg").read_text()


def test_the_figure_names_every_processor_and_more_things_than_it_has_colours(tmp_path):
    here, there = this_machine(), {**this_machine(), "processor": "another"}
    pages = [row("pages", f"{n}.html", 1.0 + n, Spent(1.0 + n, 200.0, ""), 10, unit="MB") | here for n in range(9)]
    slower = row("simulation", "one thread", 24, Spent(10.0, 200.0, ""), 10, unit="balls", value=80.0) | there
    write_table(pd.DataFrame([*pages, slower], columns=list(GROWTH_COLUMNS)), tmp_path / "growth.tsv")
    draw_growth(read_growth(tmp_path / "growth.tsv"), tmp_path / "growth.svg", tmp_path / "growth.png")
    text = (tmp_path / "growth.svg").read_text()
    assert all(f">{name}<" in text for name in ("8.html", "one thread", here["processor"], "another"))


def test_a_simulation_with_threads_says_its_wall_time_too(monkeypatch, tmp_path):
    said = json.dumps({"processor_s": 2.0, "processor_ns": 30.0, "ns_per_ball_step": 16.0})
    monkeypatch.setattr(measure, "spent", lambda *_: Spent(5.0, 300.0, said))
    rows = list(measure.measure_simulations(tmp_path / "bench.yaml", [764, 20000], [1, 2], 10))
    # A step of few balls is shorter than what threads wait for each other.
    assert [(row["size"], row["what"]) for row in rows] == [
        (764, "one thread"),
        (20000, "one thread"),
        (20000, "2 threads"),
    ]
    assert [row["value"] for row in rows] == [30.0] * 3
    assert [row["note"] for row in rows] == ["", "", "16 ns by the clock"]


def test_what_is_measured_again_takes_the_place_of_its_row_and_all_others_stay(tmp_path, monkeypatch):
    measured = {"fingerprint": [("fit", 100, 3.0), ("fit", 300, 20.0)]}

    def rows(options, part):
        return (row(part, what, size, Spent(cost, 100.0, ""), 10) for what, size, cost in measured[part])

    monkeypatch.setattr(measure_growth, "measured", rows)
    for fitted in (measured["fingerprint"], [("fit", 1000, 15.0), ("fit", 300, 21.0)]):
        measured["fingerprint"] = fitted
        measure_growth.main(["fingerprint", "--results", str(tmp_path)])
    table = read_growth(tmp_path / "growth.tsv")
    assert set(table["processor"]) == {this_machine()["processor"]}
    assert dict(zip(table["size"], table["processor_s"], strict=True)) == {100: 3, 300: 21, 1000: 15}
