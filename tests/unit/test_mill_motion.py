"""Motions against the thesis's equations."""

from pathlib import Path

import numpy as np
import pytest

from millprint.config.errors import ConfigError
from millprint.config.load import check_model, load_named, read_yaml
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import MOTIONS, STILL
from millprint.mill.motion import motion_from_law, stack_motions
from tests.poses import poses_at, velocity

MILLS = Path(__file__).parents[2] / "config/mills"
TIME = np.linspace(0, 0.4, 201)


def motion(name: str, speed: float = 300):
    return motion_from_law(load_named(MILLS, name, MillConfig, "mill").motion, speed / 60)


def test_circle():
    w = 2 * np.pi * 10
    expected = 0.017 * np.column_stack([np.cos(w * TIME), np.sin(w * TIME), 0 * TIME])
    assert motion("emax", 600).position(TIME) == pytest.approx(expected, abs=1e-15)


def test_motion_1_is_equation_6_34():
    a, b = 10 * np.pi * TIME, 20 * np.pi * TIME
    x, z = 1.7 * np.sin(a) - 0.85 * np.cos(b), 1.7 * np.cos(a) - 0.85 * np.sin(b)
    assert motion("emax_motion1").position(TIME) == pytest.approx(np.column_stack([x, z, 0 * x]) / 100, abs=1e-15)


def test_motion_2_is_equation_6_35():
    x, z = 1.7 * np.sin(10 * np.pi * TIME), 1.7 * np.cos(20 * np.pi * TIME)
    assert motion("emax_motion2").position(TIME) == pytest.approx(np.column_stack([x, z, 0 * x]) / 100, abs=1e-15)


def test_the_kernel_moves_as_the_object_says():
    for made in (motion("emax"), motion("emax_motion1"), motion("emax").at_rest()):
        motions = stack_motions([made])
        for time in (0.0, 0.0123, 0.3):
            poses_at(motions, time)
            assert motions.pose[0, :3] == pytest.approx(made.position(time), abs=1e-15)


def test_before_the_start_the_vessel_rests_where_the_motion_begins():
    made = motion("emax")
    assert made.position(-1.0) == pytest.approx(made.position(0.0))
    assert velocity(made, -1.0) == pytest.approx(np.zeros(3))
    assert np.linalg.norm(velocity(made, 0.0)) == pytest.approx(0.017 * 10 * np.pi)
    assert velocity(made.at_rest(), 0.5) == pytest.approx(np.zeros(3))
    assert velocity(motion("emax", 0), 0.5) == pytest.approx(np.zeros(3))


AT_ZERO = [
    ({"kind": "circle", "amplitude_mm": 0}, "amplitude_mm = 0"),
    ({"kind": "planetary", "sun_radius_mm": 0.0, "ratio": -2}, "sun_radius_mm = 0"),
    ({"kind": "figure_of_eight", "along_mm": 0, "across_mm": 3}, "along_mm = 0"),
    ({"kind": "figure_of_eight", "along_mm": 9, "across_mm": 0}, "across_mm = 0"),
    ({"kind": "swing", "axis": [1, 0, 0], "pivot_mm": [0, 0, 0], "amplitude_deg": 0}, "amplitude_deg = 0"),
    ({"kind": "rotation", "axis": [0, 1, 0], "ratio": 0}, "ratio = 0"),
    ({"kind": "lissajous", "terms": [{"axis": "x", "amplitude_mm": 0}]}, "terms: the amplitudes add up to 0"),
    (
        {"kind": "lissajous", "terms": [{"axis": "z", "amplitude_mm": 4}, {"axis": "z", "amplitude_mm": -4}]},
        "terms: the amplitudes add up to 0",
    ),
]


@pytest.mark.parametrize(("law", "found"), AT_ZERO, ids=[f"{law['kind']} {found}" for law, found in AT_ZERO])
def test_a_motion_that_does_not_move_is_refused_with_file_key_and_value(law, found):
    values = read_yaml(MILLS / "emax.yaml") | {"motion": law}
    with pytest.raises(ConfigError) as caught:
        check_model(values, MillConfig, "config/mills/emax.yaml")
    (line,) = str(caught.value).splitlines()
    assert line == f"config/mills/emax.yaml: motion: {found}: {STILL}"


def test_every_kind_of_motion_is_refused_at_zero_or_rests_or_comes_from_a_table():
    assert {law["kind"] for law, _ in AT_ZERO} == set(MOTIONS) - {"rest", "points"}
