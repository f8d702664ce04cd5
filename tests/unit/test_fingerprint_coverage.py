"""How often both bands hold: over many draws of made-up mills, whose scatter is known."""

import sys
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from tools import try_bands

from millprint.cases.of_mill import held_out_cases, mill_cases
from millprint.config.errors import ConfigError
from millprint.config.included import load_mill
from millprint.config.mill_sweep import MillsConfig
from millprint.estimate.gaussian_process import Covariance
from millprint.fingerprint.coverage import (
    HELD_OUT_COLUMNS,
    NEW,
    count_held_out,
    coverage_row,
    predict_held_out,
    sum_coverage,
)
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import (
    NO_SAMPLING,
    Process,
    band_width,
    fit_sampling,
    kernel_of,
    logarithms,
    searched,
    varied_components,
)
from millprint.mill.bodies import check_volume
from millprint.mill.vessel import build_vessel
from millprint.observables.definitions import CURVES
from millprint.run.files import read_table
from tests.new_jars import DRAWN, JARS, write_folder
from tests.unit.synthetic_mill import VOLUME, descriptors, still, summary

FILLS, SPEEDS = np.geomspace(0.05, 0.35, 9), (10.0, 15.0)
DRAWS, PLACES, TURNS = 12, 60, 6


def conditions(fills: np.ndarray, speeds: np.ndarray) -> pd.DataFrame:
    return pd.DataFrame(
        {"fill_ratio": fills, "speed_hz": speeds, "ball_diameter_m": 0.01, "density_kg_m3": 7700.0, "amplitude_m": 0.02}
    )


def error_of_run(fills: np.ndarray) -> np.ndarray:
    """Relative standard error of the power of one run: few balls scatter more."""
    return 0.08 * np.sqrt(0.1 / fills)


def hits(rng: np.random.Generator, runs: int) -> dict[str, np.ndarray]:
    """Which bands of one made-up mill hold, at PLACES conditions: of a new run, of the mean, and without its own error.

    Its logarithm is drawn from a process of the kind that is fitted, plus the error of one run by its window, which
    TURNS turns tell.
    """
    known = conditions(np.tile(FILLS, len(SPEEDS)), np.repeat(SPEEDS, len(FILLS)))
    new = conditions(np.exp(rng.uniform(*np.log(FILLS[[0, -1]]), PLACES)), rng.uniform(*SPEEDS, PLACES))
    inputs, components = logarithms(pd.concat([known, new])), varied_components(known)
    start = searched(components, inputs.shape[1])[0]
    covariance = Covariance(kernel_of(components, inputs.shape[1]), start)(inputs) + 1e-9 * np.eye(len(inputs))
    true = np.linalg.cholesky(covariance) @ rng.standard_normal(len(inputs))
    error = error_of_run(known["fill_ratio"].to_numpy()) / np.sqrt(runs)
    logs = true[: len(known)] + error * rng.standard_normal(len(known))
    freedom = TURNS * runs - 1
    stated = error * np.sqrt(rng.chisquare(freedom, len(known)) / freedom)
    process = Process.fit(inputs[: len(known)], logs, stated, components, runs)
    told, mean = process.predictor().predict(inputs[len(known) :]), true[len(known) :]
    width = band_width(0.95, len(known))
    run = mean + error_of_run(new["fill_ratio"].to_numpy()) * rng.standard_normal(PLACES)
    here = process.predictor().predict(inputs[: len(known)])
    again = true[: len(known)] + error_of_run(known["fill_ratio"].to_numpy()) * rng.standard_normal(len(known))
    without = process.stretch * np.sqrt((told.of_mean / process.stretch) ** 2 + process.noise)
    return {
        "new": np.abs(run - told.logs) <= width * told.of_new,
        "mean": np.abs(mean - told.logs) <= width * told.of_mean,
        "new, where simulated": np.abs(again - here.logs) <= width * here.of_new,
        "new, without its own error": np.abs(run - told.logs) <= width * without,
    }


