"""A verdict follows from the interval of a claim, and two machines do not contradict each other."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scripts.store_verdicts import main

from millprint.claims.compare import verdict
from millprint.claims.elsewhere import (
    EXPECTED,
    TIMED,
    UNEXPECTED,
    compare_verdicts,
    in_a_line,
    read_stored,
    with_run,
)
from millprint.claims.evidence import Evidence, Finding, Interval
from millprint.claims.intervals import WINDOWS, Repeated, over_draws, over_repeats, tabulate_intervals
from millprint.claims.tabulate import collect_findings, tabulate_claims
from millprint.claims.verdicts import DEVIATES, REPRODUCED, UNDECIDED
from millprint.errors import ConfigError
from millprint.files import write_json, write_table
from millprint.fingerprint.redraw import block_length, dispersions, draw_blocks, draw_tables, redraw, redrawn_tables
from millprint.repeats import apart, once, student
from millprint.surrogate.spread import failed_tests, tabulate_trainings, with_failures, with_spread
from tests.conftest import ROOT
from tests.unit import synthetic_mill

CLAIMS_TSV = ROOT / "config/data/claims.tsv"


@pytest.mark.parametrize(
    ("published", "tolerance", "lower", "upper", "expected"),
    [
        ("20", "15%", 18, 22, REPRODUCED),
        ("20", "15%", 22, 24, UNDECIDED),
        ("20", "15%", 24, 26, DEVIATES),
        # Both ends are outside, and the printed number is between them.
        ("20", "15%", 10, 40, UNDECIDED),
        ("2.78", "<=2.78", 1, 2, REPRODUCED),
        ("2.78", "<=2.78", 1, 23.1, UNDECIDED),
        ("2.78", "<=2.78", 9.4, 53, DEVIATES),
        # A bound on the value does not ask for the printed one.
        ("small", "<=15%", 16, 30, DEVIATES),
        ("46.62", "<=46.62", 30, float("inf"), UNDECIDED),
        ("0.30/0.045", "recover", "0.29/0.044", "0.31/0.046", REPRODUCED),
        ("0.30/0.045", "recover", "0.29/0.044", "0.33/0.046", UNDECIDED),
        ("0.30/0.045", "recover", "0.33/0.044", "0.35/0.046", DEVIATES),
        ("yes", "yes", "yes", "yes", REPRODUCED),
        ("yes", "yes", "no", "yes", UNDECIDED),
        ("yes", "report", "no", "no", DEVIATES),
    ],
)
def test_a_known_interval_gives_its_verdict(published, tolerance, lower, upper, expected):
    value = upper if isinstance(upper, str) else (lower + min(upper, 100)) / 2
    assert verdict(published, tolerance, Finding(value, interval=Interval(lower, upper, "seeds"))) == expected


def test_without_an_interval_and_with_an_erratum_the_point_decides():
    assert verdict("20", "15%", Finding(22.9)) == REPRODUCED
    assert verdict("20", "15%", Finding(4, erratum="a reason", interval=Interval(1, 40, "seeds"))) == "erratum"


def test_student_is_that_of_a_table_and_holds_every_repeat():
    low, high = student([-1.0, 0.0, 1.0])
    assert (low, high) == pytest.approx((-4.3027 / 3**0.5, 4.3027 / 3**0.5), rel=1e-4)
    # Positive values as factors: the geometric mean of 1, 10 and 100 is in the middle of the logarithms.
    low, high = student([1.0, 10.0, 100.0])
    assert low * high == pytest.approx(100) and low < 1 and high > 100
    assert student([2.5, 23.1, np.inf]) == (2.5, np.inf)
    assert student([3.0, 3.0]) == pytest.approx((3.0, 3.0))
    with pytest.raises(ValueError, match="two repeats"):
        student([1.0])
    assert apart([2.5, 23.1, 9.0]) == pytest.approx(20.6) and apart([1.0, np.inf]) == np.inf
    low, high = once(6.0, [5.0, 5.5, 4.5])
    assert low < 6.0 < high and once(6.0, [5.0, np.inf]) == (0.0, np.inf)


@pytest.mark.parametrize("trainings", [2, 3, 5])
def test_student_covers_as_often_as_it_says(trainings):
    rng, inside = np.random.default_rng(1), []
    for _ in range(1000):
        low, high = student(np.exp(1 + 0.8 * rng.standard_normal(trainings)))
        inside.append(low <= np.exp(1) <= high)
    assert np.mean(inside) == pytest.approx(0.95, abs=0.025)


def test_two_machines_do_not_contradict_each_other():
    """Each machine draws its own trainings; a flip needs two intervals that both miss the mean, on opposite sides.

    At a level of 0.95 that is 2 x 0.025^2 = 0.1 % of pairs for a mean at the tolerance itself, where it is likeliest.
    With single values, as verdicts were before, every second pair flips.
    """
    rng, flips, single = np.random.default_rng(2), 0, 0
    pairs = 3000
    for _ in range(pairs):
        machines = np.exp(np.log(2.78) + 0.7 * rng.standard_normal((2, 3)))
        found = {
            verdict("2.78", "<=2.78", Finding(one[0], interval=Interval(*student(one), "trainings")))
            for one in machines
        }
        flips += {REPRODUCED, DEVIATES} <= found
        single += len({verdict("2.78", "<=2.78", Finding(one[0])) for one in machines}) == 2
    assert flips <= 0.004 * pairs and single > 0.4 * pairs


def test_intervals_that_both_hold_the_bound_never_flip():
    rng = np.random.default_rng(3)
    for _ in range(500):
        bound = rng.uniform(1, 50)
        found = set()
        for _ in range(2):
            lower, upper = bound * rng.uniform(0.2, 1), bound * rng.uniform(1.001, 5)
            found.add(
                verdict(f"{bound:.6f}", f"<={bound:.6f}", Finding(upper, interval=Interval(lower, upper, "seeds")))
            )
        assert not {REPRODUCED, DEVIATES} <= found


def test_draws_of_words_are_certain_or_not():
    assert over_draws("yes", ["yes"] * 196 + ["no"] * 4, 0.95) == Interval("yes", "yes", WINDOWS)
    assert over_draws("yes", ["yes"] * 190 + ["no"] * 10, 0.95) == Interval("no", "yes", WINDOWS)
    assert over_repeats("yes", ["yes", "yes", "no"], 0.95) == Interval("no", "yes", "trainings")
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
        assert run["power_W"]["normal"] == pytest.approx(factor * before["power_W"]["normal"])
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


def measures(error: float) -> pd.DataFrame:
    names = {"dissipation_error_percent": error, "one_step_dissipation_bias_percent": 1.0}
    names |= {"one_step_acceleration_r2": 0.9, "stable": 1.0, "mean_square_speed_ratio": 1.0, "balls_left": 0.0}
    rows = [{"variant": "thesis", "test": "trained", "measure": name, "value": value} for name, value in names.items()]
    return pd.DataFrame(rows).assign(dem_reference=0.5)


@pytest.mark.parametrize(
    ("errors", "expected"),
    [((2.5, 2.4, 2.45), REPRODUCED), ((2.5, 23.1, 9.4), UNDECIDED), ((30.0, 33.0, 31.0), DEVIATES)],
)
def test_a_claim_is_computed_again_by_its_own_code_with_each_training(tmp_path, errors, expected):
    for table in (tmp_path / "surrogate/thesis/metrics.tsv", tmp_path / "surrogate/metrics.tsv"):
        write_table(measures(errors[0]), table)
    path = "surrogate/thesis/metrics.tsv"
    trained = Repeated("trainings", [{path: measures(error)} for error in errors], over_repeats)
    intervals = tabulate_intervals(tmp_path, CLAIMS_TSV, [trained])
    row = intervals.set_index("id").loc["6.energy"]
    assert (row["lower"], row["upper"]) == pytest.approx(student(errors)) and row["interval_from"] == "trainings"
    # From a file, the ends are texts.
    write_table(intervals, tmp_path / "intervals.tsv")
    as_text = pd.read_csv(tmp_path / "intervals.tsv", sep="\t", dtype=str)
    table = tabulate_claims(CLAIMS_TSV, collect_findings(tmp_path, CLAIMS_TSV, intervals=as_text)).set_index("id")
    assert table["verdict"]["6.energy"] == expected
    assert (
        table["interval_from"]["6.energy"] == "trainings" and float(table["upper"]["6.energy"]) >= max(errors) * 0.999
    )
    assert table["interval_from"]["2.full_factorial"] == ""


def test_an_interval_ends_where_the_quantity_does(tmp_path):
    def correlations(lowest: float) -> pd.DataFrame:
        tests = (("motion1", 0.999), ("motion2", lowest))
        rows = [{"variant": "thesis", "test": test, "measure": "cumulative_pearson_r", "value": r} for test, r in tests]
        rows += [{**row, "measure": "increments_5ms_r"} for row in rows]
        return pd.DataFrame(rows).assign(dem_reference=0.9998)

    path = "surrogate/thesis/metrics.tsv"
    write_table(correlations(0.999), tmp_path / path)
    # A roll-out that is not finite counts as no correlation: Student's interval of these three is wider than -1 to 1.
    drawn = [{path: correlations(r)} for r in (0.999, 0.998, float("nan"))]
    assert student([0.999, 0.998, 0.0])[1] > 1
    intervals = tabulate_intervals(tmp_path, CLAIMS_TSV, [Repeated("trainings", drawn, over_repeats)])
    row = intervals.set_index("id").loc["6.pearson"]
    assert (row["lower"], row["upper"]) == pytest.approx((student([0.999, 0.998, 0.0])[0], 1.0))
    assert Interval("no", "yes", "trainings").within((-1, 1)) == Interval("no", "yes", "trainings")


def test_the_spread_stands_beside_the_first_training():
    metrics = pd.concat([measures(error).assign(variant=name) for name, error in (("thesis", 2.5), ("again", 23.1))])
    trainings = {"thesis": ["thesis", "again"]}
    table = with_spread(metrics, trainings).set_index("measure")
    assert table["value"]["dissipation_error_percent"] == 2.5 and set(table["variant"]) == {"thesis"}
    assert table.loc["dissipation_error_percent", ["trainings", "lowest", "highest"]].tolist() == [2, 2.5, 23.1]
    long = tabulate_trainings(metrics, trainings)
    assert long["training"].tolist() == [1] * 6 + [2] * 6 and set(long["variant"]) == {"thesis"}


def test_a_claim_on_the_curves_is_drawn_from_its_own_simulations(tmp_path):
    runs = synthetic_mill.summaries(contacts=("calibrated", "steel"), fills=(0.06, 0.10, 0.17))
    settings = {"mill": "emax", "contacts": ["calibrated", "steel"], "counting_rule": "gap_0_02", "further_rules": []}
    tables = draw_tables(runs, [], 12, 7, **settings)
    assert len(tables) == 12 and not tables[0]["fingerprint/descriptors.tsv"].equals(
        tables[1]["fingerprint/descriptors.tsv"]
    )
    for path, table in redrawn_tables(runs, [], np.random.default_rng(0), **settings).items():
        write_table(table, tmp_path / path)
    for contact in settings["contacts"]:
        write_json({"about": {"mill": "emax"}}, tmp_path / f"fingerprint/fingerprint_{contact}.json")
    table = tabulate_intervals(tmp_path, CLAIMS_TSV, [Repeated(WINDOWS, tables, over_draws)]).set_index("id")
    assert {"3.curve.0.06.Pn", "3.curve.0.10.f", "3.collapse", "3.reference.En", "3.frequency.calibrated"} <= set(
        table.index
    )
    assert (table["interval_from"] == WINDOWS).all() and (table["repeats"] == 12).all()
    spread = table.loc["3.curve.0.10.Pn"]
    # Revolutions ripple by 10 %, so their mean over two speeds and two sizes by a few per cent at most.
    assert 0 < spread["upper"] / spread["lower"] - 1 < 0.1


def test_a_condition_is_asked_again_where_its_columns_have_changed(tmp_path):
    rows = pd.DataFrame({"fill": [0.1, 0.2, 0.3], "power": [1.0, 2.0, 3.0]})
    evidence = Evidence(tmp_path, tmp_path, pd.Series(dtype=str), tables={"a.tsv": rows})

    def chosen(table: pd.DataFrame) -> list[float]:
        own = replace(evidence, tables={"a.tsv": table})
        return own.table("a.tsv", "fill >= 0.2 and power == power")["power"].tolist()

    drawn = rows.assign(power=[4.0, np.nan, 6.0])
    assert chosen(rows) == [2, 3] and chosen(drawn) == [6] and chosen(rows[::-1]) == [3, 2] and chosen(rows) == [2, 3]


def judged(**verdicts) -> pd.DataFrame:
    kinds = {"runtime": "runtime", "point": "computed"}
    rows = [
        {"id": name, "kind": kinds.get(name, "trained"), "verdict": said, "reproduced": "2", "lower": "1", "upper": "3"}
        for name, said in verdicts.items()
    ]
    return pd.DataFrame(rows)


MACHINE = {"processor": "znver4", "instructions": "AVX-512", "date": "2026-11-20"}


def test_a_run_says_which_verdicts_are_others_on_another_machine(tmp_path):
    there = judged(a=REPRODUCED, b=REPRODUCED, c=DEVIATES, runtime=REPRODUCED, point=REPRODUCED, missing="not run")
    nothing = read_stored(ROOT / "config/data/verdicts_elsewhere.tsv").iloc[:0]
    stored = with_run(nothing, there, "thesis", MACHINE)
    # What is computed from data is the same everywhere.
    assert stored["id"].tolist() == ["a", "b", "c", "runtime"]
    write_table(stored, tmp_path / "stored.tsv")
    stored = read_stored(tmp_path / "stored.tsv")
    here = judged(a=UNDECIDED, b=DEVIATES, c=DEVIATES, runtime=DEVIATES, point=REPRODUCED)
    table = compare_verdicts(here, stored, "thesis").set_index("id")
    assert table["reason"].to_dict() == {"a": EXPECTED, "b": UNEXPECTED, "runtime": TIMED}
    assert table.loc["a", ["verdict", "verdict_elsewhere", "processor"]].tolist() == [
        "undecided",
        "reproduced",
        "znver4",
    ]
    said = in_a_line(table.reset_index(), stored, "thesis")
    assert said.startswith(
        "verdicts of other machines (4 of znver4, AVX-512, 2026-11-20): 3 differ here, 1 of them not"
    )
    assert "a (undecided here, reproduced there: undecided on one of them)" in said
    assert in_a_line(compare_verdicts(there, stored, "thesis"), stored, "thesis").endswith("none differs here")
    assert in_a_line(table, stored, "smoke") == "verdicts of other machines: none is stored of the run smoke"
    # The same machine again takes the place of its earlier verdicts; another one stands beside it.
    assert with_run(stored, here, "thesis", MACHINE).set_index("id")["verdict"]["a"] == "undecided"
    assert len(with_run(stored, here, "thesis", MACHINE | {"processor": "other"})) == 8


def test_stored_verdicts_are_refused_with_another_word(tmp_path):
    write_table(
        with_run(
            read_stored(ROOT / "config/data/verdicts_elsewhere.tsv").iloc[:0], judged(a=REPRODUCED), "thesis", MACHINE
        ).assign(verdict="perhaps"),
        tmp_path / "stored.tsv",
    )
    with pytest.raises(ConfigError, match="column verdict"):
        read_stored(tmp_path / "stored.tsv")


def test_this_machine_and_a_run_of_it_are_stored(tmp_path):
    write_table(judged(a=REPRODUCED), tmp_path / "report/claims.tsv")
    (tmp_path / "report/run.yaml").write_text("# Python\nname: thesis\n")
    table = tmp_path / "verdicts.tsv"
    table.write_text((ROOT / "config/data/verdicts_elsewhere.tsv").read_text().splitlines()[0] + "\n")
    assert "1 verdicts of the run thesis" in main(str(tmp_path), str(table), "2026-11-22")
    assert main(str(tmp_path), str(table), "2026-11-23").endswith("2026-11-23")
    row = read_stored(table).iloc[0]
    assert len(read_stored(table)) == 1 and row["date"] == "2026-11-23" and row["processor"] and row["instructions"]


def test_a_training_that_lost_its_balls_opens_the_interval():
    """Whatever number its error is; one that lost a ball and did not run away keeps its number."""

    def training(error: float, left: float, ratio: float) -> pd.DataFrame:
        measures = {"dissipation_error_percent": error, "balls_left": left, "mean_square_speed_ratio": ratio}
        return pd.DataFrame([{"test": "motion1", "measure": name, "value": value} for name, value in measures.items()])

    found = [training(16.1, 0, 1.1), training(11.9, 1, 1.2), training(3e20, 24, 1e20), training(np.nan, 24, np.nan)]
    assert [failed_tests(table) for table in found] == [set(), set(), {"motion1"}, {"motion1"}]
    errors = [with_failures(table)["value"].iloc[0] for table in found]
    assert errors == [16.1, 11.9, np.inf, np.inf]
    interval = over_repeats(16.1, errors, 0.95)
    assert (interval.lower, interval.upper) == (11.9, np.inf)
