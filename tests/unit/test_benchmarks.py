"""The benchmark: input of LAMMPS from the configuration, its log, and the tables of both codes."""

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from benchmarks import drums, physics
from benchmarks.cases import Setup, box_jar, cylinder_jar, make_setup
from benchmarks.compare import spread, summarise
from benchmarks.config import BenchConfig
from benchmarks.lammps import input_text, timing
from millprint.config.errors import SimulationError
from millprint.config.included import load_contact, load_mill
from millprint.config.load import check_model, read_yaml
from millprint.dem.lammps.lammps_case import read_log
from millprint.dem.simulation import Simulation

ROOT = Path(__file__).parents[2]

MILL, CONTACT = load_mill("emax"), load_contact("calibrated")
LOG = (ROOT / "tests/data/lammps.log").read_text()


@pytest.fixture(scope="module")
def config() -> BenchConfig:
    return check_model(read_yaml(ROOT / "benchmarks/bench.yaml"), BenchConfig, "benchmarks/bench.yaml")


@pytest.fixture(scope="module")
def setup(config) -> Setup:
    return make_setup(config, CONTACT, cylinder_jar(config, MILL), 24, 10.0)


def words(text: str, command: str) -> list[str]:
    """The words after the one line of an input that begins with `command`."""
    lines = [line for line in text.splitlines() if line.startswith(command + " ")]
    assert len(lines) == 1
    return lines[0].removeprefix(command).split()


def after(line: list[str], *keys: str) -> list[float]:
    """The numbers that follow some words in a line, up to the next word that is not a number."""
    k = next(k for k in range(len(line)) if line[k : k + len(keys)] == list(keys)) + len(keys)
    return [float(word) for word in itertools.takewhile(lambda word: re.fullmatch(r"[-+.\de]+", word), line[k:])]


def test_compared_input_holds_our_law_in_si(config, setup):
    text = input_text(setup, config.lammps, 1e-6, [1000], with_means=True)
    pair, wall = words(text, "pair_coeff"), words(text, "fix wall")
    law = config.lammps.compared
    stiffness, damping, rolling = law.rolling_stiffness_n_m, law.rolling_damping_ns_m, CONTACT.rolling_friction
    radius = setup.diameter_m / 2
    for line in (pair, wall):
        assert after(line, "hertz/material") == [CONTACT.young_modulus_gpa * 1e9, 0.30, 0.235]
        assert line[line.index("damping") + 1] == "coeff_restitution"
        assert line[line.index("mindlin") + 1] == "NULL"
        # About the normal the lever is the ball's radius.
        twisting = [stiffness * radius**2, damping * radius**2, rolling * radius]
        assert after(line, "twisting", "sds") == pytest.approx(twisting)
    assert after(pair, "mindlin", "NULL")[1] == CONTACT.static_friction
    # LAMMPS's lever is the reduced radius: half the ball's between balls, the ball's own at a wall.
    assert after(pair, "rolling", "sds") == [stiffness, damping, 2 * rolling]
    assert after(wall, "rolling", "sds") == [stiffness, damping, rolling]


def test_means_are_averaged_over_whole_revolutions_of_the_box(config):
    setup = make_setup(config, CONTACT, box_jar(config, MILL), 24, 10.0)
    shape = config.physics.box
    length, width, height = shape.x_mm / 1e3, shape.y_mm / 1e3, shape.z_mm / 1e3
    text = input_text(setup, config.lammps, 1e-6, [300_000, 500_000], with_means=True)
    ends = [-length / 2, length / 2, -width / 2, width / 2, 0, height]
    assert after(words(text, "region jar"), "block") == pytest.approx(ends)
    every, number, revolution = (int(word) for word in words(text, "fix means")[2:5])
    assert every * number == revolution == 100_000
    # Centres nearer to a wall than a radius touch it.
    bounds = dict(re.findall(r"\(([^()<>]+[<>])([^()]+)\)", words(text, "variable walls atom")[0]))
    assert len(bounds) == 6 and float(bounds["x-v_dx<"]) == pytest.approx(-length / 2 + 0.005)
    assert float(bounds["z>"]) == pytest.approx(height - 0.005)
    assert text.index("run 300000") < text.index("fix means") < text.index("run 500000")
    with pytest.raises(SimulationError, match="must be a multiple of 20"):
        input_text(setup, config.lammps, 0.1 / 1001, [1], with_means=True)


