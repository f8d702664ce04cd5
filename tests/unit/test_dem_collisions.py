"""Counting rules on a hand-made table, and the files of a run."""

import itertools
import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from millprint.columns import width_of
from millprint.config.contact import ContactConfig
from millprint.config.counting import DEFAULT_RULES, CountingRule
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.collisions import (
    HISTOGRAM_NAMES,
    RANGE,
    collision_statistics,
    collision_table,
    merge_contacts,
    sort_by_pair,
)
from millprint.dem.layout import COLLISION
from millprint.dem.ledger import LEDGER_CHANNELS
from millprint.dem.recording import Table, make_table
from millprint.dem.run import AIM, run_case
from millprint.errors import SimulationError
from millprint.files import read_json

CONFIG = Path(__file__).parents[2] / "config"

# Pair, start [s], peak force [N], normal and tangential energy [J]; each contact lasts 1 ms.
CONTACTS = (
    (0, 1, 0.000, 2.0, 1.0, 4.0),
    (0, 1, 0.002, 5.0, 1.0, 2.0),
    (0, -4, 0.0005, 8.0, 1.0, 1.0),
    (0, 1, 0.007, 1.0, 1.0, 2.0),
    (2, 5, -0.001, 1.0, 1.0, 1.0),
)


def table():
    """Pair (0, 1) touches at 0, 2 and 7 ms, ball 0 and facet 3 once, and a pair from before the window once."""
    first, second, start, force, normal, tangential = (np.array(column) for column in zip(*CONTACTS, strict=True))
    columns = {
        "start_s": start, "duration_s": 0.001, "peak_force_N": force, "normal_J": normal,
        "damping_J": 0.25 * tangential, "tangential_J": tangential,
    }  # fmt: skip
    return collision_table(made_up(first, second, **columns))


def made_up(first, second, **columns) -> Table:
    """Contacts that have ended, with some of the values of layout.CollisionColumns."""
    value = np.zeros((len(first), width_of(COLLISION)))
    for name, column in columns.items():
        value[:, getattr(COLLISION, name)] = column
    return Table(first, second, np.ones(len(first)), value)


def count(**parameters):
    rule = CountingRule(name="rule", **parameters)
    (row,) = collision_statistics(table(), [rule], begin_s=0.0, window_s=0.5, balls=6)
    return row


@pytest.mark.parametrize(("gap", "number"), [(0.0, 4), (0.0005, 4), (0.0015, 3), (0.005, 2)])
def test_contacts_of_a_pair_within_the_gap_are_one_collision(gap, number):
    row = count(gap_s=gap)
    assert row["count"] == number
    assert row["frequency_hz"] == pytest.approx(number / 0.5)
    assert row["specific_frequency_hz"] == pytest.approx(number / 0.5 / 6)
    # The energies of a collision from before the window are in the mean, so that frequency times mean is power.
    assert row["mean_normal_J"] == pytest.approx(5.0 / number)
    assert row["mean_tangential_J"] == pytest.approx(10.0 / number)
    assert row["dropped"] == {"count": 0, "normal": 0, "tangential": 0}


def test_shares_of_balls_and_walls():
    row = count(gap_s=0.0015)
    assert row["shares"]["ball_ball"] == pytest.approx({"count": 2 / 3, "normal": 4 / 5, "tangential": 9 / 10})
    assert row["shares"]["ball_wall"] == pytest.approx({"count": 1 / 3, "normal": 1 / 5, "tangential": 1 / 10})


def test_a_force_threshold_drops_merged_collisions_with_their_energy():
    """Merged by 1.5 ms, the pair's first collision peaks at 5 N; the threshold must see that, not its 2 N part."""
    row = count(gap_s=0.0015, peak_force_min_N=3.0)
    assert row["count"] == 2
    assert row["mean_normal_J"] == pytest.approx((2.0 + 1.0) / 2)
    assert row["mean_tangential_J"] == pytest.approx((6.0 + 1.0) / 2)
    # Of three collisions that begin within the window one is dropped; the pair from before it takes energy along.
    assert row["dropped"] == pytest.approx({"count": 1 / 3, "normal": 2 / 5, "tangential": 3 / 10})
    assert count(peak_force_min_N=3.0)["count"] == 2
    assert count(peak_force_min_N=3.0)["mean_normal_J"] == pytest.approx(1.0)


