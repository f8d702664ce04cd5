"""Analysis of variance by statsmodels: as printed, corrected, with effect sizes, trends and confounded terms."""

from decimal import ROUND_DOWN, Decimal
from math import floor, isfinite, log10

import numpy as np
import pandas as pd
from scipy.optimize import brentq
from scipy.stats import ncf
from statsmodels.formula.api import ols
from statsmodels.regression.linear_model import RegressionResultsWrapper
from statsmodels.stats.anova import anova_lm
from statsmodels.stats.multitest import multipletests

from millprint.config.doe import AnalysisConfig
from millprint.config.errors import ConfigError
from millprint.estimate.quantiles import chi_squared_exceeded, f_exceeded
from millprint.thesis.doe.factorial_designs import (
    YIELD,
    as_designed,
    interaction_partners,
    level_codes,
    level_contrasts,
    term_columns,
)

# A smaller residual mean square, of yields as fractions, is rounding.
SMALLEST_VARIANCE = 1e-20
# Of the critical F of the ranking.
SIGNIFICANCE = 0.05


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


def truncated(value: float, decimals: int = 3) -> str:
    """A number truncated after `decimals`, or after its first digit that is not zero if that comes later.

    0.000948 is 0.0009 and 0.2939 is 0.293, as in thesis Table 2.5.
    """
    if not isfinite(value):
        return ""
    if 0 < abs(value) < 10.0**-decimals:
        decimals = -floor(log10(abs(value)))
    return str(Decimal(repr(float(value))).quantize(Decimal(1).scaleb(-decimals), rounding=ROUND_DOWN))


def source_name(config: AnalysisConfig, term: str) -> str:
    """A term with the two-factor interactions it is confounded with, such as `AB, CD` for A:B."""
    return ", ".join(interaction_partners(config, term)) if term.count(":") == 1 else term.replace(":", "")


def degrees_of_freedom_of_source(config: AnalysisConfig, term: str) -> int:
    """Degrees of freedom of all the interactions that a source names, together, in the design: 6 for `AB, CD`.

    What Table 2.5 prints for an interaction, although its sum of squares is only the term's, which has 4.
    """
    names = [":".join(pair) for pair in interaction_partners(config, term)] if term.count(":") == 1 else [term]
    codes = level_codes(config)
    columns = np.hstack([term_columns(config, codes, name) for name in names])
    return int(np.linalg.matrix_rank(columns - columns.mean(axis=0), tol=1e-9))


