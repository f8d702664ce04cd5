"""Effects of the factors on the yield: trends of single factors in the full model, and means of pairs of levels."""

import numpy as np
import pandas as pd
from statsmodels.regression.linear_model import OLS

from millprint.config.doe import AnalysisConfig
from millprint.thesis.doe.aliases import level_contrasts, term_columns
from millprint.thesis.doe.runs import YIELD
from millprint.thesis.doe.variance import effect_sizes

SHAPES = "LQ"


def trend_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """The single contrasts of the numeric factors' main effects, each adjusted for everything else in the model.

    change_percent is the yield at the contrast's highest level less that at its lowest: from the lowest to the highest
    level for L, from the middle to the mean of the ends of three equally spaced levels for Q. Its interval is Student's
    with the residual's degrees of freedom; the sum of squares is of type III, F = t2; the effect sizes are those of
    `effect_sizes`. The thesis's own contrasts (Table 2.5) have the residual of a model without interactions and no F.
    """
    parts = [pd.DataFrame({"mean": np.ones(len(runs))})]
    owners: dict[str, tuple[str, float]] = {}
    for term in config.model:
        columns = term_columns(config, runs, term)
        names = [f"{term} {place}" for place in range(columns.shape[1])]
        if ":" not in term and config.factor(term).numeric:
            ranges = np.ptp(level_contrasts(config.factor(term)), axis=0)[: len(SHAPES)]
            names[: len(ranges)] = [f"{term}{shape}" for shape in SHAPES[: len(ranges)]]
            owners |= {name: (term, span) for name, span in zip(names, ranges, strict=False)}
        parts.append(pd.DataFrame(columns, columns=names))
    fit = OLS(runs[YIELD].to_numpy(), pd.concat(parts, axis=1)).fit()
    trends, spans = list(owners), np.array([span for _, span in owners.values()])
    interval = fit.conf_int(1 - config.confidence).loc[trends].mul(spans, axis=0)
    f_values = fit.tvalues[trends] ** 2
    table = pd.DataFrame(
        {
            "factor": [factor for factor, _ in owners.values()],
            "change_percent": fit.params[trends] * spans,
            "change_lower_percent": interval[0],
            "change_upper_percent": interval[1],
            "degrees_of_freedom": 1,
            # Of yields as fractions, as in the other tables.
            "sum_of_squares": 1e-4 * fit.scale * f_values,
            "F": f_values,
            "p_value": fit.pvalues[trends],
        },
        index=pd.Index(trends, name="trend"),
    )
    residual = pd.Series({"degrees_of_freedom": int(fit.df_resid), "sum_of_squares": 1e-4 * fit.ssr})
    sizes = effect_sizes(table, residual, len(runs), 1e-4 * fit.centered_tss, config.confidence)
    return table.join(sizes).reset_index()


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
