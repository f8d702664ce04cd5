"""How much of a term's sum of squares an effect outside the model could claim, and models with that effect instead."""

from itertools import combinations, product
from math import log

import numpy as np
import pandas as pd
from scipy.stats import f as f_distribution
from statsmodels.regression.linear_model import OLS

from millprint.config.doe import AnalysisConfig
from millprint.doe.aliases import interaction_partners, term_columns
from millprint.doe.runs import YIELD

# Longer tables of models are not read.
MOST_MODELS = 64
# One minus the leverage of a run, below which it is zero but for rounding.
LEAST_SPARE_LEVERAGE = 1e-9


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


def contested_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """For each term of the model, what every main effect and two-factor interaction outside it could claim.

    sum_of_squares is type II: SS(term | the terms that do not hold it); with the rival entered before the term it is
    sum_if_rival_first, on degrees_of_freedom_if_rival_first. fraction_claimable = 1 - sum_if_rival_first /
    sum_of_squares: 1 if the data cannot tell the two apart, 0 if the rival takes nothing, below 0 if the term is
    clearer beside the rival (in runs that are not orthogonal). F_if_rival_first and its p-value are against the
    residual of the whole model with the rival; they are empty if the rival leaves no degree of freedom.
    Rivals that share no degree of freedom with the term are left out.
    """
    models = _Projector(config, runs)
    possible = [*config.symbols, *(":".join(pair) for pair in combinations(config.symbols, 2))]
    modelled = {frozenset(term.split(":")) for term in config.model}
    rivals = [term for term in possible if frozenset(term.split(":")) not in modelled]
    rows = []
    for term, rival in product(config.model, rivals):
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
                "sum_if_rival_first": first,
                "fraction_claimable": 1 - first / own,
                "F_if_rival_first": statistic,
                "p_if_rival_first": f_distribution.sf(statistic, left, residual) if left and residual else np.nan,
                "residual_degrees_of_freedom": residual,
            }
        )
    columns = ["term", "degrees_of_freedom", "sum_of_squares", "rival", "rival_sum_of_squares"]
    columns += ["degrees_of_freedom_if_rival_first", "sum_if_rival_first", "fraction_claimable"]
    columns += ["F_if_rival_first", "p_if_rival_first", "residual_degrees_of_freedom"]
    return pd.DataFrame(rows, columns=columns)


def _choices(config: AnalysisConfig) -> list[list[str]]:
    """For each term of the model, itself and the two-factor interactions that share a component with it."""
    choices = []
    for term in config.model:
        partners = [":".join(pair) for pair in interaction_partners(config, term)] if term.count(":") == 1 else []
        same = next((pair for pair in partners if set(pair.split(":")) == set(term.split(":"))), term)
        choices.append([term, *(pair for pair in partners if pair != same)])
    return choices


def rival_models_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The model of the analysis, and those with a confounded interaction in place of one of its interactions.

    AICc = N ln(RSS / N) + 2 k + 2 k (k + 1) / (N - k - 1), k parameters and a variance; r2_leave_one_out predicts each
    run from the others, and is not a number if a single run fixes a parameter. Models with terms that the runs cannot
    tell apart are left out, and so are all but the first MOST_MODELS.
    """
    models, count = _Projector(config, runs), len(runs)
    rows = []
    for terms in list(product(*_choices(config)))[:MOST_MODELS]:
        columns = models.columns(list(terms))
        rank = models.fit(list(terms))[1]
        if rank < columns.shape[1] or rank >= count:
            continue
        fit = OLS(models.response, columns).fit()
        influence = fit.get_influence()
        # A run of full leverage cannot be predicted from the others.
        predictable = (1 - influence.hat_matrix_diag).min() > LEAST_SPARE_LEVERAGE
        parameters, spare = rank + 1, count - rank - 2
        rows.append(
            {
                "model": " + ".join(terms),
                "residual_degrees_of_freedom": count - rank,
                "residual_sum_of_squares": fit.ssr,
                "r2": fit.rsquared,
                "r2_adjusted": fit.rsquared_adj,
                "r2_leave_one_out": 1 - np.sum(influence.resid_press**2) / fit.centered_tss if predictable else np.nan,
                "aicc": count * log(fit.ssr / count)
                + 2 * parameters
                + (2 * parameters * (parameters + 1) / spare if spare > 0 else np.inf),
            }
        )
    return pd.DataFrame(rows)
