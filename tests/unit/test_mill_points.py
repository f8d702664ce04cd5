"""A motion as a table of points: a smooth, periodic curve through the points, and refusals of bad tables."""

import numpy as np
import pandas as pd
import pytest
from pydantic import TypeAdapter
from scipy.spatial.transform import Rotation

from millprint.config.errors import ConfigError
from millprint.config.motion_kinds import Motion as Law
from millprint.mill.motion import motion_from_law, stack_motions
from tests.poses import angular_velocity, poses_at, velocity
from tests.refusals import refusal

RPM, ROWS = 300.0, 73
W = 2 * np.pi * RPM / 60


def planetary_table() -> pd.DataFrame:
    """A jar on a sun wheel of 70 mm at ratio -2.5: it turns by -1.5 a turn about z, so its pose repeats in two."""
    turn = np.linspace(0, 2, 2 * ROWS - 1)
    table = pd.DataFrame({"time_s": 3.0 + 0.2 * turn})
    table["x_m"], table["y_m"], table["z_m"] = 0.07 * np.cos(2 * np.pi * turn), 0.07 * np.sin(2 * np.pi * turn), 0.0
    table["rotation_x_deg"] = table["rotation_y_deg"] = 0.0
    # Any angle of the same rotation is allowed.
    table["rotation_z_deg"] = (-1.5 * 360 * turn) % 360
    return table


def read(table: pd.DataFrame, folder, rpm: float = RPM / 2):
    table.to_csv(folder / "motion.tsv", sep="\t", index=False)
    return motion_from_law(TypeAdapter(Law).validate_python({"kind": "points", "path": "motion.tsv"}), rpm / 60)


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_a_table_of_a_planetary_motion_is_that_motion(tmp_path):
    made = read(planetary_table(), tmp_path)
    law = {"kind": "planetary", "sun_radius_mm": 70, "ratio": -2.5}
    exact = motion_from_law(TypeAdapter(Law).validate_python(law), RPM / 60)
    time = np.linspace(0, 1.7, 301)
    assert made.position(time) == pytest.approx(exact.position(time), abs=1e-6)
    assert velocity(made, time) == pytest.approx(velocity(exact, time), abs=1e-4)
    assert made.rotation(time) == pytest.approx(exact.rotation(time), abs=2e-5)
    assert angular_velocity(made, time) == pytest.approx(angular_velocity(exact, time), abs=1e-2)
    assert made.turns


def test_an_odd_number_of_turns_comes_back_with_the_other_sign_and_goes_on_smoothly(tmp_path):
    """After one whole turn the quaternion has the opposite sign, so the curve covers two turns."""
    turn = np.linspace(0, 1, ROWS)
    table = pd.DataFrame({"time_s": turn, "x_m": 0.0, "y_m": 0.0, "z_m": 0.01 * np.sin(2 * np.pi * turn)})
    axis = np.array([1.0, 2.0, 2.0]) / 3
    for k, name in enumerate("xyz"):
        table[f"rotation_{name}_deg"] = 360 * turn * axis[k]
    made = read(table, tmp_path, 60)
    time = np.linspace(0, 3.3, 400)
    assert made.breaks[-1] == pytest.approx(2)
    assert angular_velocity(made, time) == pytest.approx(np.tile(2 * np.pi * axis, (400, 1)), abs=1e-4)
    expected = Rotation.from_rotvec(2 * np.pi * time[:, None] * axis).as_matrix()
    assert made.rotation(time) == pytest.approx(expected, abs=1e-6)


