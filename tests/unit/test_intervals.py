"""A verdict follows from the interval of a claim."""

import numpy as np
import pandas as pd
import pytest

from draw_claims import judge_by_jars
from millprint.estimate.estimates import largest_difference, range_of_single, spread_of
from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.fingerprint.descriptors import block_length
from millprint.run.files import read_table, write_json, write_table
from millprint.thesis.claims.evidence import Contradiction, Finding, Repeats, judge_repeats, judge_value
from millprint.thesis.claims.tabulate import (
    WINDOWS,
    Repeated,
    collect_findings,
    interval_from,
    over_draws,
    over_repeats,
    tabulate_claims,
    tabulate_intervals,
    without_sizes,
)
from millprint.thesis.fit.jar_search import JAR_PARAMETERS
from millprint.thesis.scaling import dispersions, draw_blocks, draw_tables, redraw, redrawn_tables, tables_of
from millprint.thesis.surrogate.measures import failed_tests
from tests.conftest import ROOT
from tests.refusals import truths
from tests.unit import synthetic_mill

CLAIMS_TSV = ROOT / "config/data/claims.tsv"


@pytest.mark.parametrize(("published", "tolerance", "lower", "upper", "word"), truths("verdicts_on_repeats"))
def test_repeats_of_numbers_pairs_and_words_are_judged(published, tolerance, lower, upper, word):
    for of, expected in ((5, word), (None, word), (4, OPEN)):
        assert (
            judge_repeats(published, tolerance, Finding(upper, repeats=Repeats(lower, upper, "seeds", of))).word
            == expected
        )


def test_the_value_has_a_verdict_of_its_own():
    found = Finding(22.9, repeats=Repeats(10, 40, "seeds", 9), contradiction=Contradiction("Table 1", "2 + 2 = 4"))
    assert judge_value("20", "15%", found).agrees
    assert judge_repeats("20", "15%", found) == (OPEN, "wider than the tolerance")
    assert judge_repeats("20", "15%", Finding(22.9)) is None and judge_repeats("20", "15%", Finding(None)) is None


@pytest.mark.parametrize(("value", "repeats", "jars", "told"), truths("verdicts_on_jars"))
def test_a_claim_that_only_some_of_the_jars_that_fit_meet_is_open(value, repeats, jars, told):
    own = Repeats(*repeats, "", 9) if repeats else None
    found = judge_repeats("20", "15%", Finding(value, repeats=own, jars=tuple(jars)))
    assert (found and found.word) == told[0] and told[1] in (found.reason if found else "")


def test_a_statement_that_only_some_of_the_jars_meet_is_open():
    assert judge_repeats("yes", "yes", Finding("yes", jars=("yes", "no"))).word == OPEN
    assert judge_repeats("yes", "yes", Finding("no", jars=("no", "no"))).word == DIFFERS
    assert judge_repeats("yes", "yes", Finding("yes", jars=("yes", "yes"))).word == AGREES


def test_an_interval_of_few_repeats_is_their_range_and_of_more_holds_student():
    assert spread_of([13.1, 3.9, 20.1]) == (3.9, 20.1)
    assert spread_of([2.0, 3e20, 5.0, 1.0]) == (1.0, 3e20)
    low, high = spread_of([-1.0, -0.5, 0.0, 0.5, 1.0])
    assert (low, high) == (-1.0, 1.0)
    # t(4) s / sqrt(5) = 2.7764 x 0.7906 / 2.2361 = 0.98, within the five themselves; of twenty equal spreads it is not.
    values = np.concatenate([np.zeros(4), [1.0]])
    low, high = spread_of(values)
    assert (low, high) == pytest.approx((0.2 - 2.7764 * 0.44721 / 5**0.5, 1.0), rel=1e-4)
    # Of one more: t(4) s sqrt(1 + 1/5).
    reach = 2.7764 * 0.44721 * 1.2**0.5
    assert spread_of(values, one_more=True) == pytest.approx((0.2 - reach, 0.2 + reach), rel=1e-4)
    assert spread_of([2.5, 23.1, np.inf]) == (2.5, np.inf) and spread_of([3.0, 3.0]) == (3.0, 3.0)
    with pytest.raises(ValueError, match="two repeats"):
        spread_of([1.0])
    assert largest_difference([2.5, 23.1, 9.0]) == pytest.approx(20.6) and largest_difference([1.0, np.inf]) == np.inf
    assert range_of_single(6.0, [5.0, 5.5, 4.5]) == (5.0, 7.0) and range_of_single(6.0, [5.0, 5.0, 17.0]) == (0.0, 18.0)
    assert range_of_single(6.0, [5.0, np.inf]) == (0.0, np.inf)
    assert range_of_single(6.0, [-1.0, 9.0]) == (-4.0, 16.0) and range_of_single(-1.0, [0.0, 2.0]) == (-3.0, 1.0)


