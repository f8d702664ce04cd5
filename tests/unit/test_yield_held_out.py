"""Outer folds, intervals from cross-validation, and tables of held-out predictions."""

import numpy as np
import pandas as pd
import pytest

from millprint.thesis.yields.distributions import cross_intervals, cross_validated_intervals
from millprint.thesis.yields.evaluation import coverage_table, score_table
from millprint.thesis.yields.held_out import outer_folds, predict_held_out, procedure_of
from millprint.thesis.yields.metrics import LEFT_OUT, LOCKED_AGAIN, NESTED, RANDOM, SPREAD, YieldWeights
from tests.unit.yield_settings import parts, settings

WEIGH = YieldWeights(70, 2.0)


def runs() -> pd.DataFrame:
    train, test = parts()
    return pd.concat([train.assign(role="train"), test.assign(role="test")], ignore_index=True)


def procedure(model: str, strategy: str):
    config = settings()
    return procedure_of(model, strategy, config.training, config.evaluation, config.averaging)


def test_outer_folds_hold_out_the_rows_of_their_scheme():
    rows, budget = runs(), settings().evaluation
    folds = outer_folds(rows, budget)
    for fold in folds:
        assert sorted([*fold.kept, *fold.held]) == list(range(27))
    by_scheme = {
        scheme: [fold for fold in folds if fold.scheme == scheme] for scheme in {fold.scheme for fold in folds}
    }
    assert [fold.held.tolist() for fold in by_scheme[LEFT_OUT]] == [[index] for index in range(27)]
    assert rows["case"].iloc[by_scheme[LOCKED_AGAIN][0].held].tolist() == ["9", "14", "10", "22", "1", "12"]
    for repeat in range(budget.outer_repeats):
        parts = [fold for fold in by_scheme[NESTED] if fold.repeat == repeat]
        assert sorted(np.concatenate([fold.held for fold in parts])) == list(range(27))
        assert [fold.number for fold in parts] == list(range(budget.outer_folds))
    assert all(len(fold.held) == 6 for fold in by_scheme[RANDOM])
    yields = rows["yield_percent"].to_numpy()
    assert all(np.array_equal(fold.yields, yields) for fold in folds)


@pytest.mark.parametrize(("model", "strategy"), [("averaged_gpr", "primary"), ("gpr", "two_step"), ("xgb", "primary")])
@pytest.mark.slow
def test_a_held_out_prediction_does_not_depend_on_the_yield_of_its_run(model, strategy):
    rows, budget = runs().head(9).assign(role=["train"] * 7 + ["test"] * 2), settings().evaluation
    wrong = rows.copy()
    wrong.loc[3, "yield_percent"] = 99.0
    tables = []
    for table in (rows, wrong):
        folds = [fold for fold in outer_folds(table, budget) if fold.scheme == LEFT_OUT][2:4]
        tables.append(predict_held_out(procedure(model, strategy), table, folds, [0.8]))
    (clean, ends), (other, other_ends) = tables
    assert clean["predicted_percent"][1] == other["predicted_percent"][1]
    assert clean["predicted_percent"][0] != other["predicted_percent"][0]
    own = ends["case"] == rows["case"][3]
    bounds = ["lower_percent", "upper_percent"]
    assert own.any() and ends.loc[own, bounds].equals(other_ends.loc[own, bounds])


def test_cross_intervals_are_the_order_statistics_of_the_paper():
    residuals = np.array([1.0, 2.0, 3.0, 4.0])
    centres = np.full((4, 1), 50.0)
    # a (n + 1) = 0.4 * 5 = 2 and 0.6 * 5 = 3: the second smallest lower, the third smallest upper candidate.
    assert cross_intervals(centres, residuals, [0.6])[0, 0].tolist() == [47.0, 53.0]
    # Four rows are too few for 95 %: the interval is all possible yields.
    assert cross_intervals(centres, residuals, [0.95])[0, 0].tolist() == [0.0, 100.0]


@pytest.mark.slow
def test_cross_intervals_have_their_nominal_coverage():
    generator, hits, trials = np.random.default_rng(5), 0, 300
    for _ in range(trials):
        rows = pd.DataFrame({"x": generator.uniform(0, 1, 24)})
        truth = 30 + 40 * rows["x"].to_numpy() + generator.normal(0, 5, 24)

        def fit(kept, yields):
            line = np.polyfit(kept["x"], yields, 1)
            return lambda unseen: np.polyval(line, unseen["x"])

        ends = cross_validated_intervals(fit, rows.iloc[:23], truth[:23], rows.iloc[23:], [0.8], 5, 0)[0, 0]
        hits += ends[0] <= truth[23] <= ends[1]
    assert 0.75 <= hits / trials <= 0.92


def held_out(scheme: str, repeats: int, error: float, model: str = "m") -> pd.DataFrame:
    truth = np.array([20.0, 40.0, 60.0, 80.0])
    tables = [
        pd.DataFrame(
            {
                "repeat": repeat,
                "case": list("abcd"),
                "yield_percent": truth,
                "predicted_percent": truth + error * (1 + repeat) * np.array([1, -1, 1, -1]),
            }
        )
        for repeat in range(repeats)
    ]
    return pd.concat(tables).assign(model=model, strategy="primary", scheme=scheme)


def test_nested_metrics_are_averaged_over_repeats_and_random_ones_are_a_population():
    budget = settings().evaluation
    table = pd.concat([held_out(NESTED, 3, 2.0), held_out(RANDOM, 3, 2.0)])
    found = score_table(table, WEIGH, budget).set_index(["scheme", "metric"])
    assert found.loc[(NESTED, "mae"), "value"] == pytest.approx((2 + 4 + 6) / 3)
    # Every case has the same error, so resampling cases changes nothing.
    assert found.loc[(NESTED, "mae"), "lower"] == pytest.approx(4) == found.loc[(NESTED, "mae"), "upper"]
    for scheme in (NESTED, RANDOM):
        assert found.loc[(scheme, "mae"), [*SPREAD]].tolist() == pytest.approx([3, 2, 4, 6])
    assert found.loc[(RANDOM, "mae"), "value"] == pytest.approx(4)
    assert found.loc[(RANDOM, "mae"), "lower"] < 2.2 and found.loc[(RANDOM, "mae"), "upper"] > 5.8


def test_coverage_counts_cases_and_not_repeats():
    table = held_out(NESTED, 5, 1.0).assign(method="cv_plus", nominal=0.8)
    table["lower_percent"], table["upper_percent"] = table["yield_percent"] - 1, table["yield_percent"] + 1
    table.loc[table["case"] == "a", "upper_percent"] = 10.0
    row = coverage_table(table, 0.95).iloc[0]
    assert row["covered"] == 0.75 and row["cases"] == 4
    assert row[[*SPREAD]].tolist() == [5, 0.75, 0.75, 0.75]
    assert row["lower"] == pytest.approx(0.194, abs=1e-3) and row["upper"] == pytest.approx(0.994, abs=1e-3)
