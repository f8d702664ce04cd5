"""Mills with their own sweeps: conditions, collapse of the curves, a large mill, and figures."""

import math
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from millprint.cases.of_mill import (
    RUN_WAY,
    discarded_turns,
    durations_of,
    enlarged,
    large_case,
    mill_cases,
    varied_case,
)
from millprint.config.errors import ConfigError
from millprint.config.fingerprint import UncertaintyConfig
from millprint.config.included import load_mill
from millprint.config.load import check_model, read_yaml
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import PRECISIONS, MillsConfig, MillSweepConfig, PrecisionName
from millprint.config.workflow import WorkflowConfig
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.mill_collapse import (
    BY_LAW,
    BY_NONE,
    BY_OWN,
    UNFITTED,
    compare_run,
    one_row_a_mill,
    tabulate_mill_collapse,
    tabulate_scale_up,
)
from millprint.mill.bodies import build_bodies, check_volume, travel_m
from millprint.mill.default_sweep import default_sweep
from millprint.mill.vessel import build_vessel
from millprint.view.frames import Geometry, body_of_feature
from tests.unit.synthetic_mill import descriptors, fingerprint, summary

pytestmark = pytest.mark.usefixtures("close_figures")

CONFIG = Path(__file__).parents[2] / "config"
BOX = ("emax", "planetary", "spex", "mixer", "vibratory", "attritor", "drum")


def mill(name: str, **changes) -> MillConfig:
    return load_mill(name).model_copy(update=changes)


@pytest.fixture(scope="module")
def settings() -> MillsConfig:
    return check_model(read_yaml(CONFIG / "config.yaml"), WorkflowConfig, "config.yaml").mills


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(file.stem for file in (CONFIG / "mills").glob("*.yaml")))
def test_a_mill_of_ours_holds_its_volume_within_its_tolerance(name):
    made = mill(name)
    vessel = build_vessel(made)
    check_volume(made, vessel)
    # The post of one jar is not counted; of no other mill is a tolerance of its own asked for.
    assert made.volume_tolerance == (0.04 if name == "emax_post" else 0.02)
    difference = abs(made.volume_ml / (vessel.volume_m3 * 1e6) - 1)
    closer = made.model_copy(update={"volume_tolerance": 0.99 * difference})
    with pytest.raises(ConfigError, match=rf"config/mills/{name}.yaml: volume_ml = {made.volume_ml:g}: the \w+ of geo"):
        check_volume(closer, vessel)


def test_the_cases_of_a_sweep_are_a_cross_of_speeds_and_sizes_at_every_fill(settings):
    cases = mill_cases(mill("mixer"), settings.model_copy(update={"precision": "standard"}))
    conditions = {(1e3 * case.ball_diameter_m, 60 * case.speed_hz) for case in cases}
    assert conditions == {(10, 18 * 60), (10, 27 * 60), (7, 18 * 60)}
    assert len(cases) == 3 * 4 * 3 and {case.seed for case in cases} == {0, 1, 2}
    # Whole turns, and long enough.
    for case in cases:
        turns = case.window_s * case.speed_hz
        assert turns == pytest.approx(round(turns))
        assert case.window_s >= 0.8


