"""How many measured numbers the stated intervals of the predictions hold."""

import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.validation.verdicts import NO_SETUP

LEVEL = 0.95
EVERY = "all"


def tabulate_coverage(verdicts: pd.DataFrame) -> pd.DataFrame:
    """A row for each set-up and kind of interval, for each kind, and for all: how many numbers the intervals hold.

    verdicts: of `give_verdicts`. Only measured numbers count, not results of other codes, and only with a prediction
    that has an interval and is judged. Columns: setup, interval, numbers; held: numbers within the predicted interval;
    share; lower, upper: Clopper and Pearson's interval of the share, as if the numbers were independent; overlapping:
    numbers whose stated uncertainty reaches the predicted interval.
    """
    measured = verdicts["class"].str.startswith("measured") & (verdicts["verdict"] != NO_SETUP)
    known = verdicts[measured & verdicts["predicted_lower"].notna()]
    value, half = known["measured"], known["measured_uncertainty"].fillna(0.0)
    low, high = known["predicted_lower"], known["predicted_upper"]
    known = known.assign(held=value.between(low, high), overlapping=(value + half >= low) & (value - half <= high))
    groups = [known, known.assign(setup=EVERY), known.assign(setup=EVERY, interval=EVERY)]
    rows = []
    for (setup, interval), group in pd.concat(groups).groupby(["setup", "interval"], sort=False):
        held, numbers = int(group["held"].sum()), len(group)
        lower, upper = proportion_confint(held, numbers, alpha=1 - LEVEL, method="beta")
        rows.append(
            {
                "setup": setup, "interval": interval, "numbers": numbers, "held": held, "share": held / numbers,
                "lower": lower, "upper": upper, "overlapping": int(group["overlapping"].sum()),
            }
        )  # fmt: skip
    columns = ["setup", "interval", "numbers", "held", "share", "lower", "upper", "overlapping"]
    return pd.DataFrame(rows, columns=columns)