def test_velocities_are_the_rates_of_a_rotation_about_a_moving_axis(tmp_path):
    turn = np.linspace(0, 1, ROWS)
    phase = 2 * np.pi * turn
    table = pd.DataFrame({"time_s": turn, "x_m": 0.02 * np.cos(phase), "y_m": 0.01 * np.sin(2 * phase), "z_m": 0.0})
    for name, value in zip("xyz", (20 * np.sin(phase), 15 * np.cos(phase), 10 * np.sin(2 * phase)), strict=True):
        table[f"rotation_{name}_deg"] = value
    made, h = read(table, tmp_path, 300), 1e-6
    time = np.linspace(0.01, 0.5, 97)
    along = (made.position(time + h) - made.position(time - h)) / (2 * h)
    assert velocity(made, time) == pytest.approx(along, abs=1e-5)
    rates = (made.rotation(time + h) - made.rotation(time - h)) / (2 * h) @ np.swapaxes(made.rotation(time), -1, -2)
    vector = np.stack([rates[:, 2, 1], rates[:, 0, 2], rates[:, 1, 0]], axis=-1)
    assert angular_velocity(made, time) == pytest.approx(vector, abs=1e-4)


def test_the_kernel_gives_the_poses_of_the_object(tmp_path):
    made = read(planetary_table(), tmp_path)
    for moving in (made, made.at_rest()):
        motions = stack_motions(
            [
                read(planetary_table().drop(columns=["rotation_x_deg", "rotation_y_deg", "rotation_z_deg"]), tmp_path),
                moving,
            ]
        )
        for time in (-0.5, 0.0, 0.0123, 0.3999, 0.4, 1.234):
            poses_at(motions, time)
            pose = motions.pose[1]
            assert pose[:3] == pytest.approx(moving.position(time), abs=1e-14)
            assert pose[9:] == pytest.approx(moving.rotation(time).ravel(), abs=1e-13)
            assert motions.pose[0, 9:] == pytest.approx(np.eye(3).ravel())


def test_speed_and_acceleration_do_not_jump_where_the_table_ends(tmp_path):
    made = read(planetary_table(), tmp_path)
    before, after = (velocity(made, np.array([0.4 + step])) for step in (-1e-7, 1e-7))
    assert after == pytest.approx(before, abs=2e-5)
    rates = [(velocity(made, np.array([t + 1e-6])) - velocity(made, np.array([t]))) / 1e-6 for t in (0.399, 0.401)]
    assert np.linalg.norm(rates[0]) == pytest.approx(0.07 * W**2, rel=1e-2)
    assert np.linalg.norm(rates[1]) == pytest.approx(0.07 * W**2, rel=1e-2)


def changed(**columns) -> pd.DataFrame:
    table = planetary_table()
    for place, value in columns.items():
        name, row = place.rsplit("__", 1)
        table[name] = table[name].astype(object)
        table.loc[int(row), name] = value
    return table


@pytest.mark.parametrize(
    ("table", "parts"),
    [
        (changed(time_s__20=3.0), ["column time_s, row 21 = 3", "must rise"]),
        (planetary_table().drop(index=range(30, 45)), ["column time_s, row 31", "gap"]),
        (planetary_table().iloc[:-3], ["last row", "not the first"]),
        (planetary_table().iloc[::24], ["7 rows", "9 at least"]),
        (planetary_table().iloc[::12], ["rotation_*_deg, row ", "turn by 90 degrees"]),
        (changed(x_m__5=70.0), ["column x_m, row 6 = 70", "10 m"]),
        (changed(x_m__5="nan"), ["column x_m, row 6", "finite number"]),
        (changed(y_m__5="wide"), ["column y_m, row 6", "wide"]),
        (changed(rotation_z_deg__5="inf"), ["column rotation_z_deg, row 6", "finite number"]),
        (changed(rotation_z_deg__144=12.0), ["rotation_*_deg", "last row is not the first"]),
        (planetary_table().drop(columns="rotation_x_deg"), ["rotation_x_deg is missing", "three columns"]),
        (planetary_table().drop(columns="z_m"), ["column z_m is missing"]),
    ],
)
def test_a_table_that_is_not_one_turn_is_refused_in_one_line(tmp_path, table, parts):
    line = refusal(read, table, tmp_path)
    for part in ["motion.tsv", *parts]:
        assert part in line


def test_a_table_without_a_motion_is_refused(tmp_path):
    table = planetary_table().assign(x_m=0.01, y_m=0.0, rotation_z_deg=0.0)
    with pytest.raises(ConfigError, match=r"motion.tsv: all rows have the same place: nothing would move; give the"):
        read(table, tmp_path)