def test_a_time_threshold_counts_time_in_contact_only():
    """Two contacts of 1 ms with 1 ms between them are 2 ms in contact."""
    assert count(gap_s=0.0015, duration_min_s=0.0015)["count"] == 1
    assert count(gap_s=0.0015, duration_min_s=0.0025)["count"] == 0
    assert count(gap_s=0.0, duration_min_s=0.0005)["count"] == 4


def test_kept_and_dropped_energies_sum_to_all_under_every_rule():
    for gap, force in itertools.product((0.0, 0.0015, 0.005), (0.0, 1.5, 6.0)):
        row = count(gap_s=gap, peak_force_min_N=force)
        kept = row["count"] * row["mean_normal_J"]
        assert kept + 5.0 * row["dropped"]["normal"] == pytest.approx(5.0)


def test_merging_agrees_with_a_plain_loop():
    """Thousands of random contacts, merged pair by pair in Python."""
    rng = np.random.default_rng(0)
    n, gap = 4000, 0.003
    first = rng.integers(0, 6, n)
    second = np.where(rng.random(n) < 0.5, first + rng.integers(1, 4, n), -1 - rng.integers(0, 5, n))
    duration, force, energy, start = rng.exponential(1e-3, n), rng.exponential(1, n), rng.random(n), np.zeros(n)
    # No pair touches again before it has parted.
    order = np.lexsort([second, first])
    start[order] = np.cumsum(np.concatenate([[0], duration[order][:-1]]) + rng.exponential(gap, n))
    table = made_up(first, second, start_s=start, duration_s=duration, peak_force_N=force, normal_J=energy)
    shuffled = rng.permutation(n)
    contacts = collision_table(Table(*(column[shuffled] for column in table)))
    expected = []
    for pair in sorted(set(zip(first.tolist(), second.tolist(), strict=True))):
        rows = contacts[(contacts["first"] == pair[0]) & (contacts["second"] == pair[1])].sort_values("start_s")
        end = -np.inf
        for row in rows.itertuples():
            if row.start_s - end > gap:
                expected.append([*pair, row.start_s, 0.0, 0.0, 0.0])
            expected[-1][3] += row.duration_s
            expected[-1][4] = max(expected[-1][4], row.peak_force_N)
            expected[-1][5] += row.normal_J
            end = row.start_s + row.duration_s
    merged = merge_contacts(sort_by_pair(contacts), gap)
    assert 200 < len(expected) < n
    names = ["first", "second", "start_s", "duration_s", "peak_force_N", "normal_J"]
    np.testing.assert_allclose(merged[names].to_numpy(), np.array(expected), rtol=1e-12)


def test_sliding_is_what_damping_leaves_of_the_tangential_work():
    assert table()["sliding_J"].to_numpy() == pytest.approx(0.75 * np.array([4, 2, 1, 2, 1]))


def test_no_contacts_at_all():
    empty = collision_table(make_table(0))
    (row,) = collision_statistics(empty, [CountingRule(name="r", gap_s=0.003, peak_force_min_N=1)], 0.0, 1.0, 3)
    none = {"count": 0.0, "normal": 0.0, "tangential": 0.0}
    assert row == {
        "name": "r",
        "gap_s": 0.003,
        "peak_force_min_N": 1.0,
        "duration_min_s": 0.0,
        "count": 0,
        "frequency_hz": 0.0,
        "specific_frequency_hz": 0.0,
        "mean_normal_J": 0.0,
        "mean_tangential_J": 0.0,
        "shares": {"ball_ball": none, "ball_wall": none},
        "dropped": none,
    }


DEM = DemConfig(time_step_s=4e-6, settle_s=0.1, discard_s=0.1, window_s=0.1)


