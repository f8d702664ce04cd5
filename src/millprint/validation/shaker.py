"""Row 8a: the order of magnitude of ball speeds in a shaker mill whose balls and vial are not known."""

import numpy as np
import pandas as pd

from millprint.config.setups.shaker_setup import ShakerConfig
from millprint.validation.inputs import Inputs
from millprint.validation.predictions import BALLS, prediction
from millprint.view.snapshots import Snapshots, open_run

QUANTITY = "ball speeds"


def predict_ball_speeds(inputs: Inputs) -> pd.DataFrame:
    """Median of the balls' speeds in the laboratory [m/s], over all charges; the interval contains the `share`."""
    settings: ShakerConfig = inputs.settings
    speeds = []
    for path in inputs.cases:
        with open_run(inputs.runs / path / "run.h5") as file:
            for block in Snapshots(file).blocks():
                speeds.append(np.linalg.norm(block.balls["velocity_m_s"], axis=2).ravel())
    ends = (0.5 - settings.share / 2, 0.5, 0.5 + settings.share / 2)
    lower, median, upper = np.quantile(np.concatenate(speeds), ends)
    id = inputs.ids_of_single(QUANTITY)
    return pd.DataFrame([prediction(QUANTITY, "m/s", median, id=id, lower=lower, upper=upper, interval=BALLS)])
