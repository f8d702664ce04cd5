"""Descriptors of a mill that obeys the scaling exactly, and what is refused."""

import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import trapezoid

from millprint.config.errors import ConfigError
from millprint.fingerprint.descriptors import _of_blocks, _ratio_of_parts, tabulate_descriptors, weighted_errors
from millprint.fingerprint.predicted_values import conditions_of
from millprint.fingerprint.readers import check_summary, read_summaries
from millprint.observables.condition import SCALES, VARIABLES, Condition, energy_scale, fill_grid
from millprint.observables.counted_collisions import Collisions
from millprint.observables.definitions import COMPUTED
from millprint.thesis.regimes import tabulate_cycles, tabulate_densities, tabulate_published
from millprint.thesis.scaling import tabulate_counting_rules
from tests.refusals import refusal, refusals
from tests.unit.synthetic_mill import counted, descriptors, fingerprint, summaries, summary, true_curves, weighted


def test_descriptors_give_back_the_curves():
    table = descriptors()
    assert len(table) == 36
    for name, curve in zip(("Pn", "Pt", "f"), true_curves(table["fill_ratio"]), strict=True):
        np.testing.assert_allclose(table[name], curve, rtol=1e-12)
    normal, tangential, _ = true_curves(table["fill_ratio"])
    np.testing.assert_allclose(table["ratio"], tangential / normal, rtol=1e-12)


def test_the_error_of_a_mean_of_collisions_is_that_of_its_blocks():
    """Of eight turns in blocks of two, with a collision each: the standard error of the mean of four block means."""
    values = pd.DataFrame({"start_s": 1 + np.arange(8.0), "normal_J": [3.0, 5, 6, 8, 2, 4, 9, 3]})
    mean = SimpleNamespace(of_collisions=lambda own: float(own["normal_J"].mean()))
    found = _of_blocks(mean, Collisions(values, 1.0, 8.0, {}), 1.0)
    assert Collisions(values, 1.0, 8.0, {}).without(1, 4).window_s == 6.0
    # Block means 4, 7, 3 and 6 about 5, with a variance of 10 / 3.
    assert found == (5.0, pytest.approx((10 / 3 / 4) ** 0.5 / 5), 3)
    # One turn has no blocks, and no error; nor has what one block alone holds.
    assert _of_blocks(mean, Collisions(values[:1], 1.0, 8.0, {}), 1.0) == (3.0, None, 0)
    assert _of_blocks(mean, Collisions(values[:1], 1.0, 1.0, {}), 1.0) == (3.0, None, 0)


def test_a_ratio_of_powers_varies_with_the_difference_of_its_parts():
    """Turns of 1 and 3 J over two of 1 J, 0.2 over 0.4 W: the parts are 0.5 and 1.5 of their mean."""
    turns, even = np.array([1.0, 3.0]), np.array([1.0, 1.0])
    assert _ratio_of_parts(0.2, 0.4, turns, even) == (0.5, pytest.approx(0.5), 1)
    assert _ratio_of_parts(0.4, 0.4, turns, turns) == (1.0, pytest.approx(0.0), 1)
    assert _ratio_of_parts(0.2, 0.0, turns, 0 * even)[1:] == (None, 0)


def test_errors_of_weighted_statistics_are_by_hand():
    # Over their means, two turns of 1 and 3 J are 0.5 and 1.5: E* errs by half their gap, f* by the whole.
    found = weighted_errors(np.array([1.0, 3.0]), np.array([2.0, 2.0]))
    assert found == {"energy": (pytest.approx(0.5), 1), "frequency": (pytest.approx(1.0), 1)}
    assert weighted_errors(np.array([1.0]), np.array([2.0])) == {"energy": (None, 0), "frequency": (None, 0)}
    # Sixteen turns in pairs are eight: squares of 1.5 and 0.5 of their mean vary by 0.5 sqrt(8 / 7) from pair to pair.
    squares = np.tile([1.5, 1.5, 0.5, 0.5], 4)
    found = weighted_errors(np.ones(16), squares)
    assert found["energy"] == found["frequency"] == (pytest.approx(0.5 * np.sqrt(8 / 7) / np.sqrt(8)), 7)