@pytest.mark.slow
@pytest.mark.parametrize("runs", [1, 4])
def test_both_bands_hold_as_often_as_they_say(runs):
    rng = np.random.default_rng(10)
    found = [hits(rng, runs) for _ in range(DRAWS)]
    shares = {name: np.mean([each[name] for each in found]) for name in found[0]}
    assert 0.9 <= shares["new"] <= 0.99, shares
    assert 0.9 <= shares["mean"] <= 0.99, shares
    assert 0.9 <= shares["new, where simulated"] <= 0.99, shares
    # The band of one run that leaves the run's own error out holds too few.
    assert shares["new, without its own error"] < 0.88, shares


def test_seeds_of_several_motions_widen_their_own_band_only():
    """As in a planetary jar of 51 mL: of six conditions one has motions of 580, 681 and 834 mW, the others 0.4 %."""
    table = conditions(np.tile(FILLS, len(SPEEDS)), np.repeat(SPEEDS, len(FILLS)))
    inputs, stated = logarithms(table), np.full(len(table), 0.004)
    differ = np.arange(len(table)) == 1
    stated[differ] = 0.1
    process = Process.fit(inputs, inputs[:, 0], stated, varied_components(table), 3, differ)
    of_new = process.predictor().predict(inputs).of_new
    assert of_new[~differ] == pytest.approx(0.004 * 2) and of_new[differ] == pytest.approx(0.1 * 2)


def test_the_variance_of_a_run_is_found_from_few_turns():
    rng = np.random.default_rng(0)
    fills = rng.uniform(0.05, 0.4, 4000)
    level, slope = fit_sampling(np.log(fills), error_of_run(fills) ** 2 * rng.chisquare(2, 4000) / 2)
    assert (level, slope) == pytest.approx((np.log(0.08**2 * 0.1), -1.0), abs=0.1)
    assert fit_sampling(np.log(fills), np.full(4000, np.nan)) == NO_SAMPLING
    assert fit_sampling(np.zeros(3), np.array([1e-4, np.nan, 3e-4])) == pytest.approx((np.log(2e-4), 0.0))


def test_a_row_of_coverage_is_by_hand():
    """Errors of 0.1, -0.3, 0.2 and 0 in a band of 0.25: three of four, and Wilson's interval of that."""
    own = SimpleNamespace(about={"probability": 0.95, "contact": "steel"})
    row = coverage_row(own, "condition", "Pn", np.array([0.1, -0.3, 0.2, 0]), np.full(4, 0.25), 1.5)
    assert (row["conditions"], row["held"], row["covered"], row["stretch"]) == (4, 3, 0.75, 1.5)
    assert row["error_percent"] == pytest.approx(100 * (0.14 / 4) ** 0.5)
    assert row["half_width_percent"] == pytest.approx(100 * (np.exp(0.25) - 1))
    square = 1.959964**2
    middle, half = (0.75 + square / 8) / (1 + square / 4), (0.75 * 0.25 / 4 + square / 64) ** 0.5 / (1 + square / 4)
    ends = middle - 1.959964 * half, middle + 1.959964 * half
    assert (row["covered_lower"], row["covered_upper"]) == pytest.approx(ends, rel=1e-5)


def test_without_scipy_new_conditions_are_refused_in_one_line_and_none_are_not_missed(monkeypatch):
    mill = load_mill("mixer")
    monkeypatch.setitem(sys.modules, "scipy.stats", None)
    with pytest.raises(ConfigError, match="scipy in the environment of Snakemake: install it") as refused:
        held_out_cases(mill, MillsConfig(contact="calibrated"))
    assert len(str(refused.value).splitlines()) == 1
    assert held_out_cases(mill, MillsConfig(contact="calibrated", held_out=0)) == []


