"""Residuals of the analysis of variance, as normal errors and against repeated runs; and effects outside the model.

Writes the tables of a design, and those of the analysis of its runs.
"""

from itertools import combinations, product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import rankdata
from statsmodels.regression.linear_model import RegressionResultsWrapper

from millprint.config.doe import AnalysisConfig, DesignConfig
from millprint.estimate.quantiles import chi_squared_above, f_above, normal_quantile
from millprint.run.files import write_json, write_table
from millprint.thesis.doe.factorial_designs import (
    RUN_ORDER,
    YIELD,
    alias_table,
    as_designed,
    audit_table,
    describe,
    design_table,
    read_runs,
    term_columns,
    treatments,
)
from millprint.thesis.doe.variance import (
    corrected_table,
    detectable_table,
    fit_factors,
    interaction_table,
    printed_table,
    sums_of_squares,
)

# A run of at least this leverage fixes a parameter: the model goes through it.
FULL_LEVERAGE = 1 - 1e-9


def residual_table(runs: pd.DataFrame, fit: RegressionResultsWrapper) -> pd.DataFrame:
    """Each run with its fitted yield, residual, leverage, studentised residuals, Cook's distance, normal quantile.

    Residuals are in per cent of yield. Studentised values are empty if the leverage is 1: the model then goes through
    the run, for any yield. The table has a column run_order if the runs have one.
    """
    leverage = fit.get_influence().hat_matrix_diag
    order = rankdata(fit.resid)
    # Blom's plotting positions.
    quantile = normal_quantile((order - 0.375) / (len(order) + 0.25))
    # The share of an error that the fit leaves; statsmodels would divide by 0, and fit the model again for each run.
    left = np.where(leverage < FULL_LEVERAGE, 1 - leverage, np.nan)
    studentised, free = fit.resid.to_numpy() / np.sqrt(fit.scale * left), fit.df_resid
    return pd.DataFrame(
        {
            "case": runs["case"].to_numpy(),
            YIELD: runs[YIELD].to_numpy(),
            "fitted_percent": 100 * fit.fittedvalues.to_numpy(),
            "residual_percent": 100 * fit.resid.to_numpy(),
            "leverage": leverage,
            "studentised": studentised,
            "studentised_external": studentised * np.sqrt((free - 1) / (free - studentised**2)),
            "cooks_distance": studentised**2 * leverage / left / fit.model.exog.shape[1],
            "normal_quantile": quantile,
            **({RUN_ORDER: runs[RUN_ORDER].to_numpy()} if RUN_ORDER in runs else {}),
        }
    )


def pure_error(config: AnalysisConfig, runs: pd.DataFrame) -> tuple[float, int]:
    """Sum of squares of runs of the same treatment about their mean, yield as a fraction, and degrees of freedom."""
    groups = (runs[YIELD] / 100).groupby(treatments(runs[config.symbols]))
    return float((groups.var(ddof=0) * groups.size()).sum()), int((groups.size() - 1).sum())


def lack_of_fit_table(config: AnalysisConfig, runs: pd.DataFrame, fit: RegressionResultsWrapper) -> pd.DataFrame:
    """Each term, and the residual, against what is known of repeated runs.

    The first row is the classical test, F = (SS_residual - SS_pure) / df over the mean square of pure error, if some
    treatment was run twice. The others are SS / s2 against chi-squared, s the configured repeatability. The row of the
    residual tests whether the model leaves something out. The other rows (type II sums) test whether a term exceeds
    the scatter of repeated runs; they do not test it against what the model leaves out.
    """
    table = sums_of_squares(config, fit, 2)[["degrees_of_freedom", "sum_of_squares"]]
    rest = table.loc["Residual"]
    squares, repeats = pure_error(config, runs)
    left = int(rest["degrees_of_freedom"]) - repeats
    row: dict[str, Any] = {"against": "repeated treatments", "term": "Residual", "degrees_of_freedom": left}
    row["error_percent"] = 100 * np.sqrt(squares / repeats) if repeats else np.nan
    if repeats and left and squares > 0:
        row["sum_of_squares"] = rest["sum_of_squares"] - squares
        row["statistic"] = row["sum_of_squares"] / left / (squares / repeats)
        row["p_value"] = f_above(row["statistic"], left, repeats)
        row["note"] = f"F on {left} and {repeats} degrees of freedom"
    else:
        row["note"] = "no test: no treatment was run twice" if not repeats else "no test: nothing is left to be tested"
    rows = [row]
    if config.repeatability_percent is not None:
        error = config.repeatability_percent / 100
        for term, line in table.iterrows():
            statistic = line["sum_of_squares"] / error**2
            own = {"term": term, **line, "error_percent": 100 * error, "statistic": statistic}
            own["p_value"] = chi_squared_above(statistic, line["degrees_of_freedom"])
            note = "chi-squared of the residual: what the model leaves out" if term == "Residual" else "chi-squared"
            rows.append({"against": "repeatability", **own, "note": note})
    columns = ["against", "term", "degrees_of_freedom", "sum_of_squares", "error_percent", "statistic", "p_value"]
    return pd.DataFrame(rows).reindex(columns=[*columns, "note"])