@pytest.mark.parametrize("trainings", [5, 8])
def test_an_interval_of_five_repeats_and_more_covers_the_mean_as_often_as_it_says(trainings):
    rng, inside = np.random.default_rng(1), []
    for _ in range(1000):
        low, high = spread_of(3 + 0.8 * rng.standard_normal(trainings))
        inside.append(low <= 3 <= high)
    assert np.mean(inside) > 0.94


@pytest.mark.parametrize("trainings", [3, 5, 8])
def test_no_interval_leaves_the_sizes_of_its_repeats(trainings):
    """Of repeats over many decades, as of roll-outs that run away, the mean lies within their own sizes."""
    rng = np.random.default_rng(4)
    for _ in range(300):
        values = np.exp(20 * rng.standard_normal(trainings))
        low, high = spread_of(values)
        assert high <= 2.5 * values.max() and low >= -2 * values.max()


def test_draws_of_words_are_certain_or_not():
    assert over_draws("yes", ["yes"] * 196 + ["no"] * 4, 0.95) == Repeats("yes", "yes", WINDOWS, 200)
    assert over_draws("yes", ["yes"] * 190 + ["no"] * 10, 0.95) == Repeats("no", "yes", WINDOWS, 200)
    assert over_repeats("yes", ["yes", "yes", "no"], 0.95) == Repeats("no", "yes", "trainings", 3)
    # A draw without a number is another statement; one training has no interval.
    assert over_draws("2", ["2", "none", "2"], 0.95) == Repeats("none", "2", WINDOWS, 3)
    assert over_repeats("2", ["2"], 0.95) == Repeats(2.0, 2.0, "trainings", 1)
    # Where the run itself failed, its first repeat that did not stands for it.
    found, failed = [Finding("yes"), Finding("no"), Finding("x", failed=True)], Finding("x", failed=True)
    interval = interval_from(found, failed, Repeated([{}], over_repeats), 0.95)
    assert interval == Repeats("no", "yes", "trainings", 3, 1)
    # An interval is about the value of the run itself, and holds it.
    moved = over_draws(9.0, [1.0, 2.0, 3.0], 0.95)
    assert (moved.lower, moved.upper) == pytest.approx((8.05, 9.95))


def test_blocks_keep_neighbours_together_and_differ():
    assert [block_length(n) for n in (1, 2, 3, 8, 27, 100)] == [1, 1, 1, 2, 3, 5]
    series = [np.arange(27.0)[:, None], 100 + np.arange(27.0)[:, None]]
    drawn = draw_blocks(series, 27, np.random.default_rng(0))[:, 0]
    assert len(drawn) == 27
    steps = np.diff(drawn.reshape(9, 3), axis=1)
    assert np.isin(steps, [1, -26]).all() and (drawn >= 100).any() and (drawn < 100).any()


