"""The analysis of variance: Table 2.5 to its digits, the corrected table, confounded effects, and the residuals."""

import numpy as np
import pandas as pd
import pytest
from scipy.stats import f as f_distribution
from scipy.stats import ncf, norm

from millprint.config.doe import DoeConfig
from millprint.config.errors import ConfigError
from millprint.thesis.doe.factorial_designs import as_designed, design_table
from millprint.thesis.doe.residuals import (
    contested_table,
    lack_of_fit_table,
    pure_error,
    residual_table,
)
from millprint.thesis.doe.variance import (
    corrected_table,
    detectable_table,
    effect_sizes,
    fit_factors,
    noncentrality,
    sums_of_squares,
)
from tests.refusals import refusals
from tests.unit.doe_settings import settings, thesis_config, thesis_runs  # noqa: F401 (fixtures)


@pytest.fixture(scope="module")
def corrected(config, runs) -> pd.DataFrame:
    return corrected_table(config, runs).set_index(["sums", "term"])


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


@pytest.mark.parametrize(("model", "change", "part"), refusals("what_the_runs_cannot_tell_is_refused"))
def test_what_the_runs_cannot_tell_is_refused(config, model, change, part):
    runs = design_table(config).assign(yield_percent=np.linspace(10, 90, 27) ** 1.1).assign(**change)
    if part is None:
        fit_factors(settings(model=model), runs)
        return
    with pytest.raises(ConfigError, match=part):
        fit_factors(settings(model=model), runs)


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


def test_residuals_are_those_of_a_fit_without_the_run(runs):
    """A run that alone has a level fixes a parameter: the model goes through it, and says nothing of its error."""
    small = settings(model=["A", "B", "C", "D"])
    own = runs.assign(A=[2, *(place % 2 for place in range(len(runs) - 1))])
    fit = fit_factors(small, own)
    table, design, yields = residual_table(own, fit), fit.model.exog, own["yield_percent"].to_numpy()
    free, variance = len(yields) - design.shape[1], np.square(table["residual_percent"]).sum()
    assert table.loc[0, "leverage"] == pytest.approx(1)
    assert table.loc[0, ["studentised", "studentised_external", "cooks_distance"]].isna().all()
    for place in range(1, len(yields)):
        others, row = np.arange(len(yields)) != place, table.loc[place]
        without = np.linalg.lstsq(design[others], yields[others])[0]
        error = yields[place] - design[place] @ without
        rest = np.square(yields[others] - design[others] @ without).sum() / (free - 1)
        share = row["residual_percent"] / error
        assert row["leverage"] == pytest.approx(1 - share)
        assert row["studentised"] == pytest.approx(row["residual_percent"] / np.sqrt(variance / free * share))
        assert row["studentised_external"] == pytest.approx(error * np.sqrt(share / rest))
        moved = np.square(table["fitted_percent"] - design @ without).sum()
        assert row["cooks_distance"] == pytest.approx(moved / design.shape[1] / (variance / free))
    # Blom: the largest of 27 lies at (27 - 3/8) / (27 + 1/4) of the normal distribution.
    assert table["normal_quantile"].max() == pytest.approx(norm.ppf(26.625 / 27.25))
