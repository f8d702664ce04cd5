"""Errors from turns and seeds of known motions: correlated, locked onto the drive, one of several, or no impacts."""

import numpy as np
import pandas as pd
import pytest

from millprint.config.errors import ConfigError
from millprint.config.fingerprint import SearchConfig
from millprint.config.sweep import ball_count
from millprint.dem.ledger import closure
from millprint.dem.run import window_goes_on
from millprint.dem.turns import (
    drift_of_turns,
    half_width,
    has_impacts,
    is_steady,
    mean_of_turns,
    motion_repeats,
    relative_error,
)
from millprint.dose.kinetics import HITS, NORMAL, TANGENTIAL, TOTAL, own_doses
from millprint.estimate.estimates import factor_of
from millprint.estimate.judge import AGREES
from millprint.fingerprint.condition_search import rank_conditions, simulated_request
from millprint.fingerprint.descriptors import (
    MOTIONS,
    lasting_motions,
    motion_of,
    motions_in,
    said_of,
    seeds_of_motions,
    tabulate_descriptors,
    variance_of_run,
)
from millprint.fingerprint.match_words import match
from millprint.fingerprint.mill_collapse import find_zones
from millprint.fingerprint.model import LAYERS, Fingerprint
from millprint.observables.definitions import DESCRIPTOR_SETS
from millprint.run.files import read_json, write_json
from tests.refusals import truths
from tests.unit.synthetic_mill import VOLUME, still, summary


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
    # Pairs that agree: the square of the error is 1/7 by the eight means of +1 and -1, 1/15 by the sixteen turns.
    known = mean_of_turns(10 + np.repeat([1.0, -1.0] * 4, 2))
    assert known == (pytest.approx(7**-0.5), 7, pytest.approx(16 * 7 / 15))
    assert mean_of_turns([1.0]) is None and relative_error([1.0] * 7) == np.inf


@pytest.mark.parametrize(("deviation", "turns"), [(0.5, (8, 10)), (2.0, (20, 30)), (5.0, (63, 64))])
def test_a_window_that_grows_until_a_mean_is_known_knows_it(deviation, turns):
    """Windows of eight turns more until half of the interval is a tenth of the mean, or there are 64."""
    rng, ended, right = np.random.default_rng(2), [], []
    for _ in range(400):
        energies = 10 + deviation * rng.standard_normal(64)
        length = next((n for n in range(8, 64, 8) if half_width(energies[:n].tolist()) <= 0.1), 64)
        ended.append(length)
        right.append(abs(energies[:length].mean() / 10 - 1) <= 0.1)
    assert turns[0] <= np.mean(ended) <= turns[1]
    # Of 400, 95 % within three standard errors; a window that ends where chance makes it narrow loses a little.
    assert np.mean(right) > (0.88 if turns[0] < 63 else 0.8)


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


@pytest.mark.parametrize(
    ("seeds", "turns", "memory", "least", "most"),
    [
        # What they are worth, turns (1 - memory) / (1 + memory): 1, 3.4, 2.5, 2.9; and 24, 64, 64.
        *[(1, 64, 0.97, 0.85, 1), (1, 64, 0.9, 0.7, 1), (3, 16, 0.9, 0.6, 1), (3, 64, 0.97, 0.6, 1)],
        *[(3, 8, 0, 0, 0.1), (1, 64, 0, 0, 0.1), (3, 64, 0.5, 0, 0.1)],
    ],
)
def test_turns_with_a_long_memory_are_few_however_many_are_recorded(seeds, turns, memory, least, most):
    """Of fifty conditions, in the word that stands beside their numbers."""
    rng, runs = np.random.default_rng(5), []
    for condition in range(50):
        for seed in range(seeds):
            run, energies = summary(0.10 + 0.001 * condition, seed=seed), correlated(rng, turns, memory) / 10
            own = run["per_revolution"]
            run["per_revolution"] = {name: (np.mean(values) * energies).tolist() for name, values in own.items()}
            runs.append(run)
    words = tabulate_descriptors(runs, "gap_0_03")["motion"]
    assert len(words) == 50 and least <= words.str.contains(MOTIONS["few_turns"].word).mean() <= most


