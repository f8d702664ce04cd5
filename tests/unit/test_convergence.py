"""The convergence study: its tables from made-up runs whose answer is known, its verdict, its figures."""

import itertools

import numpy as np
import pytest

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import choose_step, convergence_table, in_words
from tests.unit.synthetic_mill import summary

STEPS = (5e-7, 1e-6, 2e-6, 4e-6, 8e-6)
SETTINGS = ConvergenceConfig()


def run(step, seed, diameter=10.0, modulus=2.05, factor=1.0, noise=0.0, closure=1e-5):
    """The summary of a made-up run; its powers and frequency are `factor` times (1 + noise) those of the mill."""
    made = summary(diameter_mm=diameter, seed=seed, noise=noise, factor=factor)
    made["case"] |= {"time_step_s": step, "young_modulus_gpa": modulus}
    return made | {
        "young_modulus_pa": modulus * 1e9,
        "time_step_s": step,
        "rayleigh_fraction": step / 5.2e-5,
        "revolutions": 10.0,
        "closure": closure,
        "max_overlap_fraction": 0.02 * step / 1e-6,
        "steps": round(1 / step),
        "processor_s": 1e-6 / step,
        "wall_clock_s": 1.1e-6 / step,
        "ns_per_ball_step": 30.0,
    }


def sweep(diameters=(10.0,), seeds=4, spread=0.01, slope=0.0, closure=25.0):
    """Runs at every step: balance errors fall with its square, energies change by `slope` times the step in us."""
    rng = np.random.default_rng(1)
    runs = []
    for diameter, step, seed in itertools.product(diameters, STEPS, range(seeds)):
        noise = spread * rng.standard_normal() + slope * step / 1e-6
        runs.append(run(step, seed, diameter, noise=noise, closure=closure * step**2 * 1e6))
    return runs


def taken(step):
    """The same step for all balls."""
    return {5.0: step, 10.0: step}


def table_of(runs, varied="time_step_s", further=()):
    return convergence_table(runs, varied, "gap_0_03", list(further))


def chance_sweeps(noise):
    """Runs of a mill for each sweep, at three steps with four seeds: noise of shape (sweeps, 3, 4)."""
    return [
        run(step, seed, noise=noise[k, i, seed]) | {"mill": f"mill{k}"}
        for k in range(len(noise))
        for i, step in enumerate((1e-6, 2e-6, 4e-6))
        for seed in range(4)
    ]


def test_deviations_and_their_pooled_error():
    """Two steps, two seeds: v = ((s1/m1)^2 + (s2/m2)^2) / 2 and se = m2 / m1 sqrt(v (1/2 + 1/2))."""
    runs = [run(1e-6, 0, noise=-0.01), run(1e-6, 1, noise=0.01), run(2e-6, 0, noise=0.07), run(2e-6, 1, noise=0.13)]
    row = table_of(runs).iloc[1]
    relative = [np.std(pair, ddof=1) / np.mean(pair) for pair in ((0.99, 1.01), (1.07, 1.13))]
    assert row["normal_energy_deviation_percent"] == pytest.approx(10.0)
    assert row["normal_energy_deviation_se_percent"] == pytest.approx(110 * np.sqrt(np.mean(np.square(relative))))
    assert row["specific_frequency_deviation_percent"] == pytest.approx(0.0)


@pytest.mark.slow
def test_the_pooled_error_is_as_large_as_deviations_are_by_chance():
    """Of many made-up sweeps without any effect of the step, deviations over their errors have unit variance."""
    rng = np.random.default_rng(3)
    table = table_of(chance_sweeps(0.02 * rng.standard_normal((150, 3, 4))))
    coarsest = table[table["time_step_s"] == 4e-6]
    scores = coarsest["normal_energy_deviation_percent"] / coarsest["normal_energy_deviation_se_percent"]
    assert len(scores) == 150
    # Nine degrees of freedom: the variance of Student's t is 9/7; its estimate from 150 draws is within a third.
    assert np.var(scores) == pytest.approx(9 / 7, rel=1 / 3)


