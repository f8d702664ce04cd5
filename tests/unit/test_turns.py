"""Errors from turns and seeds of known motions: correlated, locked onto the drive, or one of several."""

import numpy as np
import pytest

from millprint.dem.turns import mean_of_turns, relative_error, repeats
from millprint.fingerprint.descriptors import tabulate_descriptors
from millprint.fingerprint.seeds import MOTIONS, variance_of_run
from tests.unit.synthetic_mill import summary


def correlated(rng: np.random.Generator, turns: int, memory: float) -> np.ndarray:
    """Energies of turns of variance 1 about 10, each with a part `memory` of the one before."""
    values, draws = [rng.standard_normal()], rng.standard_normal(turns - 1)
    for draw in draws:
        values.append(memory * values[-1] + np.sqrt(1 - memory**2) * draw)
    return 10 + np.array(values)


def test_the_error_of_independent_turns_is_their_deviation_over_the_root_of_their_number():
    rng = np.random.default_rng(0)
    values = 10 + rng.standard_normal(12)
    known = mean_of_turns(values)
    assert known.error == pytest.approx(values.std(ddof=1) / np.sqrt(12)) and known.freedom == 11
    assert known.independent == pytest.approx(12)
    assert mean_of_turns([1.0]) is None and relative_error([1.0] * 7) == np.inf


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.8])
def test_the_error_of_correlated_turns_is_that_of_their_mean(memory):
    rng, turns = np.random.default_rng(1), 256
    runs = [correlated(rng, turns, memory) for _ in range(200)]
    true = np.std([run.mean() for run in runs])
    found = [mean_of_turns(run) for run in runs]
    assert np.median([known.error for known in found]) == pytest.approx(true, rel=0.35)
    plain = np.median([run.std(ddof=1) / np.sqrt(turns) for run in runs])
    assert memory == 0 or plain < 0.65 * true
    worth = np.median([known.independent for known in found])
    assert worth == pytest.approx(turns * (1 - memory) / (1 + memory), rel=0.6)


def test_locked_motions_repeat_and_chaotic_ones_do_not():
    rng, collisions = np.random.default_rng(2), 400.0
    chaotic = rng.poisson(collisions, 40) * 1e-4
    locked = 0.04 * (1 + 1e-4 * rng.standard_normal(40))
    of_three_turns = np.tile([0.03, 0.05, 0.04], 14) * (1 + 1e-4 * rng.standard_normal(42))
    assert not repeats(chaotic, collisions)
    assert repeats(locked, collisions) and repeats(of_three_turns, collisions)
    # Too few turns tell nothing.
    assert not repeats(locked[:8], collisions) and repeats(locked[:9], collisions)


def test_chance_is_seldom_taken_for_a_locked_motion():
    rng = np.random.default_rng(3)
    found = [repeats(rng.poisson(100, turns), 100.0) for turns in (6, 9, 12, 40) for _ in range(1000)]
    assert np.mean(found) < 0.003


def test_seeds_of_several_motions_leave_their_own_degrees_of_freedom():
    within = [(0.00025**2, 7)] * 3
    apart = variance_of_run([3.0, 4.2, 3.1], within)
    assert apart.differ and apart.freedom == 2 and apart.variance == pytest.approx(np.var([3.0, 4.2, 3.1], ddof=1))
    alike = variance_of_run([3.0, 3.0002, 2.9999], within)
    assert not alike.differ and alike.freedom == 23 and alike.variance >= within[0][0] * 0.9
    assert variance_of_run([3.0], []) is None
    assert variance_of_run([3.0, 3.0], [(0.0, 7)] * 2) == (0.0, 15, False)


def test_seeds_of_one_motion_are_seldom_taken_for_several():
    rng = np.random.default_rng(4)
    found = [
        variance_of_run(rng.normal(1, 0.1, 3).tolist(), [(0.01 * chi / 7, 7) for chi in rng.chisquare(7, 3)]).differ
        for _ in range(2000)
    ]
    assert np.mean(found) < 0.02


def test_the_error_of_several_seeds_contains_their_spread_and_the_motion_is_said():
    powers = (0.6, 1.0, 1.4)
    runs = [summary(0.10, seed=seed, noise=power - 1, error=1e-4) for seed, power in enumerate(powers)]
    row = tabulate_descriptors(runs, "gap_0_03").iloc[0]
    assert row["normal_power_se_W"] == pytest.approx(row["normal_power_seed_sd_W"] / np.sqrt(3))
    assert row["Pn_se"] / row["Pn"] == pytest.approx(0.4 / np.sqrt(3))
    assert row["normal_power_freedom"] == 2 and row["motion"] == MOTIONS["seeds_differ"].word
    for run in runs:
        turns = len(run["per_revolution"]["normal_J"])
        run["per_revolution"] = {name: [values[0]] * turns for name, values in run["per_revolution"].items()}
    words = tabulate_descriptors(runs, "gap_0_03").iloc[0]["motion"].split(", ")
    assert words == [MOTIONS[name].word for name in ("repeats", "seeds_differ")]
    (short,) = [summary(0.10)]
    short["per_revolution"] = {name: values[:3] for name, values in short["per_revolution"].items()}
    assert tabulate_descriptors([short], "gap_0_03").iloc[0]["motion"] == MOTIONS["few_turns"].word
