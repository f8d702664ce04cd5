"""Bodies that turn: derivatives, rigidity, known accelerations, and kernels that agree with the objects."""

from typing import Literal

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from millprint.config.motion_kinds import Motion as Law
from millprint.config.motion_kinds import MotionSection
from millprint.mill.motion import motion_from_law, stack_motions
from tests.poses import angular_velocity, poses_at, velocity

SPEED_RPM = 300.0
W = 2 * np.pi * SPEED_RPM / 60
TIME = np.linspace(0.001, 0.6, 173)

LAWS = {
    "circle": {"kind": "circle", "amplitude_mm": 17},
    "drum": {"kind": "rotation", "axis": [0, 1, 0]},
    "arm": {"kind": "rotation", "axis": [1, -2, 0.5], "pivot_mm": [30, -10, 20], "ratio": -1.7},
    "planetary": {"kind": "planetary", "sun_radius_mm": 70, "ratio": -2.2},
    "shaker": {
        "kind": "swing",
        "axis": [0.2, 0, 1],
        "pivot_mm": [0, -90, 5],
        "amplitude_deg": 12,
        "multiple": 2,
        "phase_deg": 35,
        "terms": [{"axis": "x", "amplitude_mm": 25}, {"axis": "z", "amplitude_mm": 5, "multiple": 3, "phase_deg": 90}],
    },
    "shake": {"kind": "lissajous", "terms": [{"axis": "y", "amplitude_mm": 17, "multiple": 2, "phase_deg": 30}]},
    "figure of eight": {"kind": "figure_of_eight", "along_mm": 30, "across_mm": 8, "plane": "yz"},
    "rest": {"kind": "rest"},
}


def motion(name: str, **changes):
    return motion_from_law(TypeAdapter(Law).validate_python({**LAWS[name], **changes}), SPEED_RPM / 60)


def rate(function, time_s: np.ndarray) -> np.ndarray:
    """Derivative by central differences of fourth order."""
    h = 1e-5
    near, far = (function(time_s + k * h) - function(time_s - k * h) for k in (1, 2))
    return (8 * near - far) / (12 * h)


@pytest.mark.parametrize("name", LAWS)
def test_velocities_are_the_rates_of_change_of_the_pose(name):
    made = motion(name)
    assert velocity(made, TIME) == pytest.approx(rate(made.position, TIME), abs=1e-6)
    spin = rate(made.rotation, TIME) @ np.swapaxes(made.rotation(TIME), -1, -2)
    vector = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
    assert angular_velocity(made, TIME) == pytest.approx(vector, abs=1e-6)


@pytest.mark.parametrize("name", LAWS)
def test_a_rotation_keeps_lengths_and_handedness(name):
    rotation = motion(name).rotation(TIME)
    product = rotation @ np.swapaxes(rotation, -1, -2)
    assert product == pytest.approx(np.broadcast_to(np.eye(3), product.shape), abs=1e-14)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_a_point_keeps_its_distance_from_the_pivot_and_its_height_along_the_axis():
    made, point = motion("arm"), np.array([0.011, 0.02, -0.03])
    pivot, axis = np.array([0.03, -0.01, 0.02]), np.array([1, -2, 0.5]) / np.linalg.norm([1, -2, 0.5])
    away = made.position(TIME) + made.rotation(TIME) @ point - pivot
    assert np.linalg.norm(away, axis=1) == pytest.approx(np.linalg.norm(point - pivot))
    assert away @ axis == pytest.approx((point - pivot) @ axis)
    assert np.linalg.norm(np.diff(away, axis=0), axis=1).min() > 1e-4


def test_a_drum_turns_counter_clockwise_about_its_axis():
    quarter = motion("drum").rotation(0.25 / (SPEED_RPM / 60))
    assert quarter @ [0, 0, 1] == pytest.approx([1, 0, 0], abs=1e-12)


