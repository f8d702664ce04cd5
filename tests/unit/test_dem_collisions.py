"""The counting rule of collisions on a hand-made table, and the files of a run."""

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from millprint.config.contact import ContactConfig
from millprint.config.load import load_named
from millprint.config.mill import MillConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.collisions import collision_statistics, collision_table, group_collisions
from millprint.dem.modulus import modulus_table
from millprint.dem.run import run_case
from millprint.files import read_json

CONFIG = Path(__file__).parents[2] / "config"


def table():
    """Pair (0, 1) touches at 0, 2 and 7 ms for 1 ms each, ball 0 and facet 3 once, a pair before the window once."""
    first = np.array([0, 0, 0, 0, 2])
    second = np.array([1, 1, -4, 1, 5])
    start = np.array([0.000, 0.002, 0.0005, 0.007, -0.001])
    value = np.zeros((5, 9))
    value[:, 0], value[:, 1] = start, 0.001
    value[:, 5], value[:, 6], value[:, 7] = 1.0, 0.25, 2.0
    return collision_table(first, second, np.ones(5), value)


@pytest.mark.parametrize(("gap", "count"), [(0.0, 4), (0.0005, 4), (0.0015, 3), (0.005, 2)])
def test_contacts_of_a_pair_within_the_gap_are_one_collision(gap, count):
    (row,) = collision_statistics(table(), [gap], begin_s=0.0, window_s=0.5)
    assert row["count"] == count
    assert row["frequency_hz"] == pytest.approx(count / 0.5)
    assert row["mean_normal_J"] == pytest.approx(5.0 / count)
    assert row["mean_tangential_J"] == pytest.approx(10.0 / count)


def test_sliding_is_what_damping_leaves_of_the_tangential_work():
    assert table()["sliding_J"].to_numpy() == pytest.approx(1.75)


def test_other_pairs_never_join():
    groups = group_collisions(table(), 1.0)
    assert len(np.unique(groups)) == 3


def test_no_contacts_at_all():
    empty = collision_table(*(np.empty(0, int),) * 3, np.empty((0, 9)))
    (row,) = collision_statistics(empty, [0.003], 0.0, 1.0)
    assert row == {"gap_s": 0.003, "count": 0, "frequency_hz": 0.0, "mean_normal_J": 0.0, "mean_tangential_J": 0.0}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    case = Case(
        mill="emax", contact="calibrated", ball_diameter_mm=10, fill_ratio=0.1, speed_rpm=300, seed=0,
        settle_s=0.05, discard_s=0.0, window_s=0.4, snapshot_interval_s=1e-3,
    )  # fmt: skip
    dem = DemConfig(time_step_s=4e-6, settle_s=0.1, discard_s=0.1, window_s=0.1)
    mill = load_named(CONFIG / "mills", "emax", MillConfig, "mill")
    contact = load_named(CONFIG / "contacts", "calibrated", ContactConfig, "contact set")
    run_case(case, mill, contact, dem, folder / "run.h5", folder / "summary.json")
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
    assert summary["revolutions"] == pytest.approx(2)
    assert len(summary["per_revolution"]["normal_J"]) == 2
    assert sum(summary["per_revolution"]["wall_J"]) == pytest.approx(summary["ledger_J"]["wall_work"])


def test_snapshots_hold_the_work_and_the_contacts(files):
    with h5py.File(files / "run.h5") as file:
        snapshots = {name: dataset[:] for name, dataset in file["snapshots"].items()}
        ledger = {name: dataset[:] for name, dataset in file["ledger"].items()}
    assert np.diff(snapshots["time_s"]) == pytest.approx(1e-3)
    assert len(snapshots["time_s"]) == 401
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


def test_modulus_table(files):
    summary = read_json(files / "summary.json")
    frame = modulus_table([summary, {**summary, "young_modulus_pa": 205e9}])
    assert frame["young_modulus_gpa"].tolist() == [205, 2.05]
    power = summary["power_W"]["normal"] + summary["power_W"]["tangential"]
    assert frame["power_W"].iloc[0] == pytest.approx(power, rel=1e-6)