@pytest.mark.parametrize(("measure", "of_a_ball"), [("number", 1.0), ("mass_g", 7.7 * np.pi / 6)])
def test_balls_that_are_counted_or_weighed_are_a_fill_ratio(measure, of_a_ball):
    """24 balls of 10 mm and 7.7 g/cm3 in 125 mL."""
    about = fingerprint().about | {"volume_m3": 125e-6, "density_kg_m3": 7700.0}
    table = pd.DataFrame({measure: [24 * of_a_ball], "ball_diameter_mm": [10.0], "speed_rpm": [600.0]})
    found = conditions_of(table, about)
    assert found.fill_ratio == pytest.approx(24 * np.pi / 6 / 125)
    # The same in SI units.
    again = conditions_of(table[[measure]].assign(ball_diameter_m=0.01, speed_hz=10.0), about)
    assert (again.ball_diameter_m, again.speed_hz) == (pytest.approx([0.01]), pytest.approx([10.0]))
    assert (found.ball_diameter_m, found.speed_hz) == (pytest.approx([0.01]), pytest.approx([10.0]))


def known_run() -> dict:
    """Eight collisions of five balls in two seconds, 16 J normal and 4 J tangential; rho omega^2 A^2 d^3 is 1 J."""
    run = summary() | {"balls": 5, "density_kg_m3": 1000.0, "frequency_hz": 10.0, "amplitude_m": 0.1, "window_s": 2.0}
    rule = counted("gap_0_03", 0.03, frequency=4.0, normal=8.0, tangential=2.0, balls=5) | {"count": 8}
    power = {"normal": 8.0, "tangential": 2.0, "rolling": 2.5, "wall": 12.5}
    error = {"normal": 0.8, "tangential": 0.4}
    turns = {"normal_J": [0.7, 0.9, 0.7, 0.9], "tangential_J": [0.2, 0.2, 0.3, 0.1], "rolling_J": [0.25] * 4}
    # Over their means, normal squares are 0.1 above the energies in two turns and 0.1 below in two.
    squares = {"normal_square_J2": [0.975, 1.225, 0.775, 1.025], "tangential_square_J2": [0.9, 0.9, 1.3, 0.9]}
    return run | {
        "per_revolution": turns | squares,
        "ball_diameter_m": 0.1, "collisions": [rule], "power_W": power, "power_standard_error_W": error,
        "restitution": 0.5, "static_friction": 0.0,
        "weighted": {
            "normal": weighted("normal", 4.0, 8.0, 5),
            "tangential": weighted("tangential", 4.0, 2.0, 5),
            "strong_frequency_hz": 0.32,
        },
    }  # fmt: skip


def test_known_collisions_have_a_known_answer():
    row = tabulate_descriptors([known_run()], "gap_0_03").iloc[0]
    known = {
        "normal_energy_J": 2.0,  # 16 J over 8 collisions
        "tangential_energy_J": 0.5,
        "specific_frequency_hz": 0.8,  # 4 collisions a second, shared by 5 balls
        "effective_restitution": 0.5,  # without friction, the restitution itself
        "drive_torque_Nm": 12.5 / (2 * np.pi * 10),  # 12.5 W at 10 revolutions a second
        "efficiency": 0.8,  # 10 of 12.5 W; the rest is rolling
        "Pn": 0.16,  # 8 W over 5 balls of 10 W each
        "Pt": 0.04,
        "f": 0.08,  # 0.8 collisions of a ball in a tenth of a second
        "ratio": 0.25,
        "P": 0.20,
        "Pr": 0.05,
        "Pw": 0.25,
        "rolling_ratio": 0.25,
        # Of the turns 1.15, 1.35, 1.25, 1.25 J.
        "Pw_se": 0.2 * np.sqrt(0.02 / 3) / 2,
        "rolling_ratio_se": 0.25 * np.sqrt(0.02 / 3) / 2,
        "En": 2.0,  # over 1 J
        "Et": 0.5,
        "Pn_se": 0.016,  # 10 % of the normal power
        "Pt_se": 0.008,  # 20 % of the tangential power
        "f_se": 0.08 / np.sqrt(8),
        # Of the turns 0.9, 1.1, 1.0, 1.0 J, and of their relative differences: one part may replace the other.
        "P_se": 0.2 * np.sqrt(0.02 / 3) / 2,
        "ratio_se": 0.25 * np.sqrt((2 * 0.125**2 + 2 * 0.625**2) / 3) / 2,
        "En_se": 2.0 * np.hypot(0.1, 1 / np.sqrt(8)),
        "Et_se": 0.5 * np.hypot(0.2, 1 / np.sqrt(8)),
        "weighted_normal_frequency_hz": 0.2,  # 8 W over 5 balls and 8 J, four times the mean
        "weighted_tangential_frequency_hz": 0.4,
        "En_star": 8.0,
        "Et_star": 1.0,
        "fn_star": 0.02,
        "ft_star": 0.04,
        "f90": 0.032,
        # An energy varies with squares less energies, its rate with twice the energies less squares.
        "En_star_se": 8.0 * 0.1 / np.sqrt(3),
        "fn_star_se": 0.02 * np.hypot(0.125, 0.1) / np.sqrt(3),
        "f90_se": 0.032 / np.sqrt(3.2),  # 3.2 strong collisions
    }
    assert row[list(known)].to_dict() == pytest.approx(known, rel=1e-12)
    assert {column.name for column in COMPUTED} <= set(known)


