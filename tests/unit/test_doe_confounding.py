"""What other effects can claim, lack of fit, and the checks of the residuals."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import chi2
from scipy.stats import f as f_distribution

from millprint.config.doe import DoeConfig
from millprint.thesis.doe.factorial_designs import design_table
from millprint.thesis.doe.residuals import (
    contested_table,
    lack_of_fit_table,
    pure_error,
    residual_checks,
    residual_parts_table,
)
from millprint.thesis.doe.variance import fit_factors
from tests.unit.doe_settings import settings, thesis_config, thesis_runs  # noqa: F401 (fixtures)


def planted(config: DoeConfig, signal: np.ndarray, scatter: float = 1.0, seed: int = 6) -> pd.DataFrame:
    """The design's own runs with a yield of 50 %, a signal and normal errors."""
    table = design_table(config)
    noise = scatter * np.random.default_rng(seed).normal(size=len(table))
    return table.assign(yield_percent=50 + signal + noise)


def component(config: DoeConfig, a: int, b: int) -> np.ndarray:
    """A yield that depends only on (a A + b B) mod 3."""
    codes = design_table(config)
    return np.array([-8.0, 1.0, 7.0])[(a * codes["A"] + b * codes["B"]) % 3]


def test_an_interaction_in_the_aliased_component_is_all_claimable_and_in_the_clear_one_not(config):
    # AB = CD2 in the fraction, AB2 has no alias among the two-factor interactions.
    for powers, claimable in (((1, 1), 1.0), ((1, 2), 0.0)):
        table = contested_table(config, planted(config, component(config, *powers), scatter=1e-3))
        row = table[(table["term"] == "A:B") & (table["rival"] == "C:D")].iloc[0]
        assert row["fraction_claimable"] == pytest.approx(claimable, abs=1e-3)
        assert (row["degrees_of_freedom"], row["degrees_of_freedom_if_rival_first"]) == (4, 2)


def test_in_the_orthogonal_design_only_the_aliased_pairs_are_contested(config):
    table = contested_table(config, planted(config, component(config, 1, 1)))
    assert list(zip(table["term"], table["rival"], strict=True)) == [("A:B", "C:D"), ("A:C", "B:D"), ("B:C", "A:D")]


def test_a_contested_sum_is_a_difference_of_residuals_of_fitted_models(config, runs):
    def rest(*model: str) -> float:
        return fit_factors(settings(model=list(model)), runs).ssr

    row = contested_table(config, runs).set_index(["term", "rival"]).loc[("C", "A:D")]
    base = ["A", "B", "D", "A:B"]
    assert row["sum_of_squares"] == pytest.approx(rest(*base) - rest(*base, "C"))
    assert row["sum_if_rival_first"] == pytest.approx(rest(*base, "A:D") - rest(*base, "A:D", "C"))


def test_the_residual_is_the_interactions_of_speed_and_nothing_else(config, runs):
    table = residual_parts_table(config, runs).set_index("effect")
    assert table.index.tolist() == ["A:D", "B:D", "C:D", "together"]
    assert table.loc["together", "share"] == pytest.approx(1)
    designed = table["share_as_designed"]
    assert designed["together"] == pytest.approx(1) and designed.drop("together").sum() == pytest.approx(1)
    assert round(designed["C:D"], 2) == 0.72
    # Two degrees of freedom each, six in all; the run at another speed gives each a third.
    assert table["degrees_of_freedom_as_designed"].tolist() == [2, 2, 2, 6]
    assert table["degrees_of_freedom"].tolist() == [3, 3, 3, 6]
    assert table.loc["together", "sum_of_squares"] == pytest.approx(fit_factors(config, runs).ssr)


def test_a_planted_interaction_of_speed_is_the_residual(config):
    codes = design_table(config)
    signal = np.array([-8.0, 1.0, 7.0])[(codes["C"] + codes["D"]) % 3]
    table = residual_parts_table(config, planted(config, signal, scatter=0.01)).set_index("effect")
    assert table.loc["C:D", "share"] > 0.999 > 0.001 > table.loc["A:D", "share"]