def test_locked_motions_repeat_and_chaotic_ones_do_not():
    rng, collisions = np.random.default_rng(2), 400.0
    chaotic = rng.poisson(collisions, 40) * 1e-4
    locked = 0.04 * (1 + 1e-4 * rng.standard_normal(40))
    of_three_turns = np.tile([0.03, 0.05, 0.04], 14) * (1 + 1e-4 * rng.standard_normal(42))
    assert not motion_repeats(chaotic, collisions)
    assert motion_repeats(locked, collisions) and motion_repeats(of_three_turns, collisions)
    of_five_turns = np.tile([0.03, 0.05, 0.04, 0.06, 0.02], 9) * (1 + 1e-4 * rng.standard_normal(45))
    assert not motion_repeats(of_five_turns, collisions), "a period of up to four turns is looked for"
    # Turns that vary by 0.3 and by 0.37 of what independent collisions would.
    steady = [1 + share * rng.standard_normal(4000) / collisions**0.5 for share in (0.3, 0.37)]
    assert [motion_repeats(turns, collisions) for turns in steady] == [True, False]
    # Too few turns tell nothing.
    assert not motion_repeats(locked[:7], collisions) and motion_repeats(locked[:8], collisions)


def test_seeds_of_several_motions_leave_their_own_degrees_of_freedom():
    within = [(0.00025**2, 7)] * 3
    apart = variance_of_run([3.0, 4.2, 3.1], within)
    assert apart.differ and apart.freedom == 2 and apart.variance == pytest.approx(np.var([3.0, 4.2, 3.1], ddof=1))
    alike = variance_of_run([3.0, 3.0002, 2.9999], within)
    # Three seeds count for as much as all of their turns.
    assert not alike.differ and alike.freedom == 4
    assert alike.variance == pytest.approx((0.00025**2 + np.var([3.0, 3.0002, 2.9999], ddof=1)) / 2)
    pair = variance_of_run([3.0, 3.0002], within[:2])
    # Two seeds have one degree of freedom beside the fourteen of their turns.
    assert not pair.differ and pair.freedom == 15
    assert pair.variance == pytest.approx((14 * 0.00025**2 + np.var([3.0, 3.0002], ddof=1)) / 15)
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
    # Turns of all seeds count: three of three are enough, and of unknown error, none has a degree of freedom.
    shorts = [summary(0.10, seed=seed) for seed in range(3)]
    for run in shorts:
        run["per_revolution"] = {name: values[:3] for name, values in run["per_revolution"].items()}
    assert MOTIONS["few_turns"].word not in tabulate_descriptors(shorts, "gap_0_03").iloc[0]["motion"]
    short["per_revolution"] = {name: [] for name in short["per_revolution"]}
    assert tabulate_descriptors([short], "gap_0_03").iloc[0]["normal_power_freedom"] == 0
    assert motion_of(1, 1, 0, 8.0, 1, False) == [MOTIONS["repeats"]] and motion_of(3, 3, 0, 8.0, 0, False) == []


@pytest.mark.parametrize(("powers", "error", "counts"), truths("groups_of_seeds"))
def test_seeds_of_one_lasting_motion_are_one_group(powers, error, counts):
    found = lasting_motions(np.array(powers), np.full(len(powers), error**2))
    assert [len(group) for group in found] == counts and np.concatenate(found).tolist() == powers


def test_the_power_of_each_lasting_motion_is_said():
    runs = [summary(0.10, seed=seed, noise=noise, error=1e-4) for seed, noise in enumerate((0.0, 0.5, 0.001))]
    (row,) = tabulate_descriptors(runs, "gap_0_03").to_dict("records")
    first, second, third = (run["power_W"]["wall"] for run in runs)
    assert row["lasting_motions"] == f"{(first + third) / 2:.2f} W in 2 and {second:.2f} W in 1 of 3 simulations"
    (row,) = tabulate_descriptors(runs[::2], "gap_0_03").to_dict("records")
    assert row["lasting_motions"] == ""


def ledger_of(turns: list[float]) -> pd.DataFrame:
    """The ledger at the ends of turns with given normal dissipation [J], a tenth of it sliding and 1 % rolling."""
    normal = np.concatenate([[0.0], np.cumsum(turns)])
    values = {"normal_damping_J": normal, "sliding_J": 0.1 * normal, "rolling_J": 0.01 * normal}
    return pd.DataFrame(values).assign(tangential_damping_J=0.0, wall_work_J=normal, potential_J=0.0)