# The last row of the table of what the residual consists of.
TOGETHER = "together"


class _Projector:
    """Residual sums of squares and ranks of models given as lists of terms, over the same runs."""

    def __init__(self, config: AnalysisConfig, runs: pd.DataFrame) -> None:
        self.config, self.runs = config, runs
        self.response = runs[YIELD].to_numpy() / 100

    def columns(self, terms: list[str]) -> np.ndarray:
        parts = [np.ones((len(self.runs), 1)), *(term_columns(self.config, self.runs, term) for term in terms)]
        return np.hstack(parts)

    def fit(self, terms: list[str]) -> tuple[float, int]:
        """Residual sum of squares and rank of a model with a mean and `terms`."""
        left, singular, _ = np.linalg.svd(self.columns(terms), full_matrices=False)
        basis = left[:, singular > 1e-10 * singular[0]]
        rest = self.response - basis @ (basis.T @ self.response)
        return float(rest @ rest), basis.shape[1]


def _without(config: AnalysisConfig, term: str) -> list[str]:
    """The terms of the model that do not hold `term`: what a type II sum is adjusted for."""
    own = set(term.split(":"))
    return [other for other in config.model if not own <= set(other.split(":"))]


def _rivals(config: AnalysisConfig) -> list[str]:
    """The main effects and two-factor interactions that are not in the model."""
    possible = [*config.symbols, *(":".join(pair) for pair in combinations(config.symbols, 2))]
    modelled = {frozenset(term.split(":")) for term in config.model}
    return [term for term in possible if frozenset(term.split(":")) not in modelled]


def residual_parts_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """What the residual of the analysis consists of: the effects outside the model that take degrees of freedom of it.

    Each effect is added to the model without the others. degrees_of_freedom, sum_of_squares and share are what it takes
    of the residual: the factors as they were run, and those ending in _as_designed at the levels that the generators
    give. The last row, `together`, has all these effects in the model at once; a share of 1 means that the residual
    holds these effects and nothing else, so that every F of the analysis is against them. In the design of thesis Table
    2.3 the parts as designed are orthogonal and their shares add up to that of the last row; as run they overlap.
    """
    rivals = _rivals(config)
    rows: dict[str, dict[str, object]] = {}
    for ending, codes in (("", runs), ("_as_designed", as_designed(config, runs))):
        models = _Projector(config, codes)
        rest, rank = models.fit(config.model)
        for name in [*rivals, TOGETHER]:
            added = rivals if name == TOGETHER else [name]
            smaller, larger = models.fit([*config.model, *added])
            found = (larger - rank, rest - smaller, (rest - smaller) / rest if rest > 0 else np.nan)
            names = (f"{column}{ending}" for column in ("degrees_of_freedom", "sum_of_squares", "share"))
            rows.setdefault(name, {"effect": name}).update(zip(names, found, strict=True))
    table = pd.DataFrame(rows.values())
    taken = (table["degrees_of_freedom"] > 0) | (table["degrees_of_freedom_as_designed"] > 0)
    return table[taken].reset_index(drop=True)