def test_the_stiffest_ball_is_the_reference_of_a_modulus_sweep():
    runs = [run(1e-6, 0, modulus=modulus, factor=f) for modulus, f in ((0.205, 0.9), (205.0, 1.0), (2.05, 1.05))]
    table = table_of(runs, "young_modulus_gpa")
    assert table["young_modulus_gpa"].tolist() == [205.0, 2.05, 0.205]
    assert table["power_deviation_percent"].tolist() == pytest.approx([0.0, 5.0, -10.0])


def test_the_balance_limits_the_step_if_no_descriptor_changes():
    """Balance errors of 1e-4, 4e-4, 1.6e-3 at 2, 4, 8 us against a bound of 1e-3."""
    choice = choose_step(table_of(sweep()), SETTINGS, taken(2e-6))
    (series,) = choice["series"]
    assert series["largest_step_s"] == 4e-6 and choice["verdict"] == "agrees"
    assert series["closure_order"] == pytest.approx(2.0)
    assert [step["verdict"] for step in series["steps"]] == [*["agrees"] * 4, "differs"]
    assert series["steps"][-1]["deviating"] == []
    assert "(8e-06 s differs by a balance open by 0.16 %); the step taken, 2e-06 s, agrees" in in_words(choice)


def test_each_ball_size_has_a_step_of_its_own():
    runs = [r for r in sweep((10.0, 5.0)) if not (r["case"]["ball_diameter_m"] == 0.005 and r["time_step_s"] == 5e-7)]
    for made in runs:
        if made["case"]["ball_diameter_m"] == 0.005:
            made["closure"] *= 4
    choice = choose_step(table_of(runs), SETTINGS, taken(4e-6))
    assert {s["ball_diameter_mm"]: s["largest_step_s"] for s in choice["series"]} == {5.0: 2e-6, 10.0: 4e-6}
    assert [s["verdict"] for s in choice["series"]] == ["differs", "agrees"]
    assert choice["verdict"] == "differs" and "4e-06 s, differs" in in_words(choice)
    choice = choose_step(table_of(runs), SETTINGS, {5.0: 2e-6, 10.0: 4e-6})
    assert choice["verdict"] == "agrees" and "make dem.time_step_s" not in in_words(choice)


def test_a_descriptor_that_moves_with_the_step_limits_it():
    """Energies up by 5 % at each microsecond, far over a spread of 0.1 %: only the finest step is left."""
    choice = choose_step(table_of(sweep(spread=1e-3, slope=0.05, closure=1e-3)), SETTINGS, taken(2e-6))
    (series,) = choice["series"]
    assert series["largest_step_s"] == 5e-7 and choice["verdict"] == "differs"
    assert series["steps"][2]["deviating"] == ["normal_energy_J", "tangential_energy_J"]
    assert series["steps"][2]["closes"]


def test_chance_is_not_taken_for_a_deviation_and_is_reported():
    """With a spread of 3 % and four seeds a deviation under some 6 % cannot be told; the verdict says so."""
    choice = choose_step(table_of(sweep(spread=0.03, closure=1e-3)), SETTINGS, taken(2e-6))
    (series,) = choice["series"]
    assert series["largest_step_s"] == 8e-6
    assert max(abs(step["largest_deviation_percent"]) for step in series["steps"]) > SETTINGS.tolerance_percent
    assert 4 < series["steps"][-1]["resolution_percent"] < 12


@pytest.mark.slow
def test_chance_alone_rarely_fails_a_step():
    """A confidence of 95 %: at most one in twenty sweeps without an effect fails, within its own chance."""
    rng = np.random.default_rng(5)
    choice = choose_step(table_of(chance_sweeps(0.03 * rng.standard_normal((100, 3, 4)))), SETTINGS, taken(1e-6))
    assert len(choice["series"]) == 100
    assert sum(series["largest_step_s"] < 4e-6 for series in choice["series"]) <= 11


@pytest.mark.parametrize("closure", [1e4, np.nan])
def test_no_step_passes_where_the_finest_leaves_the_balance_open(closure):
    choice = choose_step(table_of(sweep(closure=closure)), SETTINGS, taken(5e-7))
    assert choice["series"][0]["largest_step_s"] is None and choice["verdict"] == "differs"
    assert "no step agrees" in in_words(choice)