def test_a_window_is_long_enough_by_its_turns_or_where_nothing_hits():
    steady, wild = ledger_of([10.0, 10.1] * 8), ledger_of([1.0, 30.0, 2.0, 40.0] * 4)
    assert [window_goes_on(own, 1, 0.05, 1.0) for own in (steady, wild)] == ["end", "longer"]
    # The tangential power counts from a hundredth of the whole on.
    for share, told in ((0.009, "end"), (0.013, "longer")):
        slid = share * wild["normal_damping_J"] * steady["wall_work_J"].iloc[-1] / wild["wall_work_J"].iloc[-1]
        assert window_goes_on(steady.assign(sliding_J=slid), 1, 0.05, 1.0) == told
    # Of balls that hit nothing, as many turns as an error takes are enough, however they vary.
    assert [window_goes_on(own, 1, 0.05, 1e9) for own in (wild, ledger_of([10.0] * 7))] == ["end", "longer"]
    # A power that rises by 1 % a turn moves a mean over sixteen turns by 8 %: a quarter of a half-width is let be.
    rising = ledger_of(10 * 1.01 ** np.arange(16.0))
    assert [window_goes_on(rising, 1, largest, 1.0) for largest in (0.3, 0.4)] == ["anew", "longer"]


@pytest.mark.parametrize("turns", [8, 16, 64])
def test_a_power_that_still_rises_is_told_from_one_that_scatters(turns):
    """Of 2,000 windows of steady turns, 5 % are taken for rising ones; where a run-up leaves its mark, nearly all."""
    rng, rising = np.random.default_rng(4), 1 - 0.3 * np.exp(-2 * np.arange(turns) / turns)
    windows = 10 * (1 + 0.03 * rng.standard_normal((2000, turns)))
    assert np.mean([not is_steady(own, 0.0) for own in windows]) == pytest.approx(0.05, abs=0.025)
    assert np.mean([not is_steady(own * rising, 0.0) for own in windows]) > 0.9
    # What moves a mean by no more than is allowed is let be.
    assert all(is_steady(own * rising, 0.3) for own in windows)
    assert is_steady([1.0] * turns, 0.0) and is_steady([1.0, 2.0], 0.0)


def test_a_drift_is_the_slope_of_the_line_with_its_error():
    """By the formulas of least squares: 1, 2, 4, 5 has the slope 1.4 about 3, and leaves squares of 0.2."""
    drift = drift_of_turns([1.0, 2.0, 4.0, 5.0])
    assert drift == (pytest.approx(4 * 1.4 / 3), pytest.approx(4 / 3 * np.sqrt(0.2 / 2 / 5)), 2)


def test_few_turns_are_said_where_a_power_rises_through_the_windows_of_all_seeds():
    """A rise by 15 % through sixteen turns that scatter by 3 %."""
    rng, words = np.random.default_rng(9), []
    for rise in (0.0, 0.15):
        runs = [summary(0.10, seed=seed) for seed in range(3)]
        for run in runs:
            energies = 10 * (1 + rise * np.linspace(-0.5, 0.5, 16) + 0.03 * rng.standard_normal(16))
            run["per_revolution"] |= dict.fromkeys(run["per_revolution"], energies.tolist())
        words.append(tabulate_descriptors(runs, "gap_0_03").iloc[0]["motion"])
    assert words == ["", MOTIONS["few_turns"].word]


def test_balls_that_bounce_straight_up_repeat_without_shear():
    run = summary(0.10)
    run["per_revolution"] = {name: [values[0]] * 12 for name, values in run["per_revolution"].items()}
    for channel in ("tangential", "rolling"):
        run["per_revolution"][f"{channel}_J"], run["power_W"][channel] = [0.0] * 12, 0.0
    row = tabulate_descriptors([run], "gap_0_03").iloc[0]
    assert row["motion"] == MOTIONS["repeats"].word and row["tangential_power_freedom"] == 0


def test_closure_is_the_last_imbalance_over_the_work():
    series = ledger_of([10.0, 10.0]).assign(imbalance_J=[0.0, 0.4, -0.2])
    assert closure(series) == pytest.approx(0.2 / 20)
    # Without work of the walls, a tenth of the 22.2 J dissipated.
    assert closure(series.assign(wall_work_J=0.0)) == pytest.approx(0.2 / (0.1 * 20 * 1.11))
    assert closure(0 * series) == 0.0


def test_a_layer_that_goes_round_with_the_wall_is_no_milling():
    """As simulated in a planetary jar of 250 mL at 400 rpm and fill 0.08: hits die away within the window."""
    scale = 38 * 7800 * (400 / 60) ** 2 * 0.108**2 * 0.01**3
    assert not has_impacts([1.5e-7, 5.7e-10, 2.7e-10, 2.5e-10, 2.6e-10, 2.4e-10], scale)
    assert not has_impacts([0.5, 0.3, 1e-9], scale)
    assert has_impacts([1.1, 0.9, 1.2], scale) and has_impacts([1.0] * 6 + [0.0, 1.0], scale)
    # One hit of every ball by 1 % of the wall's speed decides.
    speed = 0.01 * 2 * np.pi * 400 / 60 * 0.108
    hit = 38 * 7800 * np.pi / 6 * 0.01**3 * speed**2 / 2
    assert has_impacts([hit], scale) and not has_impacts([0.9 * hit], scale)


