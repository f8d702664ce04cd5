"""Leave-one-out over all runs, with scaling, search and fit repeated without the run that is predicted."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from millprint.config.yields import HonestConfig, TrainingConfig
from millprint.doe.runs import YIELD
from millprint.predict.training import train

SCHEME = "leave_one_out"


def leave_one_out(
    algorithm: str,
    strategy: str,
    rows: pd.DataFrame,
    settings: TrainingConfig,
    budget: HonestConfig,
    threads: int = 1,
    tick: Callable[[], None] = lambda: None,
) -> pd.DataFrame:
    """A prediction for each row by a model that has not seen it: case, yield_percent, predicted_percent, deviation_pp.

    rows: case, the six conditions, yield_percent. deviation_pp is NaN for a model that gives no intervals.
    """
    held_out = []
    for index in range(len(rows)):
        kept, row = rows.drop(index=rows.index[index]), rows.iloc[[index]]
        model, _ = train(algorithm, strategy, kept, kept[YIELD].to_numpy(float), settings, budget, threads=threads)
        deviation = model.deviation(row)
        held_out.append(
            {
                "case": row["case"].iloc[0],
                "yield_percent": float(row[YIELD].iloc[0]),
                "predicted_percent": float(model.predict(row)[0]),
                "deviation_pp": np.nan if deviation is None else float(deviation[0]),
            }
        )
        tick()
    return pd.DataFrame(held_out)
