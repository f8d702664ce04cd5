"""Linear and quadratic trends of each factor within the whole model, with intervals in per cent of yield."""

import numpy as np
import pandas as pd
from scipy.stats import t as t_distribution

from millprint.config.analysis import AnalysisConfig
from millprint.doe.aliases import level_contrasts, term_columns
from millprint.doe.effects import effect_sizes
from millprint.doe.runs import YIELD

SHAPES = "LQ"


def trend_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The single contrasts of the numeric factors' main effects, each adjusted for everything else in the model.

    change_percent is the yield at the contrast's highest level less that at its lowest: from the lowest to the highest
    level for L, from the middle to the mean of the ends of three equally spaced levels for Q. Its interval is Student's
    with the residual's degrees of freedom; the sum of squares is of type III, F = t2; the effect sizes are those of
    `effect_sizes`. The thesis's own contrasts (Table 2.5) have the residual of a model without interactions and no F.
    """
    columns = [np.ones((len(runs), 1))]
    owners: list[tuple[str, int] | None] = [None]
    for term in config.model:
        own = term_columns(config, runs, term)
        columns.append(own)
        owners += [(term, place) for place in range(own.shape[1])]
    matrix = np.hstack(columns)
    response = runs[YIELD].to_numpy()
    inverse = np.linalg.inv(matrix.T @ matrix)
    estimate = inverse @ matrix.T @ response
    rest = response - matrix @ estimate
    residual = len(runs) - matrix.shape[1]
    variance = rest @ rest / residual
    error = np.sqrt(variance * np.diag(inverse))
    rows: list[tuple[str, str, float, float, float]] = []
    for place, owner in enumerate(owners):
        if owner is None or ":" in owner[0] or owner[1] >= len(SHAPES) or not config.factor(owner[0]).numeric:
            continue
        contrast = level_contrasts(config.factor(owner[0]))[:, owner[1]]
        rows.append((f"{owner[0]}{SHAPES[owner[1]]}", owner[0], estimate[place], error[place], np.ptp(contrast)))
    return _with_statistics(rows, residual, variance, response, config.confidence)


def _with_statistics(
    rows: list[tuple], residual: int, variance: float, response: np.ndarray, confidence: float
) -> pd.DataFrame:
    frame = pd.DataFrame(rows, columns=["trend", "factor", "estimate", "error", "span"])
    frame = frame.astype({"estimate": float, "error": float, "span": float})
    statistic = frame["estimate"] / frame["error"]
    half = t_distribution.ppf((1 + confidence) / 2, residual) * frame["error"] * frame["span"]
    change = frame["estimate"] * frame["span"]
    terms = pd.DataFrame({"degrees_of_freedom": 1, "sum_of_squares": statistic**2 * variance * 1e-4, "F": statistic**2})
    rest = pd.Series({"degrees_of_freedom": residual, "sum_of_squares": residual * variance * 1e-4})
    table = pd.DataFrame(
        {
            "trend": frame["trend"],
            "factor": frame["factor"],
            "change_percent": change,
            "change_lower_percent": change - half,
            "change_upper_percent": change + half,
            **terms,
            "p_value": 2 * t_distribution.sf(statistic.abs(), residual),
        }
    )
    total = 1e-4 * float(((response - response.mean()) ** 2).sum())
    return table.join(effect_sizes(terms, rest, len(response), total, confidence))