def test_drawn_means_scatter_as_independent_runs_do():
    """A first-order chain with a known standard error of its mean: blocks see most of it, single revolutions half."""
    rng, n, phi = np.random.default_rng(4), 200, 0.5
    chain = np.zeros(n)
    for i in range(1, n):
        chain[i] = phi * chain[i - 1] + rng.standard_normal()
    true = 1 / (1 - phi) / n**0.5
    by_blocks = np.std([draw_blocks([chain[:, None]], n, rng).mean() for _ in range(800)])
    alone = np.std([rng.choice(chain, n).mean() for _ in range(800)])
    assert by_blocks == pytest.approx(true, rel=0.3) and alone < 0.75 * true


@pytest.mark.slow
def test_intervals_of_a_spread_cover_as_often_as_they_say():
    """Two seeds of 40 correlated revolutions, drawn again: the coefficient of variation of the process is inside."""
    rng, inside, phi, spread = np.random.default_rng(8), [], 0.3, 0.1
    for _ in range(80):
        series = []
        for _ in range(2):
            chain = rng.standard_normal(40) * (1 - phi**2) ** 0.5
            chain[0] /= (1 - phi**2) ** 0.5
            for i in range(1, len(chain)):
                chain[i] += phi * chain[i - 1]
            series.append((1 + spread * chain)[:, None])
        both = [np.concatenate([draw_blocks(series, 40, rng) for _ in series]) for _ in range(100)]
        own = np.concatenate(series)
        interval = over_draws(own.std() / own.mean(), [one.std() / one.mean() for one in both], 0.95)
        inside.append(float(interval.lower) <= spread <= float(interval.upper))
    assert np.mean(inside) > 0.86


def summaries(counts=(1000, 1000)) -> list[dict]:
    rng = np.random.default_rng(5)
    found = []
    for seed, count in enumerate(counts):
        summary = synthetic_mill.summary(seed=seed)
        energies = 1 + 0.1 * rng.standard_normal(20)
        summary["per_revolution"] = {
            "normal_J": energies.tolist(),
            "tangential_J": (2 * energies).tolist(),
            "rolling_J": (0.1 / energies).tolist(),
            "wall_J": [],
            "normal_square_J2": (3 * energies**2).tolist(),
            "tangential_square_J2": (5 * energies).tolist(),
        }
        summary["collisions"] = [
            rule | {"count": count, "frequency_hz": float(count)} for rule in summary["collisions"]
        ]
        found.append(summary)
    return found


def test_collisions_scatter_as_their_seeds_do_and_never_less_than_chance():
    (name, alike), *_ = dispersions([summaries()]).items()
    assert alike == 1.0
    # Two seeds 10 % apart: variance over mean of 900 and 1100 is 20000 / 1000.
    assert dispersions([summaries((900, 1100))])[name] == pytest.approx(20)
    assert dispersions([summaries((900,))]) == {}


def test_drawn_runs_keep_what_belongs_together():
    own = summaries()
    drawn = redraw(own, np.random.default_rng(6))
    again = redraw(own, np.random.default_rng(6))
    for run, other, before in zip(drawn, again, own, strict=True):
        assert run == other and run["case"] == before["case"]
        energies = run["per_revolution"]
        np.testing.assert_allclose(energies["tangential_J"], 2 * np.array(energies["normal_J"]))
        factor = np.mean(energies["normal_J"]) / np.mean(before["per_revolution"]["normal_J"])
        power = run["power_W"]
        assert power["normal"] == pytest.approx(factor * before["power_W"]["normal"])
        assert power["wall"] == pytest.approx(power["normal"] + power["tangential"] + power["rolling"])
        assert factor != 1
        squares = np.mean(energies["normal_square_J2"]) / np.mean(before["per_revolution"]["normal_square_J2"])
        new, old = run["weighted"]["normal"], before["weighted"]["normal"]
        assert new["energy_J"] == pytest.approx(old["energy_J"] * squares / factor)
        # E* times f* is the power.
        assert new["energy_J"] * new["specific_frequency_hz"] == pytest.approx(
            factor * old["energy_J"] * old["specific_frequency_hz"]
        )
        for rule, earlier in zip(run["collisions"], before["collisions"], strict=True):
            total = rule["mean_normal_J"] * rule["frequency_hz"]
            assert total == pytest.approx(factor * earlier["mean_normal_J"] * earlier["frequency_hz"])


