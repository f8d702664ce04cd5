"""The analysis of variance: Table 2.5 to its digits, and the corrected table."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2, ncf
from scipy.stats import f as f_distribution

from millprint.config.errors import ConfigError
from millprint.thesis.doe.factorial_designs import as_designed, design_table
from millprint.thesis.doe.residuals import residual_table
from millprint.thesis.doe.runs import contrasts
from millprint.thesis.doe.variance import (
    corrected_table,
    detectable_table,
    effect_sizes,
    fit_factors,
    interaction_table,
    noncentrality,
    pareto_table,
    printed_table,
    sums_of_squares,
    truncated,
)
from tests.unit.doe_settings import settings, thesis_config, thesis_runs  # noqa: F401 (fixtures)

# Thesis Table 2.5.
PRINTED = {
    "A": ("0.153", "0.013"),
    "AL": ("0.151", ""),
    "AQ": ("0.002", ""),
    "B": ("0.191", "0.007"),
    "BL": ("0.062", ""),
    "BQ": ("0.129", ""),
    "C": ("0.434", "0.0009"),
    "CL": ("0.417", ""),
    "CQ": ("0.017", ""),
    "D": ("0.023", "0.293"),
    "DQ": ("0.020", ""),
    "AB, CD": ("0.270", "0.011"),
    "AC, BD": ("0.050", "0.286"),
    "AD, BC": ("0.009", "0.874"),
}


@pytest.fixture(scope="module")
def printed(config, runs) -> pd.DataFrame:
    return printed_table(config, runs).set_index("source")


@pytest.fixture(scope="module")
def corrected(config, runs) -> pd.DataFrame:
    return corrected_table(config, runs).set_index(["sums", "term"])


@pytest.mark.parametrize("source", PRINTED)
def test_table_2_5_follows_digit_for_digit(printed, source):
    row = printed.loc[source]
    assert (row["sum_of_squares_truncated"], row["p_value_truncated"]) == PRINTED[source]


def test_the_interactions_have_four_degrees_of_freedom_and_the_residual_six(printed):
    freedom = printed["degrees_of_freedom"]
    assert freedom[["AB, CD", "AC, BD", "AD, BC", "Residual"]].tolist() == [4, 4, 4, 6]
    assert freedom[["A", "B", "C", "D"]].tolist() == [2, 2, 2, 2]
    # What Table 2.5 prints: the interactions of a source together.
    assert printed["degrees_of_freedom_of_source"][["A", "AB, CD", "AC, BD", "AD, BC"]].tolist() == [2, 6, 6, 6]


def test_type_one_sums_add_up_to_the_total(runs, printed):
    terms = [*"ABCD", "AB, CD", "AC, BD", "AD, BC", "Residual"]
    total = ((runs["yield_percent"] / 100 - runs["yield_percent"].mean() / 100) ** 2).sum()
    assert printed.loc[terms, "sum_of_squares"].sum() == pytest.approx(total, rel=1e-12)


def test_a_balanced_design_gives_the_same_sums_whatever_their_type(config, runs):
    fit = fit_factors(config, as_designed(config, runs))
    first, second, third = (sums_of_squares(config, fit, kind)["sum_of_squares"] for kind in (1, 2, 3))
    np.testing.assert_allclose(second, first, rtol=1e-9)
    np.testing.assert_allclose(third, first, rtol=1e-9)


def test_a_type_two_sum_is_the_drop_in_the_residual_when_the_term_is_left_out(config, runs, corrected):
    smaller = settings(model=[term for term in config.model if term != "D"])
    drop = fit_factors(smaller, runs).ssr - fit_factors(config, runs).ssr
    assert corrected["sum_of_squares"]["II", "D"] == pytest.approx(drop, rel=1e-9)


def test_effect_sizes_have_their_closed_forms():
    terms = pd.DataFrame({"degrees_of_freedom": [2], "sum_of_squares": [6.0], "F": [9.0]}, index=["A"])
    residual = pd.Series({"degrees_of_freedom": 6, "sum_of_squares": 2.0})
    row = effect_sizes(terms, residual, 27, 10.0, 0.95).loc["A"]
    assert row["partial_eta_squared"] == pytest.approx(6 / 8)
    assert row["partial_omega_squared"] == pytest.approx(16 / 43)
    # (SS - df MS) / (SS_total + MS) with MS = 1 / 3.
    assert row["omega_squared"] == pytest.approx((6 - 2 / 3) / (10 + 1 / 3))
    share = row["partial_eta_squared_lower"]
    assert ncf.sf(9.0, 2, 6, 6 * share / (1 - share)) == pytest.approx(0.025, abs=1e-6)
    share = row["partial_omega_squared_upper"]
    assert ncf.cdf(9.0, 2, 6, 27 * share / (1 - share)) == pytest.approx(0.025, abs=1e-6)


def test_noncentrality_puts_f_at_the_tail():
    value = noncentrality(8.5, 4, 6, 0.025)
    assert ncf.cdf(8.5, 4, 6, value) == pytest.approx(0.025, abs=1e-8)
    assert noncentrality(0.3, 4, 6, 0.975) == 0.0


@pytest.mark.slow
def test_effect_intervals_cover_the_true_share_as_often_as_they_say():
    share, freedom, residual, total, confidence = 0.4, 2, 6, 27, 0.8
    true = share / (1 - share) * total
    sample = ncf.rvs(freedom, residual, true, size=300, random_state=np.random.default_rng(1))
    limits = [[noncentrality(value, freedom, residual, tail) for tail in (0.9, 0.1)] for value in sample]
    covered = np.mean([low <= true <= high for low, high in limits])
    # Four standard errors of a share of 0.8 over 300 samples.
    assert abs(covered - confidence) < 0.095


def test_after_holm_only_time_and_molar_ratio_stand(corrected):
    for kind in ("I", "II", "III"):
        own = corrected.loc[kind].drop("Residual")
        assert own.index[own["stands_after_holm"] == "yes"].tolist() == ["B", "C"]
        # Holm: the k-th smallest of n p-values times n + 1 - k, never falling.
        ranked = own["p_value"].sort_values()
        by_hand = (ranked * np.arange(len(ranked), 0, -1)).cummax().clip(upper=1)
        np.testing.assert_allclose(own["p_holm"], by_hand[own.index])


def test_the_ends_of_the_smallest_effect_are_those_of_the_chi_squared_interval_of_sigma(config, runs):
    table = detectable_table(config, runs).set_index(["factor", "shape"])
    for end, tail in (("lower_percent", 0.975), ("upper_percent", 0.025)):
        # (n - 1) s^2 / sigma^2 is chi-squared, and the smallest range is proportional to sigma.
        np.testing.assert_allclose(table[end] / table["smallest_range_percent"], np.sqrt(6 / chi2.ppf(tail, 6)))
    halves, steps = (table.xs(shape, level="shape")["smallest_range_percent"] for shape in ("halves", "steps"))
    assert (halves < steps).all()


def test_an_effect_of_the_smallest_size_is_found_as_often_as_the_power_says(config):
    """A simulation of the screening as designed, with an effect of speed of the tabulated size."""
    design = design_table(config)
    generator = np.random.default_rng(3)
    first = design.assign(yield_percent=50 + generator.normal(size=27))
    size = detectable_table(config, first).set_index(["factor", "shape"]).loc[("D", "steps")]
    ratio = size["smallest_range_percent"] / size["residual_percent"]
    effect = ratio * np.array([-0.5, 0.0, 0.5])[design["D"]]
    small = np.column_stack([np.ones(27), *(design["D"] == level for level in (1, 2))])
    model = fit_factors(config, first).model.exog
    hat, alone = model @ np.linalg.pinv(model), small @ np.linalg.pinv(small)
    drawn = effect + generator.normal(size=(4000, 27))
    rest = ((drawn - drawn @ hat) ** 2).sum(axis=1) / 6
    centred = drawn @ alone - drawn.mean(axis=1, keepdims=True)
    found = (centred**2).sum(axis=1) / 2 / rest > f_distribution.isf(0.05, 2, 6)
    # Three binomial standard deviations.
    assert found.mean() == pytest.approx(0.8, abs=0.02)


def test_three_level_contrasts_are_those_of_the_thesis():
    linear, quadratic = contrasts([10, 30, 50]).T
    np.testing.assert_allclose(linear / linear[2], [-1, 0, 1], atol=1e-12)
    np.testing.assert_allclose(quadratic / quadratic[2], [1, -2, 1], atol=1e-12)
    np.testing.assert_allclose(contrasts([1, 2, 5, 9, 40]).T @ contrasts([1, 2, 5, 9, 40]), np.eye(4), atol=1e-12)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.153266, "0.153"), (0.2939, "0.293"), (0.000948, "0.0009"), (0.27, "0.270"), (0.0, "0.000"), (float("nan"), "")],
)
def test_truncation_cuts_and_does_not_round(value, text):
    assert truncated(value) == text


def test_the_pareto_plot_ranks_by_f_and_milling_time_comes_first(printed, corrected):
    table = pareto_table(printed.reset_index(), corrected.reset_index(), {"C": 0.000947559, "D": 0.5})
    assert table.set_index("term").loc["D", "F_type_two"] == pytest.approx(corrected.loc[("II", "D"), "F"])
    assert table["source"].tolist() == ["C", "B", "A", "AB, CD", "AC, BD", "D", "AD, BC"]
    assert table["F_published"][0] == pytest.approx(table["F"][0], rel=1e-4)
    significant = table["source"][table["F"] > table["critical_F"]]
    assert significant.tolist() == ["C", "B", "A", "AB, CD"]


def test_interaction_means_are_means_of_the_runs(config, runs):
    table = interaction_table(config, runs)
    speed = table[table["figure"] == "speed"]
    # Case 4, run at 600 rpm, is missed at 800 rpm.
    short = speed[speed["curve_level"] == 5].set_index("axis_level")
    assert short["runs"].tolist() == [4, 2, 3]
    assert short.loc[600, "mean_yield_percent"] == pytest.approx((12 + 28 + 21 + 31) / 4)
    weighted = (table["runs"] * table["mean_yield_percent"]).groupby(table["axis"] + table["curve"]).sum()
    assert weighted.to_numpy() == pytest.approx([runs["yield_percent"].sum()] * 3)


def test_residuals_are_orthogonal_to_the_model_and_leverages_count_its_parameters(config, runs):
    fit = fit_factors(config, runs)
    table = residual_table(runs, fit)
    assert table["leverage"].sum() == pytest.approx(21)
    np.testing.assert_allclose(fit.model.exog.T @ table["residual_percent"], 0, atol=1e-9)
    np.testing.assert_allclose(table["fitted_percent"] + table["residual_percent"], runs["yield_percent"])


@pytest.mark.parametrize(
    ("model", "change", "part"),
    [
        (["A", "B", "C", "D", "A:B", "C:D"], {}, "aliased"),
        (["A", "B", "C", "A:B", "A:C", "B:C", "A:B:C"], {}, "leave nothing"),
        (["A"], {"yield_percent": 50.0}, "no scatter"),
        (["A"], {"D": 0}, None),
        (["D"], {"D": 0}, "level 800 of D"),
    ],
)
def test_what_the_runs_cannot_tell_is_refused(config, model, change, part):
    runs = design_table(config).assign(yield_percent=np.linspace(10, 90, 27) ** 1.1).assign(**change)
    if part is None:
        fit_factors(settings(model=model), runs)
        return
    with pytest.raises(ConfigError, match=part):
        fit_factors(settings(model=model), runs)