def test_of_two_seeds_a_weighted_energy_has_three_degrees_of_freedom_from_four_turns_each():
    runs = [known_run() | {"seed": seed} for seed in range(2)]
    runs[1]["weighted"] = runs[1]["weighted"] | {"normal": weighted("normal", 4.0, 8.4, 5)}
    row = tabulate_descriptors(runs, "gap_0_03").iloc[0]
    between = np.var([8.0 / 8.2, 8.4 / 8.2], ddof=1)
    assert row["En_star_se"] == pytest.approx(8.2 * np.sqrt((6 * 0.1**2 / 3 + between) / 7 / 2))


def test_a_mill_at_rest_has_no_efficiency():
    of_powers = {"normal_power_W": [1.0, 1.0], "tangential_power_W": [0.5, 0.5], "wall_power_W": [2.0, 2.0]}
    (efficiency,) = (column for column in COMPUTED if column.name == "efficiency")
    found = efficiency.values(pd.DataFrame({**of_powers, "speed_hz": [0.0, 1.0]}))
    assert found.tolist() == pytest.approx([np.nan, 0.75], nan_ok=True)


def test_powers_that_are_only_rounding_are_nothing():
    """Balls that only bounce straight up shear by 1e-15 of the power, whose energy and frequency would mean nothing."""
    run = known_run()
    run["power_W"] |= {"tangential": 1e-14, "rolling": -1e-14}
    row = tabulate_descriptors([run], "gap_0_03").iloc[0]
    assert row[["Pt", "Pr", "Et_star", "ft_star", "weighted_tangential_frequency_hz"]].tolist() == [0.0] * 5
    assert (row["Pn"], row["En_star"], row["fn_star"]) == pytest.approx((0.16, 8.0, 0.02))
    # What is small but real stays.
    run["power_W"] |= {"tangential": 1e-6}
    row = tabulate_descriptors([run], "gap_0_03").iloc[0]
    assert row["Pt"] == pytest.approx(2e-8) and row["Et_star"] == pytest.approx(1.0)


def times(factor: float, collisions: int) -> dict:
    """The known run with so many times its powers, energies and frequencies, and a number of collisions."""
    run = known_run()
    for part in (run["power_W"], run["power_standard_error_W"]):
        part |= {name: factor * value for name, value in part.items()}
    turns = {name: [factor * value for value in energies] for name, energies in run["per_revolution"].items()}
    rules = [rule | {"count": collisions, "frequency_hz": factor * rule["frequency_hz"]} for rule in run["collisions"]]
    for channel in ("normal", "tangential"):
        run["weighted"][channel]["energy_J"] *= factor
    return run | {"per_revolution": turns, "collisions": rules}