def test_the_precision_decides_about_steps_recorded_time_seeds_and_halfway_fill_ratios(settings):
    given = {"speeds_rpm": [60, 90], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3], "seeds": [1]}
    own = mill("drum", sweep=MillSweepConfig(**given, discard_turns=1, window_turns=4))
    levels = {name: settings.model_copy(update={"precision": name}) for name in PRECISIONS}
    assert set(get_args(PrecisionName)) == set(PRECISIONS)
    cases = {name: mill_cases(own, level) for name, level in levels.items()}
    first = {name: found[0] for name, found in cases.items()}
    steps = {name: case.rayleigh_fraction for name, case in first.items()}
    assert steps == pytest.approx({"draft": 0.11, "quick": 0.11, "standard": 0.08, "fine": 0.08})
    windows = {name: case.window_s for name, case in first.items()}
    assert windows == {"draft": 2.0, "quick": 2.0, "standard": 4.0, "fine": 8.0}
    seeds = {name: sorted({case.seed for case in found}) for name, found in cases.items()}
    assert seeds == {"draft": [1], "quick": [0, 1, 2], "standard": [0, 1, 2], "fine": [0, 1, 2, 3]}
    quick, *others = ([case.path for case in found if case.seed == 1] for found in cases.values())
    assert all(other == quick for other in others[:2])
    # Halfway between the fill ratios, by their ratio, only where the curve is to be known best.
    fills = [case.fill_ratio for case in cases["fine"] if case.seed == 1 and case.speed_hz == 1]
    assert fills == [0.1, 0.2, 0.3, 0.1414, 0.2449]
    assert all(case.discard_s == 1 / case.speed_hz for found in cases.values() for case in found)


def test_a_quick_window_has_turns_for_a_standard_error_and_sixteen_where_the_sweep_does_not_say():
    assert durations_of(1, 1, 1, 0.5)["window_s"] == 1.0
    assert durations_of(1, 1, 3, 0.5)["window_s"] == 2.0
    assert durations_of(1, 1, 1, 2)["window_s"] == 2.0
    assert durations_of(5, 5, None, 0.5, PRECISIONS["quick"].turns)["window_s"] == pytest.approx(16 * 0.2)
    assert durations_of(20, 5, None, 0.5)["window_s"] == pytest.approx(0.4)


def test_a_mill_discards_five_turns_and_a_drum_one_unless_its_sweep_says():
    named = MillSweepConfig(speeds_rpm=[60], ball_diameters_mm=[10], fill_ratios=[0.1, 0.2, 0.3])
    assert [discarded_turns(mill(name), named) for name in ("mixer", "planetary", "attritor", "drum")] == [5, 5, 5, 1]
    assert discarded_turns(mill("drum"), named.model_copy(update={"discard_turns": 3})) == 3


def test_the_intervals_by_contact_parameters_do_not_depend_on_the_precision(settings):
    levels = [settings.model_copy(update={"precision": name}) for name in PRECISIONS]
    first, *others = (varied_case(mill("spex"), level, UncertaintyConfig()) for level in levels)
    assert all(other == first for other in others)


def test_every_condition_of_a_sweep_is_simulated_with_every_seed(settings):
    given = {"speeds_rpm": [60], "ball_diameters_mm": [10], "fill_ratios": [0.1, 0.2, 0.3]}
    settings = settings.model_copy(update={"precision": "draft"})
    alone = mill_cases(mill("drum", sweep=MillSweepConfig(**given)), settings)
    assert [case.name for case in alone] == ["d10_f0.10_n60_s0", "d10_f0.20_n60_s0", "d10_f0.30_n60_s0"]
    several = mill_cases(mill("drum", sweep=MillSweepConfig(**given, seeds=[0, 3])), settings)
    assert [case for case in several if case.seed == 0] == alone
    assert [case.seed for case in several] == 3 * [0, 3]
    assert len({case.path for case in several}) == 6


def test_the_sweep_of_a_mill_that_has_none_follows_from_the_mill():
    drum = default_sweep(mill("drum", sweep=None))
    critical = 30 / math.pi * math.sqrt(9.81 / (0.05 - drum.ball_diameters_mm[0] / 2e3))
    assert drum.speeds == pytest.approx([0.6 * critical, 0.8 * critical], rel=0.05)
    emax = default_sweep(mill("emax", sweep=None))
    w = 2 * math.pi * emax.speeds[0] / 60
    assert 0.017 * w**2 == pytest.approx(6 * 9.81, rel=0.1)
    attritor = mill("attritor", sweep=None)
    tip = 2 * math.pi * default_sweep(attritor).speeds[0] / 60 * travel_m(build_bodies(attritor))
    assert tip == pytest.approx(0.5, rel=0.05)
    for name in BOX:
        swept = default_sweep(mill(name, sweep=None))
        assert len(set(swept.ball_diameters_mm)) == 2
        narrowest = 1e3 * np.ptp(build_bodies(mill(name))[0].vessel.bounds, axis=0).min()
        assert max(swept.ball_diameters_mm) <= narrowest / 5


