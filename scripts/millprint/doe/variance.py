"""Analysis of variance of the screening runs: as the thesis prints it, and as it should be."""

from decimal import ROUND_DOWN, Decimal
from math import floor, isfinite, log10

import numpy as np
import pandas as pd
from statsmodels.stats.multitest import multipletests

from millprint.config.analysis import AnalysisConfig
from millprint.doe.aliases import interaction_partners, term_columns
from millprint.doe.design import complete, level_codes
from millprint.doe.effects import effect_sizes
from millprint.doe.model import contrast_sums, fit_factors, sums_of_squares


def truncated(value: float, decimals: int = 3) -> str:
    """A number cut off, not rounded, after `decimals`, or at its first digit that is not zero if that comes later.

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


def freedom_of_source(config: AnalysisConfig, term: str) -> int:
    """Degrees of freedom of all the interactions that a source names, together, in the design: 6 for `AB, CD`.

    What Table 2.5 prints for an interaction, although its sum of squares is that of the term alone, with 4.
    """
    names = [":".join(pair) for pair in interaction_partners(config, term)] if term.count(":") == 1 else [term]
    codes = level_codes(config)
    columns = np.hstack([term_columns(config, codes, name) for name in names])
    return int(np.linalg.matrix_rank(columns - columns.mean(axis=0), tol=1e-9))


def as_designed(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The runs with the generated factors at the level that their generators want."""
    return runs.assign(**complete(config, runs[config.symbols]).to_dict("series"))


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
        rows.append(
            {
                "source": source_name(config, term),
                "term": term,
                **line,
                "degrees_of_freedom_of_source": np.nan if term == "Residual" else freedom_of_source(config, term),
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

    Type I is there for comparison. p_holm is the p-value corrected for the number of terms by Holm's method. The
    effect sizes and their intervals are those of `effect_sizes`.
    """
    fit = fit_factors(config, runs)
    tables = []
    for kind, name in ((2, "II"), (3, "III"), (1, "I")):
        table = sums_of_squares(config, fit, kind)
        terms = table.index != "Residual"
        table.loc[terms, "p_holm"] = multipletests(table.loc[terms, "p_value"], method="holm")[1]
        sizes = effect_sizes(table[terms], table.loc["Residual"], len(runs), float(fit.centered_tss), config.confidence)
        table = table.join(sizes)
        table.insert(0, "term", table.index)
        table.insert(0, "source", [source_name(config, term) for term in table.index])
        table.insert(0, "sums", name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)