@pytest.mark.slow
def test_conditions_without_impacts_are_said_and_no_curve_is_made_of_them():
    layer = [still(0.04, 10.0, speed) for speed in (600.0, 900.0)]
    rest = [summary(fill, speed_rpm=speed) for fill in (0.08, 0.14, 0.20, 0.30) for speed in (600.0, 900.0)]
    table = tabulate_descriptors(layer + rest, "gap_0_03")
    assert table.loc[said_of(table, "no_impacts"), "fill_ratio"].tolist() == [0.04, 0.04]
    own = Fingerprint.fit(table, VOLUME, 0.95)
    assert own.fill_range == (0.08, 0.30) and len(own.processes["Pn"].logs) == 8
    bands = own.scaled(own.condition(speed_hz=12.0, ball_diameter_m=0.01, fill_ratio=0.1))
    assert bands["Pn_upper"].iloc[0] < 3 * bands["Pn_lower"].iloc[0]
    # One of two starts that goes round is another matter: seeds differ.
    both = tabulate_descriptors([still(0.08), summary(0.08, seed=1)], "gap_0_03")
    assert not said_of(both, "no_impacts").any()


def test_balls_that_move_with_the_wall_are_said():
    """By their speed against the vessel; a vessel at rest has none, and an earlier version did not record it."""
    shares = {0.08: 0.02, 0.14: 0.4, 0.20: None}
    runs = [summary(fill) | {"speed_over_vessel": share} for fill, share in shares.items()] + [summary(0.30)]
    table = tabulate_descriptors(runs, "gap_0_03")
    assert said_of(table, "stuck").tolist() == [True, False, False, False]
    assert "stuck" in table["motion"].iloc[0].split(", ")


def test_what_holds_for_some_seeds_is_said_with_their_number():
    runs = [summary(0.10, seed=seed) | {"speed_over_vessel": share} for seed, share in enumerate((0.02, 0.4, 0.4))]
    table = tabulate_descriptors(runs, "gap_0_03")
    (stuck,) = motions_in(table["motion"].iloc[0]).values()
    assert "1 of 3" in stuck.word and stuck.meaning == MOTIONS["stuck"].meaning and said_of(table, "stuck").all()
    assert [own.word for own in motion_of(3, 3, 3, 8.0, 0, True)] == [
        MOTIONS[name].word for name in ("stuck", "seeds_differ")
    ]


def test_the_seeds_of_each_lasting_motion_are_known():
    runs = pd.DataFrame({"wall_power_W": [1.4, 18.3, 18.31], "wall_power_variance": [1e-8, 1e-8, np.nan]})
    assert [own.tolist() for own in seeds_of_motions(runs)] == [[1, 2], [0]]


@pytest.mark.parametrize("hits", [(0.20,), (0.11, 0.15, 0.20)])
def test_nothing_is_known_between_a_condition_without_impacts_and_one_with(hits, tmp_path):
    runs = [still(fill) for fill in (0.04, 0.06)] + [summary(fill) for fill in hits]
    fitted = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    fitted.write(tmp_path / "own.json")
    own = Fingerprint.read(tmp_path / "own.json")
    assert own.fill_range == (hits[0], 0.20)
    asked = pd.DataFrame({"fill_ratio": [0.04, 0.05, 0.06, 0.07, *hits]}).assign(speed_hz=10.0, ball_diameter_mm=10.0)
    found = own.predict(asked)
    unknown, known = [True] * 4, [False] * len(hits)
    for name in ("normal_power_W", "weighted_normal_energy_J", "specific_frequency_hz"):
        for end in ("", "_upper"):
            assert found[f"{name}{end}"].isna().tolist() == unknown + known
    assert found["outside"].tolist() == [LAYERS] * 4 + [""] * len(hits)
    # Power is known of what was simulated, and not between.
    assert found["wall_power_W_upper"].isna().tolist() == [False, True, False, True, *known]
    power = [sum(run["power_W"][part] for part in ("tangential", "rolling")) for run in runs[:2]]
    assert found["wall_power_W"].iloc[[0, 2]].tolist() == pytest.approx(power, rel=1e-6)
    # A fill ratio of as many balls is the same charge, at which power is known.
    count = ball_count(0.06, VOLUME, 0.01)
    charge = own.condition(speed_hz=10.0, ball_diameter_m=0.01, number=count)
    assert own.predict(charge).wall_power_W.value == found["wall_power_W"].iloc[2]
    assert own.as_simulated(charge).fill_ratio == pytest.approx(0.06)
    assert own.as_simulated(own.condition(speed_hz=10.0, ball_diameter_m=0.01, number=count + 2)) is None
    one = own.predict(own.condition(speed_hz=10.0, ball_diameter_m=0.01, fill_ratio=0.07))
    assert np.isnan(one.tangential_share.upper) and np.isnan(one.normal_power_W.ends("mean")).all()
    assert fitted.predict(asked).equals(found)
    assert find_zones(own).empty == (len(hits) == 1)
    content = read_json(tmp_path / "own.json")
    content[LAYERS]["fill_ratio"].pop()
    write_json(content, tmp_path / "own.json")
    with pytest.raises(ConfigError, match="no_impacts: must have as many of each variable"):
        Fingerprint.read(tmp_path / "own.json")