def run(folder, dem=DEM, **change):
    """A short run of the Emax mill with 24 balls, its files in `folder`."""
    settings = {"ball_diameter_mm": 10, "fill_ratio": 0.1, "speed_rpm": 300, "seed": 0}
    settings |= {"settle_s": 0.05, "discard_s": 0.0, "window_s": 0.1}
    case = Case(mill="emax", contact="calibrated", **(settings | change))
    mill = load_named(CONFIG / "mills", "emax", MillConfig, "mill")
    contact = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
    return run_case(case, mill, contact, dem, folder / "run.h5", folder / "summary.json")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    run(folder, window_s=0.45, snapshot_interval_s=1e-3)
    return folder


def test_summary_and_run_agree(files):
    summary = read_json(files / "summary.json")
    with h5py.File(files / "run.h5") as file:
        assert json.loads(file.attrs["config"])["case"] == summary["case"]
        assert file["ledger/wall_work_J"].attrs["units"] == "J"
        assert file["ledger/wall_work_J"][-1] == pytest.approx(summary["ledger_J"]["wall_work"])
        normal = file["collisions/normal_J"][:].sum()
        assert normal / summary["window_s"] == pytest.approx(summary["power_W"]["normal"], rel=1e-3)
        assert file["occupancy/count"][:].sum() > 0
        assert (file["occupancy/granular_temperature"][:][file["occupancy/count"][:] > 5] >= 0).all()
    assert [rule["name"] for rule in summary["collisions"]] == [rule.name for rule in DEFAULT_RULES]
    for rule in summary["collisions"]:
        kept = rule["frequency_hz"] * rule["mean_normal_J"]
        assert kept == pytest.approx(summary["power_W"]["normal"], rel=1e-3)


def test_the_ledger_is_a_series_finer_than_a_revolution_and_sums_to_it(files):
    """A window of 2.25 revolutions at 300 rpm: the quarter is in the series and in no revolution."""
    summary = read_json(files / "summary.json")
    with h5py.File(files / "run.h5") as file:
        ledger = {name: dataset[:] for name, dataset in file["ledger"].items()}
    samples = DEM.ledger_samples_per_revolution
    assert summary["revolutions"] == pytest.approx(2.25)
    assert len(ledger["time_s"]) == 1 + 2.25 * samples
    assert np.diff(ledger["time_s"]) == pytest.approx(0.2 / samples)
    tangential = ledger["tangential_damping_J"] + ledger["sliding_J"]
    series = {"normal_J": ledger["normal_damping_J"], "tangential_J": tangential, "wall_J": ledger["wall_work_J"]}
    assert set(summary["per_revolution"]) == set(series)
    for name, values in series.items():
        turns = values[[0, samples, 2 * samples]]
        assert summary["per_revolution"][name] == pytest.approx(np.diff(turns).tolist())
    balance = ledger["wall_work_J"] + ledger["gravity_work_J"] - ledger["imbalance_J"]
    for name in ("normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"):
        balance -= ledger[name]
    for name in ("kinetic_J", "elastic_J"):
        balance -= ledger[name] - ledger[name][0]
    assert balance == pytest.approx(0.0, abs=1e-12)


def test_the_channels_of_the_summary_balance(files):
    summary = read_json(files / "summary.json")
    ledger = summary["ledger_J"]
    assert list(ledger) == sorted(LEDGER_CHANNELS)
    spent = sum(ledger[name] for name in ("normal_damping", "tangential_damping", "sliding", "rolling"))
    stored = ledger["kinetic_change"] + ledger["elastic_change"]
    assert ledger["wall_work"] + ledger["gravity_work"] - spent - stored == pytest.approx(
        ledger["imbalance"], abs=1e-12
    )
    assert summary["closure"] == pytest.approx(abs(ledger["imbalance"]) / ledger["wall_work"])


def test_every_key_of_a_summary_is_documented(files):
    text = (CONFIG.parent / "workflow/outputs.md").read_text()
    summary = read_json(files / "summary.json")
    assert [key for key in [*summary, *summary["collisions"][0]] if f"`{key}`" not in text] == []


