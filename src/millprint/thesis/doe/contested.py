"""How much of a term's sum of squares may belong to an effect outside the model, and models with that effect."""

from itertools import combinations, product
from math import log

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import OLS

from millprint.config.doe import AnalysisConfig
from millprint.statistics.quantiles import f_above
from millprint.thesis.doe.aliases import interaction_partners, term_columns
from millprint.thesis.doe.factorial_designs import as_designed
from millprint.thesis.doe.runs import YIELD

# Longer tables of models are not read.
MOST_MODELS = 64
# One minus the leverage of a run, below which it is zero but for rounding.
LEAST_SPARE_LEVERAGE = 1e-9
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
    run from the others. Either is empty where it is not defined: AICc with too few runs for its last term,
    r2_leave_one_out if a single run fixes a parameter. Models with terms that the runs cannot tell apart are left out,
    and so are all but the first MOST_MODELS.
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
                + (2 * parameters * (parameters + 1) / spare if spare > 0 else np.nan),
            }
        )
    return pd.DataFrame(rows)