def test_new_conditions_lie_within_the_sweep_and_have_seeds_of_their_own():
    mill = load_mill("mixer")
    settings = MillsConfig(contact="calibrated", held_out=32)
    known, new = mill_cases(mill, settings), held_out_cases(mill, settings)
    assert len(new) == 32 and held_out_cases(mill, settings.model_copy(update={"held_out": 0})) == []
    assert not {case.seed for case in known} & {case.seed for case in new}
    for name in ("fill_ratio", "speed_hz", "ball_diameter_m"):
        old, found = ([getattr(case, name) for case in cases] for cases in (known, new))
        assert min(old) <= min(found) and max(found) <= max(old)
    assert len({case.fill_ratio for case in new}) == 32 and {case.ball_diameter_m for case in new} == {0.007, 0.01}
    # Speed and ball size are drawn independently: each size at low and at high speed.
    fast = {(1e3 * case.ball_diameter_m, case.speed_hz > 22) for case in new}
    assert len(fast) == 4
    assert {case.rayleigh_fraction for case in new} == {case.rayleigh_fraction for case in known}


@pytest.mark.slow
def test_new_simulations_are_counted_against_the_band_of_a_new_simulation():
    own = Fingerprint.fit(descriptors(), VOLUME, 0.95)
    table = descriptors(fills=(0.08, 0.15), speeds=(800.0,)).assign(seed=1000)
    held = predict_held_out(own, table)
    assert list(held) == HELD_OUT_COLUMNS and len(held) == len(table) * len(CURVES)
    assert (held["verdict"] == "agrees").all()
    table["Pn"] *= 3.0
    counted = count_held_out(own, predict_held_out(own, table)).set_index("quantity")
    assert (counted["left_out"] == NEW).all()
    assert counted.loc["powers", ["conditions", "held"]].tolist() == [2 * len(table), len(table)]
    assert counted.loc["Pn", "held"] == 0 and counted.loc["Pt", "covered"] == 1
    total = sum_coverage({"one": counted.reset_index(), "other": counted.reset_index()}).set_index(["mill", "quantity"])
    assert total.loc[("all", "powers"), ["conditions", "held"]].tolist() == [4 * len(table), 2 * len(table)]
    assert total.loc[("all", "powers"), "covered"] == 0.5
    assert total.loc[("all", "powers"), "covered_lower"] < 0.5 < total.loc[("all", "powers"), "covered_upper"]


@pytest.mark.parametrize(
    ("still_at", "hit_at", "asked", "counted"),
    [
        ((0.04, 0.06, 0.10), (), still(0.05), {"P": 1, "Pw": 1}),
        ((0.04, 0.06), (0.11, 0.15, 0.20), summary(0.07), {}),
    ],
    ids=["nothing hits", "between no hits and some"],
)
def test_bands_that_are_not_known_are_not_counted(still_at, hit_at, asked, counted):
    runs = [*map(still, still_at), *map(summary, hit_at)]
    own = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    new = tabulate_descriptors([asked], "gap_0_03").assign(seed=1000)
    found = count_held_out(own, predict_held_out(own, new))
    assert {row["quantity"]: row["conditions"] for row in found.to_dict("records")} == counted


@pytest.mark.slow
def test_the_new_jars_are_mills_of_their_own(tmp_path, monkeypatch):
    """Sizes of none of the box, so that its bands were not chosen with them in view."""
    write_folder(tmp_path)
    monkeypatch.chdir(tmp_path)
    mills = {name: load_mill(name) for name in JARS}
    box = [load_mill(name) for name in MillsConfig().box]
    for mill in mills.values():
        check_volume(mill, build_vessel(mill))
        assert not any(mill.geometry == other.geometry for other in box)
        assert len(held_out_cases(mill, MillsConfig(contact="calibrated"))) == 8
    assert len(build_vessel(mills[DRAWN]).curves) == 2


def test_the_page_has_the_trials_of_the_table():
    trials = read_table(try_bands.TABLE)
    assert len(trials) >= 4 and try_bands.block(trials) in try_bands.PAGE.read_text()