def test_an_open_balance_fails_the_run_and_leaves_no_file(tmp_path):
    with pytest.raises(SimulationError, match=r"energy balance is open by .*closure_max .* time_step_s smaller"):
        run(tmp_path, DEM.model_copy(update={"closure_max": 1e-9}))
    assert list(tmp_path.iterdir()) == []


def test_a_case_has_its_own_bound_on_the_balance(tmp_path):
    strict = DEM.model_copy(update={"closure_max": 1e-9})
    assert run(tmp_path, strict, closure_max=0.02)["closure"] < 0.02


def test_a_step_by_the_rayleigh_time_is_shortened_until_the_balance_closes(tmp_path):
    open_case = {"rayleigh_fraction": 0.1, "rayleigh_fraction_max": 0.4}
    found = run(tmp_path, closure_max=1.0, **open_case)
    largest = 0.6 * found["closure"]
    shorter = run(tmp_path, closure_max=largest, **open_case)
    assert shorter["closure"] <= largest
    assert shorter["rayleigh_fraction"] == pytest.approx(0.1 * (0.6 * AIM) ** 0.5, rel=0.02)
    # Both files say which step was taken, and nothing is left of the first attempt.
    with h5py.File(tmp_path / "run.h5") as file:
        assert json.loads(file.attrs["config"])["case"] == shorter["case"]
    assert {path.name for path in tmp_path.iterdir()} == {"run.h5", "summary.json"}
    with pytest.raises(SimulationError, match="energy balance is open"):
        run(tmp_path, closure_max=1e-9, **open_case)


def test_a_long_table_becomes_histograms_of_the_same_contacts(files, tmp_path):
    """The same run with room for no row: every contact is in a bin, and the summary counts them as before."""
    small = run(tmp_path, DEM.model_copy(update={"collision_rows_max": 10}), window_s=0.45, snapshot_interval_s=1e-3)
    with h5py.File(files / "run.h5") as whole, h5py.File(tmp_path / "run.h5") as binned:
        table, group = whole["collisions"], binned["collisions"]
        assert not table.attrs["is_histogram"] and group.attrs["is_histogram"]
        assert group.attrs["rows"] == table.attrs["rows"] == len(table["first"])
        assert "first" not in group
        for name in HISTOGRAM_NAMES:
            values = table[name][:]
            # The table is in single precision, which knows nothing below 1e-45.
            assert (values > 0).sum() <= group[f"{name}_histogram_counts"][:].sum() <= len(values)
            # Edges are kept in double precision, the table in single.
            edges = group[f"{name}_histogram_edges"][:]
            assert edges[-1] == pytest.approx(values.max(), rel=1e-6)
            assert RANGE * values.max() * 0.999 < edges[0] <= values[values > 0].min() * 1.001
    assert small["collisions"] == read_json(files / "summary.json")["collisions"]


def test_snapshots_hold_the_work_and_the_contacts(files):
    with h5py.File(files / "run.h5") as file:
        snapshots = {name: dataset[:] for name, dataset in file["snapshots"].items()}
        ledger = {name: dataset[:] for name, dataset in file["ledger"].items()}
    assert np.diff(snapshots["time_s"]) == pytest.approx(1e-3)
    assert len(snapshots["time_s"]) == 451
    assert snapshots["normal_J"].sum() == pytest.approx(ledger["normal_damping_J"][-1], rel=1e-6)
    tangential = ledger["tangential_damping_J"][-1] + ledger["sliding_J"][-1]
    assert snapshots["tangential_J"].sum() == pytest.approx(tangential, rel=1e-6)
    assert snapshots["contact_offset"][-1] == len(snapshots["contact_first"])
    # Two balls in contact are nearer than a diameter (or have just come apart).
    for m in (50, 300):
        rows = slice(*snapshots["contact_offset"][m : m + 2])
        first, second = snapshots["contact_first"][rows], snapshots["contact_second"][rows]
        pairs = second >= 0
        away = snapshots["position_m"][m, first[pairs]] - snapshots["position_m"][m, second[pairs]]
        assert (np.linalg.norm(away, axis=1) < 0.01).all()
    assert np.abs(snapshots["body_position_m"][:, 2]).max() == 0