def test_drawn_runs_without_shear_have_none():
    own = summaries()
    for run in own:
        run["per_revolution"] |= dict.fromkeys(("tangential_J", "tangential_square_J2", "rolling_J"), [0.0] * 20)
        run["power_W"] |= {"tangential": 0.0, "rolling": 0.0, "wall": run["power_W"]["normal"]}
    for run in redraw(own, np.random.default_rng(6)):
        assert run["power_W"]["tangential"] == run["power_W"]["rolling"] == 0
        assert run["power_W"]["wall"] == pytest.approx(run["power_W"]["normal"])
        assert np.isfinite(run["weighted"]["tangential"]["energy_J"])


@pytest.mark.parametrize(("counts", "spread"), [((1000, 1000), 1), ((900, 1100), 20)])
def test_drawn_counts_scatter_as_chance_and_their_seeds_do(counts, spread):
    rng, own = np.random.default_rng(7), summaries(counts)
    drawn = [redraw(own, rng)[0]["collisions"][0]["count"] for _ in range(400)]
    # Of 400 draws, a standard deviation is known within 3.5 %.
    assert np.std(np.log(drawn)) == pytest.approx((spread / counts[0]) ** 0.5, rel=0.15)
    assert np.median(drawn) == pytest.approx(counts[0], rel=0.03)


def measures(error: float) -> pd.DataFrame:
    ran_away = error > 1e3
    names = {"dissipation_error_percent": error, "one_step_dissipation_bias_percent": 1.0}
    names |= {"one_step_acceleration_r2": 0.9, "stable": float(not ran_away), "balls_left": 24.0 * ran_away}
    names |= {"mean_square_speed_ratio": 1e20 if ran_away else 1.0, "first_left_s": 0.5}
    rows = [{"variant": "thesis", "test": "trained", "measure": name, "value": value} for name, value in names.items()]
    return pd.DataFrame(rows).assign(dem_reference=0.5, length_s=15)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ((2.5, 2.4, 2.45, 2.2, 2.3), (AGREES, AGREES)),
        ((2.5, 23.1, 9.4, 3.1, 2.2), (AGREES, OPEN)),
        ((30.0, 33.0, 31.0, 29.0, 30.5), (DIFFERS, DIFFERS)),
        # One of five ran away: it is a miss, and the interval is that of the others.
        ((30.0, 33.0, 31.0, 29.0, 3e20), (DIFFERS, DIFFERS)),
        ((2.5, 2.4, 2.45, 2.2, 3e20), (AGREES, OPEN)),
        ((30.0, 3.9, 20.1), (DIFFERS, OPEN)),
    ],
)
def test_a_claim_is_computed_again_by_its_own_code_with_each_training(tmp_path, errors, expected):
    for table in (tmp_path / "surrogate/thesis/metrics.tsv", tmp_path / "surrogate/metrics.tsv"):
        write_table(measures(errors[0]), table)
    path, held = "surrogate/thesis/metrics.tsv", [error for error in errors if error < 1e3]
    trained = Repeated([{path: without_sizes(measures(error))} for error in errors], over_repeats)
    intervals = tabulate_intervals(tmp_path, CLAIMS_TSV, [trained])
    row = intervals.set_index("id").loc["6.energy"]
    # An error is not below zero.
    ends = [max(0.0, end) for end in spread_of(held, one_more=True)]
    assert (row["lower"], row["upper"]) == pytest.approx(ends)
    assert row["interval_from"] == "trainings"
    assert (row["repeats"], row["failed"]) == (len(errors), len(errors) - len(held))
    # From a file, the ends are texts.
    write_table(intervals, tmp_path / "intervals.tsv")
    as_text = pd.read_csv(tmp_path / "intervals.tsv", sep="\t", dtype=str)
    table = tabulate_claims(CLAIMS_TSV, collect_findings(tmp_path, CLAIMS_TSV, intervals=as_text)).set_index("id")
    assert tuple(table.loc["6.energy", ["verdict", "interval_verdict"]]) == expected
    assert table["interval_from"]["6.energy"] == "trainings"
    told = table["explanation"]["6.energy"]
    assert "over 15 s of the motion of the training" in told
    assert ("1 of 5 repeats failed, which are misses" in told) == (len(held) < len(errors))
    assert table["interval_from"]["2.full_factorial"] == ""