def test_errors_of_several_seeds_are_by_hand():
    """Seeds at 0.7, 1 and 1.3 times the known run: a mean has 0.3 / sqrt(3) of it; what is alike, that of the turns."""
    runs = [times(factor, 80) | {"case": known_run()["case"] | {"seed": k}} for k, factor in enumerate((0.7, 1, 1.3))]
    row, of_seeds = tabulate_descriptors(runs, "gap_0_03").iloc[0], 0.3 / np.sqrt(3)
    # Of turns and of three equal seeds, each for half: w / 2, of which the mean of three has a third. Tangential turns
    # have 2 e - s of 0.1, 0.1, 0.7 and -0.9 about one.
    turns = {"ratio": (2 * 0.125**2 + 2 * 0.625**2) / 3 / 4, "fn_star": (0.125**2 + 0.1**2) / 3, "ft_star": 0.11}
    known = {f"{name}_se": row[name] * np.sqrt(w / 6) for name, w in turns.items()}
    known |= {f"{name}_se": row[name] * of_seeds for name in ("Pn", "Pt", "P", "Pr", "Pw", "En_star", "Et_star", "f")}
    known |= {f"{name}_se": row[name] * np.sqrt(2) * of_seeds for name in ("En", "Et")}
    # f90 has those of 3.2 strong collisions of each seed.
    known["f90_se"] = row["f90"] / np.sqrt(3 * 3.2)
    assert row[list(known)].to_dict() == pytest.approx(known, rel=1e-9)
    # An energy times its frequency is its power.
    for energy, frequency, power in (
        ("En", "f", "Pn"),
        ("Et", "f", "Pt"),
        ("En_star", "fn_star", "Pn"),
        ("Et_star", "ft_star", "Pt"),
    ):
        assert row[energy] * row[frequency] == pytest.approx(row[power])
    for factor, run in zip((0.1, 1, 1.9), runs, strict=True):
        run["weighted"]["strong_frequency_hz"] *= factor
    apart = tabulate_descriptors(runs, "gap_0_03").iloc[0]
    assert apart["f90_se"] == pytest.approx(apart["f90"] * 0.9 / np.sqrt(3))
    # The few collisions of these seeds leave the frequency less sure than the seeds do.
    few = [times(factor, 8) | {"case": run["case"]} for factor, run in zip((0.7, 1, 1.3), runs, strict=True)]
    assert tabulate_descriptors(few, "gap_0_03").iloc[0]["f_se"] == pytest.approx(row["f"] / np.sqrt(24))


def test_conditions_can_be_arrays_with_numbers_among_them():
    conditions = Condition(np.array([0.1, 0.2]), np.array([10.0, 20.0]), 0.01, 7700.0, 0.017)
    table = pd.DataFrame(conditions.rows(), columns=[*VARIABLES])
    assert len(table) == 2
    np.testing.assert_allclose(energy_scale(Condition.of_table(table)), energy_scale(conditions), rtol=1e-14)
    assert energy_scale(conditions)[1] == pytest.approx(4 * energy_scale(conditions)[0])
    fills = np.array([0.1, 0.25, 0.8])
    assert fill_grid(fills, 4).tolist() == pytest.approx([0.1, 0.2, 0.25, 0.4, 0.8])


def test_a_rule_that_counts_nothing_has_no_energy_and_no_crash():
    # Balls that slide as one raft touch all the time: contacts are counted, but none ends by a rule with a gap.
    run = summary(0.10)
    silent = run["collisions"][1]
    silent.update(name="hard", count=0, frequency_hz=0.0, mean_normal_J=0.0, mean_tangential_J=0.0)
    row = tabulate_counting_rules([check_summary(run, "run.json")]).set_index("counting_rule").loc["hard"]
    assert row["f"] == 0 and np.isnan(row["normal_energy_J"])
    (row,) = tabulate_descriptors([run], "hard").to_dict("records")
    assert row["collision_frequency_hz"] == row["normal_energy_J"] == 0 < row["wall_power_W"]
    # One in ten seconds has the energy of them all.
    silent.update(count=1, frequency_hz=0.1)
    (row,) = tabulate_descriptors([run], "hard").to_dict("records")
    assert row["normal_energy_J"] == pytest.approx(10 * row["normal_power_W"])