def printed_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Thesis Table 2.5: type I sums in the order of `config.model`, yield as a fraction, factors as they were run.

    Each main effect is followed by its linear and quadratic contrasts, which come from a model of their own and
    have no F. Columns ending in _truncated hold the digits as the thesis prints them; those ending in _as_designed
    what the levels of the generators would give; degrees_of_freedom_of_source is what the thesis prints in place of
    the term's own.
    """
    table = sums_of_squares(config, fit_factors(config, runs), 1)
    meant = as_designed(config, runs)
    table_meant = sums_of_squares(config, fit_factors(config, meant), 1)
    single, single_meant = contrast_sums(config, runs), contrast_sums(config, meant)
    rows = []
    for term, line in table.iterrows():
        other = table_meant.loc[term]
        of_source = np.nan if term == "Residual" else degrees_of_freedom_of_source(config, term)
        rows.append(
            {
                "source": source_name(config, term),
                "term": term,
                **line,
                "degrees_of_freedom_of_source": of_source,
                "sum_of_squares_as_designed": other["sum_of_squares"],
                "p_value_as_designed": other["p_value"],
            }
        )
        for name in (f"{term}L", f"{term}Q"):
            if name in single:
                sums = {"sum_of_squares": single[name], "sum_of_squares_as_designed": single_meant[name]}
                rows.append({"source": name, "term": name, "degrees_of_freedom": 1, **sums})
    frame = pd.DataFrame(rows)
    frame["sum_of_squares_truncated"] = frame["sum_of_squares"].map(truncated)
    frame["p_value_truncated"] = frame["p_value"].map(truncated)
    return frame


def corrected_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The analysis with type II and type III sums, which an unbalanced design needs, and with effect sizes.

    Type I is there for comparison. p_holm is the p-value corrected for the number of terms by Holm's method;
    stands_after_holm says whether it stays below 1 - `confidence`. The effect sizes and their intervals are those of
    `effect_sizes`.
    """
    fit = fit_factors(config, runs)
    tables = []
    for kind, name in ((2, "II"), (3, "III"), (1, "I")):
        table = sums_of_squares(config, fit, kind)
        terms = table.index != "Residual"
        stands, adjusted = multipletests(table.loc[terms, "p_value"], alpha=1 - config.confidence, method="holm")[:2]
        table.loc[terms, "p_holm"] = adjusted
        table.loc[terms, "stands_after_holm"] = np.where(stands, "yes", "no")
        sizes = effect_sizes(table[terms], table.loc["Residual"], len(runs), float(fit.centered_tss), config.confidence)
        table = table.join(sizes)
        table.insert(0, "term", table.index)
        table.insert(0, "source", [source_name(config, term) for term in table.index])
        table.insert(0, "sums", name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def pareto_table(anova: pd.DataFrame, corrected: pd.DataFrame, printed_p: dict[str, float]) -> pd.DataFrame:
    """Terms of an ANOVA table by falling F (thesis Fig. 2.3).

    `printed_p` maps sources to published p-values; F_published is the F that gives them with these degrees of freedom.
    F_type_two and stands_after_holm are those of type II in the corrected table.
    """
    residual = anova.loc[anova["term"] == "Residual", "degrees_of_freedom"].iloc[0]
    terms = anova[anova["F"].notna()]
    own = terms["degrees_of_freedom"]
    second = corrected[corrected["sums"] == "II"].set_index("term")
    table = terms[["source", "term", "degrees_of_freedom", "F", "p_value"]].assign(
        critical_F=f_exceeded(SIGNIFICANCE, own, residual),
        F_type_two=terms["term"].map(second["F"]),
        stands_after_holm=terms["term"].map(second["stands_after_holm"]),
        F_published=f_exceeded(terms["source"].map(printed_p).astype(float), own, residual),
    )
    return table.sort_values("F", ascending=False, ignore_index=True)


def noncentrality(statistic: float, degrees_of_freedom: float, residual: float, probability: float) -> float:
    """The noncentrality at which an F of at most `statistic` has `probability`; 0 if there is none.

    degrees_of_freedom, residual: those of the term and of the residual.
    """

    def excess(value: float) -> float:
        return float(ncf.cdf(statistic, degrees_of_freedom, residual, value)) - probability

    # scipy's noncentral distribution is not defined at exactly zero noncentrality in every release.
    low, high = 1e-9, 10.0
    if excess(low) <= 0:
        return 0.0
    while excess(high) > 0:
        high *= 2
    return float(brentq(excess, low, high, xtol=1e-9))


def detectable_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The smallest effect of each factor that the analysis would find with a probability of `config.power`.

    A factor's effect is a range of R per cent of yield between its levels. Its F has the noncentrality
    R^2 q / sigma^2, with sigma^2 the mean square of the residual and R^2 q the type II sum of squares of that effect
    without errors: q = c'(I - H) c, H the projection onto the terms that do not hold the factor. F exceeds its critical
    value at 1 - confidence with the probability `power` at the noncentrality that `noncentrality` finds. Two shapes
    bound what a range can do: `steps`, from low to high in equal steps, the hardest to find of three levels, and
    `halves`, half of the levels low and half high, the easiest. Columns: factor, shape, the degrees of freedom,
    critical_F, noncentrality, residual_percent (sigma), smallest_range_percent, found_range_percent (of the mean
    yields between the levels), power, confidence. sigma is itself known from few degrees of freedom: lower_percent and
    upper_percent are the smallest range at the ends of its chi-squared interval.
    """
    fit = fit_factors(config, runs)
    rest, table = int(fit.df_resid), sums_of_squares(config, fit, 2)
    tail = (1 - config.confidence) / 2
    rows = []
    for symbol in (term for term in config.model if ":" not in term):
        codes = runs[symbol].to_numpy()
        levels, own = len(config.factor(symbol).levels), table.loc[symbol, "degrees_of_freedom"]
        others = [term for term in config.model if symbol not in term.split(":")]
        columns = np.hstack([np.ones((len(runs), 1)), *(term_columns(config, runs, term) for term in others)])
        critical = float(f_exceeded(1 - config.confidence, own, rest))
        needed = noncentrality(critical, own, rest, 1 - config.power)
        means = runs[YIELD].groupby(codes).mean()
        shapes = {
            "steps": np.linspace(-0.5, 0.5, levels),
            "halves": np.where(np.arange(levels) < levels / 2, -0.5, 0.5),
        }
        for shape, heights in shapes.items():
            effect = heights[codes]
            alone = effect - columns @ np.linalg.lstsq(columns, effect, rcond=None)[0]
            least = 100 * np.sqrt(needed * fit.mse_resid / (alone @ alone))
            ends = np.sqrt(rest / chi_squared_exceeded([tail, 1 - tail], rest))
            rows.append(
                {
                    "factor": symbol,
                    "shape": shape,
                    "degrees_of_freedom": own,
                    "residual_degrees_of_freedom": rest,
                    "critical_F": critical,
                    "noncentrality": needed,
                    "residual_percent": 100 * np.sqrt(fit.mse_resid),
                    "smallest_range_percent": least,
                    "lower_percent": least * ends[0],
                    "upper_percent": least * ends[1],
                    "found_range_percent": float(np.ptp(means)),
                    "power": config.power,
                    "confidence": config.confidence,
                }
            )
    return pd.DataFrame(rows)


def effect_sizes(terms: pd.DataFrame, residual: pd.Series, runs: int, total: float, confidence: float) -> pd.DataFrame:
    """Eta and omega squared of each term of an analysis of `runs` runs with the `total` sum of squares.

    partial eta2 = SS / (SS + SS_residual) = df F / (df F + df_residual)
    partial omega2 = df (F - 1) / (df (F - 1) + N), 0 if F < 1
    omega2 = (SS - df MS_residual) / (SS_total + MS_residual), 0 if F < 1

    The intervals follow from the noncentrality lambda that puts F at the two tails of its distribution (Steiger,
    Psychological Methods 9, 164, 2004): lambda / (lambda + df_residual) for partial eta2, the convention of R's
    effectsize, and the share of variance lambda / (lambda + N) for partial omega2. Eta squared is biased upwards,
    strongly so with few residual degrees of freedom, and its interval is then not symmetric.
    """
    own, f_value = terms["degrees_of_freedom"], terms["F"]
    rest = residual["degrees_of_freedom"]
    mean_square = residual["sum_of_squares"] / rest
    tail = (1 - confidence) / 2
    limits = np.array(
        [
            [noncentrality(statistic, number, rest, probability) for probability in (1 - tail, tail)]
            for number, statistic in zip(own, f_value, strict=True)
        ]
    ).reshape(-1, 2)
    eta, omega = limits / (limits + rest), limits / (limits + runs)
    gain = np.maximum(own * (f_value - 1), 0)
    return pd.DataFrame(
        {
            "partial_eta_squared": terms["sum_of_squares"] / (terms["sum_of_squares"] + residual["sum_of_squares"]),
            "partial_eta_squared_lower": eta[:, 0],
            "partial_eta_squared_upper": eta[:, 1],
            "partial_omega_squared": gain / (gain + runs),
            "partial_omega_squared_lower": omega[:, 0],
            "partial_omega_squared_upper": omega[:, 1],
            "omega_squared": gain * mean_square / (total + mean_square),
            "confidence": confidence,
        },
        index=terms.index,
    )


def interaction_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """For each panel and pair of levels: number of runs, mean, lowest and highest yield [%].

    A mean is over the runs as they were done, for all levels of the other factors. A mean over few runs also contains
    the effects of the other factors.
    """
    tables = []
    for figure in config.interactions:
        for axis, curve in figure.panels:
            table = runs.groupby([curve, axis])[YIELD].agg(
                runs="size", mean_yield_percent="mean", lowest_yield_percent="min", highest_yield_percent="max"
            )
            table = table.reset_index(names=["curve_code", "axis_code"]).assign(figure=figure.name)
            for side, symbol in (("axis", axis), ("curve", curve)):
                table[side] = symbol
                table[f"{side}_level"] = [config.factor(symbol).levels[code] for code in table[f"{side}_code"]]
            tables.append(table)
    columns = ["figure", "axis", "axis_code", "axis_level", "curve", "curve_code", "curve_level", "runs"]
    columns += ["mean_yield_percent", "lowest_yield_percent", "highest_yield_percent"]
    return pd.concat(tables)[columns] if tables else pd.DataFrame(columns=columns)