def contested_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """For each term of the model, what every main effect and two-factor interaction outside it could claim.

    sum_of_squares is type II: SS(term | the terms that do not hold it); with the rival entered before the term it is
    sum_if_rival_first, on degrees_of_freedom_if_rival_first. fraction_claimable = 1 - sum_if_rival_first /
    sum_of_squares: 1 if the data cannot tell the two apart, 0 if the rival takes nothing, below 0 if the term is
    clearer with the rival in the model (in runs that are not orthogonal). F_if_rival_first and its p-value are against
    the residual of the whole model with the rival; they are empty if the rival leaves no degree of freedom.
    degrees_of_freedom_if_designed is what the rival would leave if every run had the levels of the generators: fewer
    than as run where only the runs off the design tell the two apart, and their estimate rests only on those runs.
    Rivals that share no degree of freedom with the term are left out.
    """
    models, designed = _Projector(config, runs), _Projector(config, as_designed(config, runs))
    rows = []
    for term, rival in product(config.model, _rivals(config)):
        base = _without(config, term)
        (base_rest, base_rank), (full_rest, full_rank) = models.fit(base), models.fit([*base, term])
        (rival_rest, rival_rank), (both_rest, both_rank) = models.fit([*base, rival]), models.fit([*base, rival, term])
        own, first = base_rest - full_rest, rival_rest - both_rest
        alone, left = full_rank - base_rank, both_rank - rival_rank
        if abs(own - first) < 1e-9 * base_rest and alone == left:
            continue
        rest, rank = models.fit([*config.model, rival])
        residual = len(runs) - rank
        statistic = first / left / (rest / residual) if left and residual else np.nan
        rows.append(
            {
                "term": term,
                "degrees_of_freedom": alone,
                "sum_of_squares": own,
                "rival": rival,
                "rival_sum_of_squares": base_rest - rival_rest,
                "degrees_of_freedom_if_rival_first": left,
                "degrees_of_freedom_if_designed": designed.fit([*base, rival, term])[1]
                - designed.fit([*base, rival])[1],
                "sum_if_rival_first": first,
                "fraction_claimable": 1 - first / own if own > 0 else np.nan,
                "F_if_rival_first": statistic,
                "p_if_rival_first": f_above(statistic, left, residual) if left and residual else np.nan,
                "residual_degrees_of_freedom": residual,
            }
        )
    columns = ["term", "degrees_of_freedom", "sum_of_squares", "rival", "rival_sum_of_squares"]
    columns += ["degrees_of_freedom_if_rival_first", "degrees_of_freedom_if_designed"]
    columns += ["sum_if_rival_first", "fraction_claimable"]
    columns += ["F_if_rival_first", "p_if_rival_first", "residual_degrees_of_freedom"]
    return pd.DataFrame(rows, columns=columns)


# The tables of the design, by the names of the rule's outputs.
DESIGN_TABLES = ("design", "aliases", "audit")
# The tables of the analysis that follow the analysis of variance, by the names of the rule's outputs.
TABLES = ("contested", "residual_parts", "detectable", "residuals", "lack_of_fit", "interactions")
# Tables of the variance, by the names of the rule's outputs: the file that holds each.
VARIANCE = {"printed": "anova_printed", "corrected": "anova_corrected"}


def design_paths(folder: str | Path) -> dict[str, str]:
    """The path of every file of the design in a folder."""
    names = [*(f"{name}.tsv" for name in DESIGN_TABLES), "fraction.json"]
    return {name.partition(".")[0]: str(Path(folder) / name) for name in names}


def write_design(screening: str, outputs: dict[str, str], settings: DesignConfig) -> list[str]:
    """Write the design, its aliases and the audit of the runs, and return one line for each departure from it."""
    runs = read_runs(screening, settings.factors)
    write_table(design_table(settings), outputs["design"])
    write_json(describe(settings), outputs["fraction"])
    write_table(alias_table(settings), outputs["aliases"])
    found = audit_table(settings, runs)
    write_table(found, outputs["audit"])
    departures = found[found["departs"] == "yes"]
    return [f"{row.check}, {row.subject}: {row.found}, planned {row.wanted}" for row in departures.itertuples()]


def analysis_paths(folder: str | Path) -> dict[str, str]:
    """The path of every table of the analysis in a folder."""
    files = {**{name: name for name in TABLES}, **VARIANCE}
    return {name: str(Path(folder) / f"{file}.tsv") for name, file in files.items()}


def write_analysis(screening: str, tables: dict[str, str], settings: AnalysisConfig) -> None:
    """Write the tables of the analysis; `tables` has the path of each."""
    runs = read_runs(screening, settings.factors)
    fit = fit_factors(settings, runs)
    write_table(printed_table(settings, runs), tables["printed"])
    write_table(corrected_table(settings, runs), tables["corrected"])
    write_table(contested_table(settings, runs), tables["contested"])
    write_table(residual_parts_table(settings, runs), tables["residual_parts"])
    write_table(detectable_table(settings, runs), tables["detectable"])
    write_table(residual_table(runs, fit), tables["residuals"])
    write_table(lack_of_fit_table(settings, runs, fit), tables["lack_of_fit"])
    write_table(interaction_table(settings, runs), tables["interactions"])
