"""Speed limits: accelerations in closed form, refusals and warnings."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from millprint.cases.of_mill import mill_cases
from millprint.config.checks import load_workflow
from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import Agitation
from millprint.fingerprint.sweep_checks import check_speeds, speed_settings, speed_warnings, with_paces
from millprint.mill.bodies import build_bodies
from millprint.mill.speed_limits import BOUNDS, paces
from tests.conftest import configuration
from tests.refusals import refusal

ROOT = Path(__file__).parents[2]
W = 2 * math.pi
DRUM = {"kind": "cylinder", "radius_mm": 50, "height_mm": 40, "axis": "y", "facets": 48, "fillet_ends": "none"}
JAR = {"kind": "cylinder", "radius_mm": 30, "height_mm": 40, "facets": 48, "fillet_ends": "none"}


def paces_of(geometry: dict, motion: dict, inserts=()) -> list:
    mill = MillConfig(
        name="made", title="made", source="made", volume_ml=1, geometry=geometry, motion=motion, inserts=list(inserts)
    )
    return paces(mill, build_bodies(mill))


@pytest.mark.parametrize(
    ("geometry", "motion", "speed", "acceleration"),
    [
        (JAR, {"kind": "circle", "amplitude_mm": 17}, 0.017 * W, 0.017 * W**2),
        (DRUM, {"kind": "rotation", "axis": [0, 1, 0]}, 0.05 * W, 0.05 * W**2),
        (DRUM, {"kind": "rotation", "axis": [0, 1, 0], "ratio": -3}, 0.15 * W, 0.45 * W**2),
        # The jar turns back at the sun wheel's speed, seen from the laboratory: its wall adds r w^2 and r w.
        (JAR, {"kind": "planetary", "sun_radius_mm": 70, "ratio": -2}, 0.1 * W, 0.1 * W**2),
        (JAR, {"kind": "planetary", "sun_radius_mm": 70, "ratio": 2}, (0.07 + 0.09) * W, (0.07 + 0.27) * W**2),
        # A small angle on a long arm: to and fro, and twice as often.
        (
            JAR,
            {"kind": "swing", "axis": [0, 0, 1], "pivot_mm": [0, -5000, 0], "amplitude_deg": 0.3, "multiple": 2},
            2 * W * math.radians(0.3) * 5.03,
            4 * W**2 * math.radians(0.3) * 5.03,
        ),
        (JAR, {"kind": "lissajous", "terms": [{"axis": "x", "amplitude_mm": 2, "multiple": 200}]}, 0.4 * W, 80 * W**2),
        (JAR, {"kind": "rest"}, 0.0, 0.0),
    ],
)
def test_the_fastest_wall_in_closed_form(geometry, motion, speed, acceleration):
    (pace,) = paces_of(geometry, motion)
    assert pace.speed == pytest.approx(speed, rel=2e-3)
    assert pace.acceleration == pytest.approx(acceleration, rel=2e-3)


def test_a_table_of_points_moves_as_the_law_that_it_samples(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    turn = np.linspace(0, 1, 73)
    x, y = 0.017 * np.cos(W * turn), 0.017 * np.sin(W * turn)
    pd.DataFrame({"time_s": turn, "x_m": x, "y_m": y, "z_m": 0.0}).to_csv("turn.tsv", sep="\t", index=False)
    (pace,) = paces_of(JAR, {"kind": "points", "path": "turn.tsv"})
    assert pace.acceleration == pytest.approx(0.017 * W**2, rel=5e-3)


def test_the_bounds_of_a_stirrer_are_on_the_speed_of_its_tip():
    rod = {"kind": "box", "x_mm": 40, "y_mm": 4, "z_mm": 4, "centre_mm": [0, 0, 20]}
    turning = {"kind": "rotation", "axis": [0, 0, 1]}
    tank, stirrer = paces_of(JAR, {"kind": "rest"}, [{"name": "rod", "geometry": rod, "motion": turning}])
    assert tank.speed_at(BOUNDS[Agitation.SHAKEN].most) == math.inf
    tip = math.hypot(0.02, 0.002)
    assert stirrer.bounds is BOUNDS[Agitation.STIRRED]
    assert stirrer.speed_at(BOUNDS[Agitation.STIRRED].most) == pytest.approx(250 / (W * tip))
    # A baffle that turns with its drum is part of the drum.
    drum, baffle = paces_of(JAR, turning, [{"name": "rod", "geometry": rod}])
    assert drum.bounds is baffle.bounds is BOUNDS[Agitation.TUMBLED]
    assert drum.speed_at(BOUNDS[Agitation.TUMBLED].most) == pytest.approx(0.5 / math.pi * math.sqrt(1e5 * 9.81 / 0.03))


def warnings_of(changes=None) -> list[str]:
    """Warnings of the thesis's configuration with changed sections; raises ConfigError for what is refused."""
    content = configuration() | (changes or {})
    config, mills, _, cases = load_workflow(content, ["config/config.yaml"])
    swept = {name: mill_cases(mills[name], config.mills) for name in {config.mill, *config.mills.named}}
    settings = speed_settings(config, mills, swept, cases, "config/config.yaml")
    bodies = {setting.mill.name: build_bodies(mills[setting.mill.name]) for setting in settings}
    pairs = with_paces(settings, bodies)
    check_speeds(pairs)
    return speed_warnings(pairs)