@pytest.mark.parametrize("ratio", [-2.2, -1.0, 0.1, 1.5])
def test_a_planetary_jar_has_the_acceleration_of_its_two_rotations(ratio):
    """A point at angle phi0 of the jar's wall is accelerated towards the sun's axis and towards the jar's axis."""
    made, sun, point = motion("planetary", ratio=ratio), 0.07, np.array([0.02, 0.01, 0.03])

    def place(time_s):
        return made.position(time_s) + made.rotation(time_s) @ point

    found = rate(lambda t: rate(place, t), TIME)
    spin = (1 + ratio) * W
    phase, radius = np.arctan2(point[1], point[0]), np.hypot(point[0], point[1])
    expected = -np.column_stack(
        [
            sun * W**2 * np.cos(W * TIME) + radius * spin**2 * np.cos(spin * TIME + phase),
            sun * W**2 * np.sin(W * TIME) + radius * spin**2 * np.sin(spin * TIME + phase),
            0 * TIME,
        ]
    )
    assert found == pytest.approx(expected, abs=1e-4 * W**2 * sun)


def test_a_counter_rotation_of_one_does_not_turn_the_jar():
    made = motion("planetary", ratio=-1)
    assert not made.turns
    assert made.position(TIME) == pytest.approx(motion("circle", amplitude_mm=70).position(TIME))


def test_a_figure_of_eight_crosses_its_middle_twice_a_turn_and_repeats():
    made, turn = motion("figure of eight"), 60 / SPEED_RPM
    assert made.position(np.array([0.0, 0.5, 1.0]) * turn) == pytest.approx(np.zeros((3, 3)), abs=1e-15)
    # Through the middle it goes one way along the figure, then the other, and both times up across it.
    speeds = velocity(made, np.array([0.0, 0.5]) * turn)
    assert speeds == pytest.approx(W * np.array([[0, 0.03, 0.016], [0, -0.03, 0.016]]))
    x, y, z = made.position(TIME).T
    assert not x.any() and not made.turns
    # The curve itself: (z / B)^2 = 4 (y / A)^2 (1 - (y / A)^2).
    share = (y / 0.03) ** 2
    assert (z / 0.008) ** 2 == pytest.approx(4 * share * (1 - share), abs=1e-12)
    assert motion("figure of eight", plane="xy").position(0.25 * turn) == pytest.approx([0.03, 0, 0], abs=1e-15)


def test_a_swing_stays_within_its_amplitude():
    angle = motion("shaker").angle(np.linspace(0, 0.2, 4001))
    assert np.degrees([angle.min(), angle.max()]) == pytest.approx([-12, 12], abs=1e-4)


def test_the_kernel_moves_several_bodies_as_the_objects_say():
    made = [*(motion(name) for name in LAWS), motion("shaker").at_rest()]
    stacked = stack_motions(made)
    for time in (-0.3, 0.0, 0.0123, 0.37):
        poses_at(stacked, time)
        for pose, body in zip(stacked.pose, made, strict=True):
            assert pose[:3] == pytest.approx(body.position(time), abs=1e-15)
            assert pose[9:] == pytest.approx(body.rotation(time).ravel(), abs=1e-15)


@pytest.mark.parametrize("name", LAWS)
def test_before_the_start_a_body_rests_at_the_beginning_of_its_motion(name):
    made = motion(name)
    for still, time in ((made, -0.2), (made.at_rest(), -0.2), (made.at_rest(), 0.3)):
        assert still.position(time) == pytest.approx(made.position(0.0), abs=1e-15)
        assert still.rotation(time) == pytest.approx(made.rotation(0.0), abs=1e-15)
        assert not velocity(still, time).any()
        assert not angular_velocity(still, time).any()
        stacked = stack_motions([still])
        assert stacked.pose[0, 9:] == pytest.approx(made.rotation(0.0).ravel(), abs=1e-15)


class TeleportMotion(MotionSection):
    """A motion that is not registered."""

    kind: Literal["teleport"] = "teleport"


def test_a_motion_that_is_not_in_the_registry_is_refused():
    with pytest.raises(KeyError, match="'teleport'"):
        motion_from_law(TeleportMotion(), SPEED_RPM / 60)
    with pytest.raises(ValidationError, match="'teleport' found using 'kind' does not match any of the expected tags"):
        motion("rest", kind="teleport")