def test_without_repeated_runs_there_is_no_pure_error_and_the_residual_is_held_to_the_repeatability(config, runs):
    fit = fit_factors(config, runs)
    table = lack_of_fit_table(config, runs, fit)
    assert "no treatment was run twice" in table["note"][0]
    residual = table[(table["against"] == "repeatability") & (table["term"] == "Residual")].iloc[0]
    assert residual["statistic"] == pytest.approx(fit.ssr / 0.025**2)
    assert residual["p_value"] == pytest.approx(chi2.sf(fit.ssr / 0.025**2, 6))
    # Five times what a repeated run would scatter, as a variance twelve times.
    assert residual["statistic"] / 6 > 12
    silent = lack_of_fit_table(settings(repeatability_percent=None), runs, fit)
    assert silent["against"].tolist() == ["repeated treatments"]


def test_lack_of_fit_from_replicates_has_its_closed_form():
    config = settings(replicates=2, model=["A", "B", "C", "D"])
    runs = planted(config, np.tile(component(settings(), 1, 2), 2), scatter=1)
    fit = fit_factors(config, runs)
    first = lack_of_fit_table(config, runs, fit).iloc[0]
    pairs = runs["yield_percent"].to_numpy().reshape(2, 27) / 100
    pure = ((pairs[0] - pairs[1]) ** 2 / 2).sum()
    assert pure_error(config, runs) == (pytest.approx(pure), 27)
    left = int(fit.df_resid) - 27
    statistic = (fit.ssr - pure) / left / (pure / 27)
    assert first["statistic"] == pytest.approx(statistic)
    assert first["p_value"] == pytest.approx(f_distribution.sf(statistic, left, 27))
    # The planted interaction is not in the model.
    assert first["p_value"] < 1e-6


def test_without_the_run_order_its_check_is_marked(config, runs):
    table = residual_checks(config, runs, fit_factors(config, runs), 100, 1).set_index("check")
    assert "run_order" in table.loc["durbin_watson", "note"]
    assert np.isnan(table.loc["durbin_watson", "p_simulated"])
    assert "trend_over_run_order" not in table.index


# What is wrong with the errors, by name: normal errors of the design's 27 runs and its codes to other errors.
SPOILED = {
    "nothing": lambda errors, codes: errors,
    "an outlier": lambda errors, codes: errors + 15 * (np.arange(27) == 13),
    "a drift": lambda errors, codes: errors + 0.4 * codes["run_order"].to_numpy(),
    "a spread by C": lambda errors, codes: errors * np.array([0.02, 1.0, 50.0])[codes["C"]],
    "a curve": lambda errors, codes: 0.1 * errors + 2 * np.exp(0.4 * codes[list("ABCD")].sum(axis=1)),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spoiled", "seen_by"),
    [
        ("nothing", []),
        ("an outlier", ["shapiro_wilk", "anderson_darling", "largest_studentised"]),
        ("a drift", ["trend_over_run_order", "durbin_watson"]),
        ("a spread by C", ["spread_over_C"]),
        ("a curve", ["tukey_nonadditivity"]),
    ],
)
def test_each_check_of_the_residuals_sees_what_it_is_for(config, spoiled, seen_by):
    small, codes = settings(model=["A", "B", "C", "D"]), design_table(config)
    errors = SPOILED[spoiled](np.random.default_rng(5).normal(size=27), codes)
    runs = codes.assign(yield_percent=50 + codes["A"] + errors)
    found = (
        residual_checks(small, runs, fit_factors(small, runs), 400, seed=1).set_index("check")["p_simulated"].dropna()
    )
    assert (found[seen_by] < 0.01).all()
    if not seen_by:
        assert (found > 0.05).all()


@pytest.mark.slow
def test_p_values_of_the_checks_are_uniform_under_normal_errors(config):
    small = settings(model=["A", "B", "C", "D"])
    found = []
    for seed in range(20):
        runs = planted(config, np.zeros(27), seed=100 + seed)
        table = residual_checks(small, runs, fit_factors(small, runs), 60, seed)
        found.append(table.set_index("check")["p_simulated"].dropna())
    # The mean of 20 uniform numbers has a standard deviation of 0.065; four of them.
    assert pd.DataFrame(found).mean().between(0.5 - 0.26, 0.5 + 0.26).all()