def test_a_miss_of_a_smaller_training_is_open_and_its_number_still_differs(tmp_path):
    for epochs, word in ((40, OPEN), (2000, DIFFERS)):
        write_table(measures(30.0), tmp_path / "surrogate/thesis/metrics.tsv")
        write_table(pd.DataFrame({"epoch": range(epochs)}), tmp_path / "surrogate/thesis/loss.tsv")
        drawn = [{"surrogate/thesis/metrics.tsv": measures(error)} for error in (30.0, 33.0, 31.0, 29.0, 30.5)]
        intervals = tabulate_intervals(tmp_path, CLAIMS_TSV, [Repeated(drawn, over_repeats)])
        table = tabulate_claims(CLAIMS_TSV, collect_findings(tmp_path, CLAIMS_TSV, intervals=intervals))
        row = table.set_index("id").loc["6.energy"]
        assert (row["verdict"], row["interval_verdict"]) == (DIFFERS, word)
        assert (f"{epochs} of the thesis's 2,000 epochs" in row["reason"]) == (epochs == 40)


def test_a_longer_roll_out_tells_what_the_thesis_compares(tmp_path):
    write_table(measures(2.0), tmp_path / "surrogate/thesis/metrics.tsv")
    time_s = np.linspace(0, 15, 151)
    # Right for 5 s, and then without any dissipation.
    course = pd.DataFrame({"test": "trained", "time_s": time_s, "surrogate_J": np.minimum(time_s, 5), "dem_J": time_s})
    write_table(course, tmp_path / "surrogate/thesis/dissipation.tsv")
    told = collect_findings(tmp_path, CLAIMS_TSV, "6.energy")["6.energy"].explanation
    assert "over the first 5 s, which the thesis compares, 0" in told


def test_an_interval_ends_where_the_quantity_does():
    assert Repeats(0.9, 1.2, "trainings", 5).within((-1, 1)) == Repeats(0.9, 1, "trainings", 5)
    assert Repeats("no", "yes", "trainings", 5).within((-1, 1)) == Repeats("no", "yes", "trainings", 5)


@pytest.mark.slow
def test_a_claim_on_the_curves_is_drawn_from_its_own_simulations(tmp_path):
    runs = synthetic_mill.summaries(contacts=("calibrated", "steel"), fills=(0.06, 0.10, 0.17))
    settings = {"mill": "emax", "contacts": ["calibrated", "steel"], "counting_rule": "gap_0_02", "further_rules": []}
    tables = draw_tables(runs, [], 5, 7, **settings)
    assert len(tables) == 5 and not tables[0]["fingerprint/descriptors.tsv"].equals(
        tables[1]["fingerprint/descriptors.tsv"]
    )
    for path, table in redrawn_tables(runs, [], np.random.default_rng(0), **settings).items():
        write_table(table, tmp_path / path)
    for contact in settings["contacts"]:
        write_json({"about": {"mill": "emax"}}, tmp_path / f"fingerprint/fingerprint_{contact}.json")
    table = tabulate_intervals(tmp_path, CLAIMS_TSV, [Repeated(tables, over_draws)]).set_index("id")
    own = table[table["interval_from"] == WINDOWS]
    wanted = {"3.curve.0.06.Pn", "3.curve.0.10.f", "3.collapse", "3.reference.En", "3.frequency.calibrated"}
    assert wanted <= set(own.index) and (own["repeats"] == 5).all()
    spread = table.loc["3.curve.0.10.Pn"]
    # Revolutions ripple by 10 %, so their mean over two speeds and two sizes by a few per cent at most.
    assert 0 < spread["upper"] / spread["lower"] - 1 < 0.1