def test_an_unrecorded_counting_rule_is_refused():
    with pytest.raises(ConfigError, match=r"counting_rule = gap_0_05.*lifetimes, gap_0_02, gap_0_03"):
        tabulate_descriptors([summary()], "gap_0_05")


@pytest.mark.parametrize(("place", "value", "message"), refusals("a_faulty_summary_is_refused_in_one_line"))
def test_a_faulty_summary_is_refused_in_one_line(place, value, message):
    faulty = copy.deepcopy(summary())
    target = faulty
    for key in place[:-1]:
        target = target[key]
    target[place[-1]] = value
    assert message in refusal(check_summary, faulty, "run.json")


def test_a_run_without_collisions_is_a_result_with_zeros():
    quiet = summary()
    for rule in quiet["collisions"]:
        rule.update(count=0, frequency_hz=0.0, collisions_of_a_ball_hz=0.0, mean_normal_J=0.0, mean_tangential_J=0.0)
    row = tabulate_descriptors([check_summary(quiet, "run.json")], "gap_0_03").iloc[0]
    assert (
        row[["collision_frequency_hz", "specific_frequency_hz", "normal_energy_J", "tangential_energy_J"]] == 0
    ).all()
    assert row["normal_power_W"] > 0


def test_a_window_of_one_revolution_has_no_standard_error_and_is_accepted():
    short = check_summary(summary() | {"power_standard_error_W": {"normal": None, "tangential": None}}, "run.json")
    row = tabulate_descriptors([short], "gap_0_03").iloc[0]
    assert np.isnan(row["Pn_se"]) and row["Pn"] > 0


def test_a_missing_summary_key_or_file_is_named(tmp_path):
    faulty = summary()
    del faulty["per_revolution"]
    with pytest.raises(ConfigError, match="per_revolution: this key is missing"):
        check_summary(faulty, "run.json")
    with pytest.raises(ConfigError, match="no such summary"):
        read_summaries([tmp_path / "absent.json"])
    with pytest.raises(ConfigError, match="no simulation"):
        read_summaries([])


def test_cycles_pool_the_revolutions_of_all_seeds():
    runs = [summary(0.08, seed=seed) for seed in (0, 1)]
    energies = np.concatenate([run["per_revolution"]["normal_J"] for run in runs])
    row = tabulate_cycles(runs).iloc[0]
    assert row["revolutions"] == 20
    assert row["normal_mean_J"] == pytest.approx(energies.mean())
    assert row["normal_cv_percent"] == pytest.approx(100 * energies.std(ddof=1) / energies.mean())
    power = runs[0]["power_W"]["normal"]
    assert row["normal_mean_J"] * runs[0]["frequency_hz"] == pytest.approx(power, rel=1e-12)
    # A printed mean of 80 % of ours leaves us 25 % above it.
    printed = pd.DataFrame([row[["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]]])
    printed = printed.assign(normal_mean_J=0.8 * row["normal_mean_J"])
    beside = tabulate_published(tabulate_cycles(runs), printed, row["mill"], 0.08)
    assert beside["normal_mean_J_deviation_percent"].tolist() == pytest.approx([25.0])


def test_densities_integrate_to_one_at_the_chosen_fill_only():
    table = tabulate_densities(summaries(fills=(0.08, 0.10), diameters=(10.0,), speeds=(600.0,)), 0.08)
    assert set(table["fill_ratio"]) == {0.08}
    for _, line in table.groupby("channel"):
        assert trapezoid(line["density_per_J"], line["energy_J"]) == pytest.approx(1.0, abs=0.02)


def test_every_scale_grows_by_its_exponents():
    names = {"rho": "density_kg_m3", "omega": "speed_hz", "A": "amplitude_m", "d": "ball_diameter_m"}
    given = Condition(fill_ratio=0.2, speed_hz=5.0, ball_diameter_m=0.01, density_kg_m3=7700.0, amplitude_m=0.03)
    for scale in SCALES.values():
        for symbol, name in names.items():
            twice = replace(given, **{name: 2 * getattr(given, name)})
            assert scale.of(twice) / scale.of(given) == pytest.approx(2.0 ** scale.exponents[symbol])
