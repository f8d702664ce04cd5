"""The engineered features of thesis Sec. 5.2.2."""

import pandas as pd
from scipy.special import expit

CHEMICAL = ("bpr", "molar_ratio", "time_h")
MECHANICAL = ("normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz")
CONDITIONS = (*CHEMICAL, *MECHANICAL)
FEATURES = (*CONDITIONS, "molar_ratio_squared", "bpr_molar_ratio", "time_sigmoid", "bpr_sigmoid")
TIME = "time_h"


def engineer(rows: pd.DataFrame) -> pd.DataFrame:
    """The ten features of every row, (n, 10), in the order of FEATURES.

    To the six conditions come molar_ratio^2, bpr * molar_ratio, and the sigmoids 1 / (1 + exp(-x)) of the time in
    hours and of the ball-to-powder ratio, both unscaled: 5 h is told from more, and 10 from 30, but little else.
    """
    features = rows[list(CONDITIONS)].astype(float)
    return features.assign(
        molar_ratio_squared=features["molar_ratio"] ** 2,
        bpr_molar_ratio=features["bpr"] * features["molar_ratio"],
        time_sigmoid=expit(features[TIME]),
        bpr_sigmoid=expit(features["bpr"]),
    )[list(FEATURES)]