SWEEP = {
    "name": "fast", "mills": ["emax"], "contacts": ["steel"], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2],
    "seeds": [0, 1],
}  # fmt: skip


def test_a_sweep_warns_and_refuses_by_its_own_amplitude(monkeypatch):
    """At 2500 rpm the Emax's 17 mm are 119 g, 50 mm 349 g and 150 mm 1048 g: one line each, for whatever many cases."""
    monkeypatch.chdir(ROOT)
    (line,) = warnings_of({"sweeps": [{**SWEEP, "speeds_rpm": [2500], "amplitudes_mm": [17, 50]}]})
    assert line.startswith(
        "config/config.yaml: sweeps: mill emax with amplitudes_mm = 50: speeds_rpm = 2500: the wall of vessel would "
        "have an acceleration of 349 g and move at 13.1 m/s; "
    )
    assert line.endswith("; usual speeds go up to 1630 rpm")
    line = refusal(warnings_of, {"sweeps": [{**SWEEP, "speeds_rpm": [2500], "amplitudes_mm": [50, 150]}]})
    for part in ("amplitudes_mm = 150: speeds_rpm = 2500: ", "1050 g", "over 1000 g: at most 2440 rpm"):
        assert part in line


def test_a_speed_in_the_wrong_unit_is_warned_of(monkeypatch):
    """10 Hz typed as 10 rpm: 17 mm are then 0.0019 g."""
    monkeypatch.chdir(ROOT)
    (line,) = warnings_of({"sweeps": [{**SWEEP, "speeds_rpm": [10, 600]}]})
    assert "speeds_rpm = 10: " in line and "0.0019 g" in line and line.endswith("Write it under speeds_hz")


@pytest.mark.parametrize("sizes_mm", [[10], [10, 12], [12, 10]])
def test_a_drum_above_its_critical_speed_is_warned_of(sizes_mm, monkeypatch):
    """w^2 (R - r) = g, with the drum's 50 mm and the smallest ball's radius of 5 mm."""
    monkeypatch.chdir(ROOT)
    critical = 30 / math.pi * math.sqrt(9.80665 / (0.05 - 0.005))
    above, below = (factor * critical for factor in (1.01, 0.99))
    sweep = {**SWEEP, "mills": ["drum"], "ball_diameters_mm": sizes_mm, "speeds_rpm": [above, below]}
    (line,) = warnings_of({"sweeps": [sweep]})
    assert f"mill drum: speeds_rpm = {above:g}: " in line
    assert f"critical speed on, {math.floor(critical)} rpm" in line