@pytest.mark.slow
def test_every_jar_says_what_its_own_simulations_give(tmp_path):
    """The second jar dissipates twice as much; jars have no simulations of steel."""
    both = synthetic_mill.summaries(contacts=("calibrated", "steel"), fills=(0.06, 0.10, 0.17))
    for path, table in tables_of(both, "emax", ["calibrated", "steel"], "gap_0_02").items():
        write_table(table, tmp_path / path)
    for contact in ("calibrated", "steel"):
        write_json({"about": {"mill": "emax"}}, tmp_path / f"fingerprint/fingerprint_{contact}.json")
    own = synthetic_mill.summaries(contacts=("calibrated",), fills=(0.06, 0.10, 0.17))
    twice = [run | {"power_W": {name: 2 * power for name, power in run["power_W"].items()}} for run in own]
    paths = [str(tmp_path / f"{number}.json") for number in (1, 2)]
    for runs, path in zip((own, twice), paths, strict=True):
        write_json({"runs": runs}, path)
    shape = {"misfit": 0.1, "held_back_misfit": 0.2} | dict.fromkeys(JAR_PARAMETERS, 1.0)
    jars = pd.DataFrame({"jar": [1, 2, 3], "counting_rule": ["gap_0_02"] * 3}).assign(**shape)
    write_table(jars, tmp_path / "jars.tsv")
    table = judge_by_jars(
        str(tmp_path), CLAIMS_TSV, str(tmp_path / "jars.tsv"), paths, "calibrated", "emax", str(tmp_path / "by_jar.tsv")
    )
    assert judge_by_jars(str(tmp_path), CLAIMS_TSV, None, [], "", "emax", str(tmp_path / "none.tsv")).empty
    assert not table["id"].str.contains("steel").any() and "3.universal" not in set(table["id"])
    # The third jar is one that is not simulated.
    first, second = table.loc[table["id"] == "3.curve.0.10.Pn", "value"]
    assert second == pytest.approx(2 * first)
    # Of a claim that reads another file too, what jars change is drawn all the same.
    assert "4.own.equal_power.gain" in set(table["id"])
    ratio = table[table["id"] == "3.curve.0.10.ratio"]
    assert ratio["value"].nunique() == 1 and ratio["jar"].tolist() == [1, 2]
    # A file has texts, and the table of claims the least, the most, and how many meet it.
    findings = collect_findings(tmp_path, CLAIMS_TSV, jars=read_table(tmp_path / "by_jar.tsv", text=["id", "value"]))
    row = tabulate_claims(CLAIMS_TSV, findings).set_index("id").loc["3.curve.0.10.Pn"]
    assert float(row["jars_upper"]) == pytest.approx(2 * float(row["jars_lower"]), rel=1e-4)
    assert row["jars_meeting"].endswith(" of 2")


def test_a_training_that_ran_away_has_no_size():
    """Whatever number its error is; one that lost a ball and did not run away keeps its number."""

    def training(error: float, left: float, ratio: float) -> pd.DataFrame:
        measures = {"dissipation_error_percent": error, "balls_left": left, "mean_square_speed_ratio": ratio}
        return pd.DataFrame([{"test": "motion1", "measure": name, "value": value} for name, value in measures.items()])

    found = [training(16.1, 0, 1.1), training(11.9, 1, 1.2), training(3e20, 24, 1e20), training(np.nan, 24, np.nan)]
    assert [failed_tests(table) for table in found] == [set(), set(), {"motion1"}, {"motion1"}]
    kept = [without_sizes(table).set_index("measure")["value"] for table in found]
    assert [one["dissipation_error_percent"] for one in kept] == [16.1, 11.9, np.inf, np.inf]
    assert [one["balls_left"] for one in kept] == [0, 1, 24, 24]
