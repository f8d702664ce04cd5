"""Least-squares fits of the yield on factors, interactions and contrasts, by statsmodels."""

import numpy as np
import pandas as pd
from statsmodels.formula.api import ols
from statsmodels.regression.linear_model import RegressionResultsWrapper
from statsmodels.stats.anova import anova_lm

from millprint.config.doe import AnalysisConfig
from millprint.config.errors import ConfigError
from millprint.thesis.doe.aliases import level_contrasts
from millprint.thesis.doe.runs import YIELD

# A smaller residual mean square, of yields as fractions, is rounding.
SMALLEST_VARIANCE = 1e-20


def _formula_term(term: str) -> str:
    # With a prefix, because a factor C would hide the function C(); sum-to-zero coding, without which type III sums
    # would depend on which level is the reference.
    return ":".join(f"C(factor_{symbol}, Sum)" for symbol in term.split(":"))


def _frame(runs: pd.DataFrame, symbols: list[str]) -> pd.DataFrame:
    columns = {f"factor_{symbol}": runs[symbol].to_numpy() for symbol in symbols}
    return pd.DataFrame({"response": runs[YIELD].to_numpy() / 100, **columns})


def fit_factors(config: AnalysisConfig, runs: pd.DataFrame) -> RegressionResultsWrapper:
    """Fit the yield, as a fraction, to the terms of `config.model`.

    Raises ConfigError if a level has no run, if the runs cannot tell the terms apart or leave no degree of freedom for
    the residual, and if the yields have no scatter.
    """
    for symbol in {symbol for term in config.model for symbol in term.split(":")}:
        if missing := set(range(len(config.factor(symbol).levels))) - set(runs[symbol]):
            level = config.factor(symbol).text(missing.pop())
            raise ConfigError(f"doe.factors: level {level} of {symbol} has no run: each level needs one")
    model = ols("response ~ " + " + ".join(map(_formula_term, config.model)), _frame(runs, config.symbols))
    columns = model.exog.shape[1]
    rank = np.linalg.matrix_rank(model.exog)
    if rank < columns:
        raise ConfigError(
            f"doe.model = {config.model}: its {columns} parameters are aliased in these runs, which tell {rank} apart: "
            "leave out interactions or take another fraction"
        )
    if len(runs) <= columns:
        raise ConfigError(
            f"doe.model = {config.model}: {columns} parameters for {len(runs)} runs leave nothing for the residual: "
            "leave out terms"
        )
    fit = model.fit()
    if fit.mse_resid < SMALLEST_VARIANCE:
        raise ConfigError(
            f"column {YIELD}: doe.model goes through every run and leaves no scatter to test against: "
            "it needs measured yields"
        )
    return fit


def sums_of_squares(config: AnalysisConfig, fit: RegressionResultsWrapper, kind: int) -> pd.DataFrame:
    """The ANOVA table of a fit, with sums of squares of type 1, 2 or 3: a row a term, then Residual.

    Columns degrees_of_freedom, sum_of_squares, mean_square, F, p_value.
    """
    table = anova_lm(fit, typ=kind).drop(index="Intercept", errors="ignore")
    terms = {_formula_term(term): term for term in config.model}
    table.index = [terms.get(name, name) for name in table.index]
    table = table.rename(columns={"df": "degrees_of_freedom", "sum_sq": "sum_of_squares", "PR(>F)": "p_value"})
    table["mean_square"] = table["sum_of_squares"] / table["degrees_of_freedom"]
    order = [*config.model, "Residual"]
    return table.loc[order, ["degrees_of_freedom", "sum_of_squares", "mean_square", "F", "p_value"]]


def contrast_sums(config: AnalysisConfig, runs: pd.DataFrame) -> dict[str, float]:
    """Type I sums of squares of the linear and quadratic contrasts, in a model of their own (thesis Sec. 2.3.1).

    Three equally spaced levels are coded -1, 0, 1 (L) and 1, -2, 1 (Q); the keys are AL, AQ, BL... in the order of the
    factors. A factor of names has neither.
    """
    frame = _frame(runs, [])
    for factor in config.factors:
        if not factor.numeric:
            continue
        columns = level_contrasts(factor)[runs[factor.symbol].to_numpy()]
        for letter, column in zip("LQ", columns.T, strict=False):
            frame[f"contrast_{factor.symbol}{letter}"] = column
    names = [name for name in frame if name.startswith("contrast_")]
    if not names:
        return {}
    fit = ols("response ~ " + " + ".join(names), frame).fit()
    table = anova_lm(fit, typ=1)
    return {name.removeprefix("contrast_"): float(table.loc[name, "sum_sq"]) for name in names}