def test_a_mill_that_never_moves_has_no_sweep():
    with pytest.raises(ConfigError, match=r"config/mills/emax_rest.yaml: motion: nothing in this mill moves"):
        default_sweep(mill("emax_rest", sweep=None))


def test_curves_that_obey_the_scaling_collapse_by_it_and_give_its_exponents():
    table = tabulate_mill_collapse(descriptors(), 0.95).set_index("quantity")
    power = table.loc["wall_power_per_ball_W"]
    assert power["spread_thesis"] < 1e-9
    assert power["spread_before"] > 1
    assert (power["omega"], power["d"]) == pytest.approx((3, 3))
    assert table.loc["specific_frequency_hz", ["omega", "d"]].tolist() == pytest.approx([1, 0], abs=1e-9)
    assert set(table["reason"]) == {BY_LAW}


def test_other_exponents_of_the_power_are_found_and_reported():
    """Power that grows as omega^2 d^4 collapses by its own exponents only; one speed does not show it."""
    runs = [
        summary(fill, size, speed, factor=(speed / 600) ** -1 * (size / 10))
        for fill in (0.06, 0.1, 0.2)
        for size in (10.0, 5.0)
        for speed in (600.0, 1200.0)
    ]
    table = tabulate_mill_collapse(tabulate_descriptors(runs, "gap_0_03"), 0.95).set_index("quantity")
    power = table.loc["wall_power_per_ball_W"]
    assert (power["omega"], power["d"]) == pytest.approx((2, 4))
    assert power["spread_thesis"] > 0.3
    assert power["spread_own"] < 1e-9
    assert power["reason"] == BY_OWN
    slow = tabulate_mill_collapse(descriptors(speeds=(600.0,)), 0.95).set_index("quantity")
    assert np.isnan(slow.loc["wall_power_per_ball_W", "omega"])
    assert slow.loc["wall_power_per_ball_W", "d"] == pytest.approx(3)


def test_two_conditions_tell_that_the_scaling_fails_and_not_which_exponents_hold():
    runs = [summary(0.1, 10.0, speed, factor=speed / 600) for speed in (600.0, 1200.0)]
    table = tabulate_mill_collapse(tabulate_descriptors(runs, "gap_0_03"), 0.95).set_index("quantity")
    power = table.loc["wall_power_per_ball_W"]
    assert (power["collapse"], power["reason"]) == ("differs", UNFITTED)


def test_a_regime_that_changes_is_said_not_to_collapse():
    runs = [
        summary(fill, size, speed, factor=(8.0 if speed > 700 and fill < 0.1 else 1.0))
        for fill in (0.06, 0.1, 0.2)
        for size in (10.0, 5.0)
        for speed in (600.0, 1200.0)
    ]
    table = tabulate_mill_collapse(tabulate_descriptors(runs, "gap_0_03"), 0.95)
    (row,) = one_row_a_mill([table]).to_dict("records")
    assert (row["power_collapse"], row["power_reason"]) == ("differs", BY_NONE)
    assert row["power_spread_own"] > 0.2


@pytest.mark.slow
def test_an_enlarged_mill_is_similar_in_shape_and_motion():
    for name in BOX:
        small = mill(name)
        large, factor = enlarged(small, 10, "large")
        assert factor == pytest.approx((1e4 / small.volume_ml) ** (1 / 3))
        few, many = build_bodies(small), build_bodies(large)
        assert many[0].vessel.volume_m3 == pytest.approx(few[0].vessel.volume_m3 * factor**3, rel=1e-9)
        assert travel_m(many) == pytest.approx(travel_m(few) * factor, rel=1e-9)
        assert [len(body.vessel.facets) for body in many] == [len(body.vessel.facets) for body in few]


