"""What other tools have beside ours, and the timings that are kept, with made inputs."""

from dataclasses import replace

import pandas as pd
import pytest

from millprint.bench import features, page
from millprint.bench.features import FEATURES, TOOLS, UNKNOWN, feature_rows, licence, read_tools
from millprint.bench.history import (
    HISTORY_COLUMNS,
    STORED,
    Machine,
    bench_machine,
    faster_than_lammps,
    read_history,
    widest_instructions,
    with_run,
)
from millprint.bench.page import TOOLS_TABLE, comparison_text, speed_rows
from millprint.errors import ConfigError
from millprint.figures.bench import plot_history
from millprint.files import write_table
from tests.conftest import ROOT

MACHINE = Machine("2026-11-20", "abcdef0123", "znver3, x86_64", "AVX2", 2, "22 Jul 2025")
EMPTY = pd.DataFrame(columns=list(HISTORY_COLUMNS))


def run_of(ours_ns: float, lammps_ns: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Timings and their spread of a case that both codes have, and of one that only we have."""
    rows = [
        ("cylinder_24x10mm", 24, "millprint", "facets (50)", ours_ns),
        ("cylinder_24x10mm", 24, "LAMMPS", "moving region", lammps_ns),
        ("emax_24x10mm", 24, "millprint", "facets (302)", 1.2 * ours_ns),
    ]
    timings = pd.DataFrame(rows, columns=["case", "balls", "code", "wall", "ns_per_ball_step"])
    timings["ratio_to_us"] = [1.0, lammps_ns / ours_ns, 1.0]
    ends = timings[["case", "code"]].assign(
        least_ns=0.9 * timings["ns_per_ball_step"], largest_ns=1.2 * timings["ns_per_ball_step"], processor_ns=1.0
    )
    return timings, ends


def kept() -> pd.DataFrame:
    """Two commits on one machine, and one on another."""
    history = with_run(EMPTY, *run_of(40.0, 400.0), MACHINE)
    history = with_run(history, *run_of(25.0, 500.0), MACHINE._replace(date="2026-11-22", commit="0123456789"))
    return with_run(
        history, *run_of(50.0, 300.0), MACHINE._replace(processor="neoverse-n1, aarch64", instructions="NEON")
    )


def test_runs_are_added_at_the_end_and_read_back(tmp_path):
    path = tmp_path / "history.tsv"
    write_table(kept(), path)
    pd.testing.assert_frame_equal(read_history(path), kept(), check_dtype=False)
    assert list(kept().columns) == list(HISTORY_COLUMNS) and len(kept()) == 9


def test_the_same_commit_on_the_same_day_and_machine_is_replaced():
    again = with_run(kept(), *run_of(30.0, 450.0), MACHINE)
    assert len(again) == 9
    own = again[(again["commit"] == MACHINE.commit) & (again["processor"] == MACHINE.processor)]
    assert set(own["ns_per_ball_step"]) == {30.0, 450.0, 36.0}


def test_a_ratio_is_lammps_over_ours_with_the_wider_spread():
    table = faster_than_lammps(kept())
    assert list(table["ratio"]) == [10.0, 20.0, 6.0]
    assert set(table["case"]) == {"cylinder_24x10mm"}
    # From 0.9 to 1.2 of the median.
    assert table["spread"].to_numpy() == pytest.approx(0.15)


def test_the_figure_has_a_point_for_every_run_and_a_line_at_one():
    (axes,) = plot_history(kept()).axes
    (bars,) = axes.containers
    assert list(bars.lines[0].get_ydata()) == [10.0, 20.0, 6.0]
    labels = [label.get_text() for label in axes.get_xticklabels()]
    assert labels[0] == "2026-11-20\nabcdef0\nAVX2" and len(labels) == 3
    assert any(set(line.get_ydata()) == {1} for line in axes.lines)


def test_the_page_shows_the_latest_run_of_each_processor():
    rows = speed_rows(kept())
    assert [row[0] for row in rows] == ["znver3, x86_64", "neoverse-n1, aarch64"]
    assert rows[0][-1] == "20.0 ± 3.0" and rows[0][2] == "2026-11-22, 0123456"


def test_this_machine_says_what_it_is():
    machine = bench_machine("22 Jul 2025")
    assert machine.instructions in ("AVX-512", "AVX2", "AVX", "SSE4.2", "NEON", "none")
    assert machine.cores >= 1 and machine.processor and machine.commit


@pytest.mark.parametrize(
    ("found", "name"),
    [({"avx2": True, "avx512f": True}, "AVX-512"), ({"avx2": True, "avx512f": False}, "AVX2"), ({}, "none")],
)
def test_the_widest_instructions_are_named(found, name):
    assert widest_instructions(found) == name


def test_a_run_that_is_kept_twice_is_refused(tmp_path):
    path = tmp_path / "history.tsv"
    write_table(pd.concat([kept(), kept().head(1)]), path)
    with pytest.raises(ConfigError, match="stands there twice"):
        read_history(path)


def test_what_is_kept_in_the_project_is_a_history():
    read_history(ROOT / STORED)


def test_every_feature_of_ours_is_shown_by_a_test_that_exists():
    for feature in FEATURES.values():
        assert feature.ours(ROOT) != "no" or not feature.tests
    assert {"no", "yes"} < {feature.ours(ROOT) for feature in FEATURES.values()}
    gone = replace(FEATURES["restart"], tests=("physics/test_restart.py::test_a_stopped_run",))
    with pytest.raises(ConfigError, match="no such test"):
        gone.ours(ROOT)
    with pytest.raises(ConfigError, match="no such test"):
        features.check_test(ROOT, "physics/absent.py::test_a")


def test_every_statement_on_others_has_a_source():
    tools = read_tools(ROOT / TOOLS_TABLE)
    assert set(tools["tool"]) == set(TOOLS) and tools["source"].str.len().min() > 5


def test_what_the_table_does_not_say_is_not_known():
    tools = pd.DataFrame([("LAMMPS", "cohesion", "yes", "a source")], columns=["tool", "feature", "has", "source"])
    rows = {row[0]: row[1:] for row in feature_rows(tools, ROOT)}
    assert rows["cohesion"] == ["no", "yes", UNKNOWN, UNKNOWN, UNKNOWN]
    assert rows["licence"][0] == licence(ROOT) == "MIT"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("ABAQUS\tcohesion\tyes\thttps://", "column tool, row 1 = ABAQUS"),
        ("LAMMPS\tcohesoin\tyes\thttps://", "column feature, row 1 = cohesoin"),
        ("LAMMPS\tcohesion\tyes\thttps://\nLAMMPS\tcohesion\tno\thttps://", "stands there twice"),
    ],
)
def test_a_table_with_a_fault_is_refused_in_one_line(tmp_path, row, words):
    path = tmp_path / "tools.tsv"
    path.write_text(f"tool\tfeature\thas\tsource\n{row}\n")
    with pytest.raises(ConfigError, match=words) as caught:
        read_tools(path)
    assert len(str(caught.value).splitlines()) == 1


def test_the_page_holds_both_tables(monkeypatch):
    monkeypatch.setattr(page, "read_history", lambda path: kept())
    text = comparison_text(ROOT)
    assert "| cohesion | no |" in text and "| 20.0 ± 3.0 |" in text and page.NO_RUN not in text
    assert text.count("http") >= len(TOOLS)