def test_where_nothing_hits_nothing_is_dosed_or_matched(tmp_path):
    runs = [make(fill, 10.0, speed) for speed in (600.0, 1200.0) for fill, make in
            ((0.05, summary), (0.10, still), (0.20, summary), (0.30, summary))]  # fmt: skip
    own = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    fills = [0.10, 0.15, 0.20]
    asked = pd.DataFrame({"case": list("abc"), "mill": own.about["mill"], "fill_ratio": fills}).assign(
        powder_mass_g=3.0, time_h=1.0, speed_rpm=600.0, ball_diameter_mm=10.0
    )
    asked.to_csv(tmp_path / "runs.tsv", sep="\t", index=False)
    table = own_doses(tmp_path / "runs.tsv", {own.about["mill"]: own})
    assert table["outside"].tolist() == [LAYERS, LAYERS, ""]
    for name, known in {NORMAL: [0, 0, 1], TANGENTIAL: [0, 0, 1], HITS: [0, 0, 1], TOTAL: [1, 0, 1]}.items():
        assert table[name].notna().tolist() == known
    still_one, one = (own.condition(speed_rpm=600.0, ball_diameter_mm=10.0, fill_ratio=fill) for fill in (0.10, 0.20))
    with pytest.raises(ConfigError, match="nothing can be matched to it"):
        match(own, still_one, own)
    # What it had between, by the curves of its neighbours, is proposed nowhere.
    between = {name: float(value[0]) for name, value in own_curves(own, fill=0.13).items()}
    rows = rank_conditions(between, [own], SearchConfig())
    assert len(rows) and not rows["fill_ratio"].between(0.0501, 0.1999).any()
    assert match(own, one, own)["verdict"].iloc[0] == AGREES
    # The page of such a mill begins with what it can do.
    assert simulated_request(own, "weighted").targets[0].given


def own_curves(own: Fingerprint, fill: float) -> dict[str, np.ndarray]:
    """The weighted energies of a condition on the curves, as if no condition without impacts were known."""
    blind = Fingerprint(own.about, own.processes)
    found = blind.descriptors(own.condition(speed_rpm=900.0, ball_diameter_mm=10.0, fill_ratio=fill))
    return {name: found[name] for name in DESCRIPTOR_SETS["weighted"]}


def test_a_charge_without_impacts_says_nothing_of_other_balls():
    graded = {"mixture": {"name": "graded", "sizes_mm": [10.0, 5.0], "numbers": [0.5, 0.5]}}
    layers = [still(fill) for fill in (0.11, 0.15, 0.20)]
    for layer in layers:
        layer["case"] |= graded
    runs = [*layers, *(summary(fill) for fill in (0.11, 0.15, 0.20))]
    own = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    assert not len(own.layers) and own.fill_range == (0.11, 0.20)
    found = own.predict(own.condition(speed_hz=10.0, ball_diameter_m=0.01, fill_ratio=0.15))
    assert np.isfinite(found.wall_power_W.upper)


def test_where_nothing_hits_at_all_only_powers_have_curves():
    runs = [still(fill) for fill in (0.04, 0.06, 0.10)]
    own = Fingerprint.fit(tabulate_descriptors(runs, "gap_0_03"), VOLUME, 0.95)
    assert set(own.processes) == {"P", "Pw"} and "nothing hits" in own.about["no_curve"]["En_star"]
    found = own.predict(own.condition(speed_hz=10.0, ball_diameter_m=0.01, fill_ratio=0.06))
    assert np.isfinite(found.wall_power_W.upper) and np.isnan(found.normal_energy_J.value)


def test_an_interval_of_several_orders_of_magnitude_is_not_known():
    assert factor_of(np.log(3.0)) == pytest.approx(3.0)
    assert np.isnan(factor_of(np.array([5.0, 80.0]))).all()