def test_each_way_to_run_a_large_mill_keeps_its_quantity(settings):
    """With the scaling exact, the ratios large over small follow only from L."""
    plan = settings.scale_up.model_copy(update={"ball_diameter_mm": 10.0})
    factor = 80 ** (1 / 3)
    table = tabulate_scale_up(fingerprint(), factor, plan, 2e-6, 40.0).set_index("way")
    near = {"rel": 0.25}  # beyond its data the fingerprint's curves drift a little
    assert table.loc["energy", "weighted_normal_energy_ratio"] == pytest.approx(1, **near)
    assert table.loc["power", "specific_power_ratio"] == pytest.approx(1, **near)
    assert table.loc["frequency", "weighted_normal_frequency_ratio"] == pytest.approx(1, **near)
    assert table.loc["similar", "froude"] == pytest.approx(1)
    assert table.loc["similar", "weighted_normal_energy_ratio"] == pytest.approx(factor**4, **near)
    assert table.loc["similar", "balls"] == pytest.approx(24, abs=1)
    assert table.loc["energy", "balls"] == pytest.approx(24 * 80, abs=60)
    assert table.loc["energy", "speed_rpm"] == pytest.approx(600 / factor)
    # 10 turns of the large mill at 2 us and 40 ns.
    energy = table.loc["energy"]
    assert energy["hours"] == pytest.approx(10 / (10 / factor) / 2e-6 * energy["balls"] * 40e-9 / 3600, rel=1e-6)
    assert "amplitude_m" in energy["outside"]
    assert "volume_m3" in energy["outside"]


def test_the_large_run_is_held_against_the_sheet(settings):
    plan = settings.scale_up
    large, factor = enlarged(mill(plan.mill), plan.volume_l, "large")
    case = large_case(mill(plan.mill), large, factor, settings)
    assert case.speed_hz == pytest.approx(plan.speed_rpm / factor / 60)
    sheet = tabulate_scale_up(fingerprint(), factor, plan, 2e-6, 40.0)
    foreseen = sheet.set_index("way").loc[RUN_WAY.name]
    assert foreseen["balls"] >= 10_000
    run = {"balls": int(foreseen["balls"]), "ns_per_ball_step": 80.0, "power_W": {"wall": 3.0}}
    run["weighted"] = {
        name: {"energy_J": 3 * foreseen[f"weighted_{name}_energy_J"]} for name in ("normal", "tangential")
    }
    rule = {"mean_normal_J": 2 * foreseen["normal_energy_J"], "mean_tangential_J": 1e-3, "specific_frequency_hz": 1e2}
    compared = compare_run(sheet, run, rule).set_index("quantity")
    assert compared.loc["normal_energy_J", "ratio"] == pytest.approx(2)
    assert compared.loc["weighted_normal_energy_J", "ratio"] == pytest.approx(3)
    assert compared.loc["ns_per_ball_step", "ratio"] == pytest.approx(2)
    assert compared.loc["wall_power_W", "simulated"] == 3.0


def test_features_are_numbered_through_all_bodies_as_the_simulation_does():
    """Facets of all bodies first, then edges, then corners, then curves."""

    def body(facets, edges, corners, curves):
        empty = np.zeros((0, 3))
        sizes = np.zeros((facets, 3)), np.zeros(facets), np.zeros((edges, 2, 3)), np.zeros((corners, 3))
        return Geometry(empty, empty, *sizes, np.zeros((curves, 25)), np.zeros((0, 16)))

    owner, local = body_of_feature([body(3, 1, 1, 2), body(2, 2, 3, 1)], np.arange(15))
    assert owner.tolist() == [0, 0, 0, 1, 1, 0, 1, 1, 0, 1, 1, 1, 0, 0, 1]
    assert local.tolist() == [0, 1, 2, 0, 1, 3, 2, 3, 4, 4, 5, 6, 5, 6, 7]
