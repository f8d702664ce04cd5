"""Mean yields for each combination of two factors' levels: the interaction plots of thesis Figs 2.4 and 2.5."""

import pandas as pd

from millprint.config.analysis import AnalysisConfig
from millprint.doe.runs import YIELD


def interaction_table(config: AnalysisConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """For each panel and pair of levels: number of runs, mean, lowest and highest yield [%].

    All other factors are averaged out over the runs as they were done, so that a mean over few runs also carries
    whatever else differs between them.
    """
    rows = []
    for figure in config.interactions:
        for axis, curve in figure.panels:
            grouped = runs.groupby([curve, axis], sort=True)[YIELD]
            for (curve_code, axis_code), yields in grouped:
                rows.append(
                    {
                        "figure": figure.name,
                        "axis": axis,
                        "axis_code": axis_code,
                        "axis_level": config.factor(axis).levels[axis_code],
                        "curve": curve,
                        "curve_code": curve_code,
                        "curve_level": config.factor(curve).levels[curve_code],
                        "runs": len(yields),
                        "mean_yield_percent": yields.mean(),
                        "lowest_yield_percent": yields.min(),
                        "highest_yield_percent": yields.max(),
                    }
                )
    columns = ["figure", "axis", "axis_code", "axis_level", "curve", "curve_code", "curve_level", "runs"]
    columns += ["mean_yield_percent", "lowest_yield_percent", "highest_yield_percent"]
    return pd.DataFrame(rows, columns=columns)