def test_log_of_the_last_loop_is_read():
    measured = timing(read_log(LOG))
    assert measured.ns_per_ball_step == pytest.approx(1.2512 / 100_000 / 52 * 1e9)
    assert measured.processor_s == pytest.approx(0.988 * 1.2512)


def test_a_log_without_an_end_is_an_error():
    with pytest.raises(SimulationError, match="ends before the run does"):
        read_log(LOG[: LOG.index("Loop time")])
    with pytest.raises(SimulationError, match="ERROR: Lost atoms"):
        read_log(LOG + "ERROR: Lost atoms: original 24 current 23 (src/thermo.cpp:494)\n")


def test_the_drum_of_lammps_turns_with_all_its_lifters(config):
    mill = load_mill("slice_mill")
    contact = load_contact("slice_mill")
    simulation = Simulation(drums.case_of(mill, contact, config.drums[0], 40.81, 0), mill, contact, drums.DrumDem())
    text = drums.input_text(simulation, mill.geometry, config, config.drums[0])
    shell, *lifters = re.findall(r"^region .*", text, re.MULTILINE)
    assert "cylinder y 0 0 0.275 -0.01175 0.01175 side in rotate v_turned" in shell and len(lifters) == 12
    # A block of 22 mm, its inner face 22 mm from the shell.
    low, high, *_, bottom = (float(word) for word in words(text, "region lifter0 block")[:5])
    assert high - low == pytest.approx(0.022) and bottom == pytest.approx(0.275 - 0.022)
    angles = [float(value) for value in re.findall(r"equal v_turned\+(\S+)", text)]
    assert np.diff(angles) == pytest.approx(np.full(11, math.pi / 6))
    # Friction of two balls, and of ball and wall.
    assert words(text, "pair_coeff * *")[8] == "0.14"
    assert words(text, "fix shell all wall/gran/region granular")[8] == "0.39"
    settle, discard, window = drums.steps_of(simulation, config.drums[0])
    assert window * simulation.step == pytest.approx(2 * 60 / 40.81) and discard % drums.ROW == settle % drums.ROW == 0


def repetitions() -> pd.DataFrame:
    def rows(case, code, times):
        own = {"ns_per_ball_step": times, "processor_ns_per_ball_step": np.array(times) / 2, "repetition": range(3)}
        # Half a core: something else ran.
        return pd.DataFrame({"case": case, "balls": 24, "code": code, "wall": "w", **own})

    cylinder = [rows("cylinder", "millprint", [40, 50, 45]), rows("cylinder", "LAMMPS", [900, 200, 360])]
    return pd.concat([rows("emax", "millprint", [10, 90, 20]), *cylinder])


def test_ratio_is_theirs_over_ours_on_the_same_case():
    table = summarise(repetitions())
    assert list(table["ns_per_ball_step"]) == [20, 45, 360]
    # Of each repetition: 900 / 40, 200 / 50, 360 / 45. Three are too few for an interval.
    assert list(table["ratio_to_us"]) == [1, 1, pytest.approx(11.5)] and table["ratio_95"].isna().all()
    assert table["steps_per_s"].to_numpy() == pytest.approx(1e9 / (24 * np.array([20, 45, 360])))
    assert list(spread(repetitions())["processor_ns"]) == [10, 22.5, 180]
    more = pd.concat([repetitions(), repetitions().assign(repetition=lambda rows: rows["repetition"] + 3)])
    half = 2.5706 * np.std([22.5, 4, 8] * 2, ddof=1) / 6**0.5
    assert summarise(more)["ratio_95"].iloc[-1] == pytest.approx(half, 1e-4)


def test_the_interval_of_a_difference_is_welchs():
    """Against scipy's own test of samples with unequal spreads."""
    a, b = [1.0, 2.0, 3.0, 4.5, 2.5], [5.0, 9.0, 6.0, 20.0, 7.0]
    own = physics.half_width([np.std(x, ddof=1) / math.sqrt(5) for x in (a, b)], 5)
    interval = stats.ttest_ind(b, a, equal_var=False).confidence_interval(0.95)
    assert own == pytest.approx((interval.high - interval.low) / 2)
