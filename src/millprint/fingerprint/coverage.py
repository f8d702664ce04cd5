"""How often the bands hold: each condition is left out, predicted from the rest, and counted if it is in its band."""

import numpy as np
import pandas as pd

from millprint.fingerprint.bands import factor_of
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import LEFT_OUT, grouped

# Fill ratios at which the width of an interval is evaluated.
FILLS_WITHIN = 40


def coverage_row(
    fingerprint: Fingerprint, left_out: str, quantity: str, errors: np.ndarray, halves: np.ndarray, stretch: float
) -> dict:
    """A row of coverage: how many errors of logarithms (n,) are within half the width of their bands (n,).

    `covered_lower`, `covered_upper`: Wilson's interval of the share, at the fingerprint's own probability;
    `error_percent`: root mean square of the errors; `half_width_percent`: median.
    """
    from statsmodels.stats.proportion import proportion_confint

    probability = fingerprint.about["probability"]
    held = np.abs(errors) <= halves
    lower, upper = proportion_confint(held.sum(), held.size, alpha=1 - probability, method="wilson")
    return {
        "contact": fingerprint.about["contact"],
        "left_out": left_out,
        "quantity": quantity,
        "conditions": held.size,
        "held": held.sum(),
        "nominal": probability,
        "covered": held.mean(),
        "covered_lower": lower,
        "covered_upper": upper,
        "error_percent": 100 * np.sqrt(np.mean(errors**2)),
        "half_width_percent": 100 * np.expm1(np.median(halves)),
        "stretch": stretch,
    }


def tabulate_coverage(fingerprint: Fingerprint) -> pd.DataFrame:
    """Share of left-out values inside their band, for each quantity and each way of leaving out, as `coverage_row`.

    A `condition` is left out on its own, with all others of its `fill ratio`, or with all others of its `setting`
    (speed, ball size, density and amplitude); the last two extrapolate at the ends of the range. The parameters of the
    processes are still fitted to all conditions, so these rows are not an independent test; that is
    `millprint.fingerprint.unseen_runs`. The band is for the mean of as many seeds as the condition has.
    """
    rows = []
    for quantity, process in fingerprint.processes.items():
        inverse = process.inverse()
        for left_out, shared in LEFT_OUT.items():
            groups = grouped(process.inputs, shared)
            if len(groups) < 2:
                continue
            means, deviations = process.leave_out(groups, inverse)
            errors = process.logs[np.concatenate(groups)] - means
            halves = fingerprint.width * deviations
            rows.append(coverage_row(fingerprint, left_out, quantity, errors, halves, process.stretch))
    # Each way of leaving out with all its quantities.
    rows.sort(key=lambda row: list(LEFT_OUT).index(row["left_out"]))
    return pd.DataFrame(rows)


def half_widths(fingerprint: Fingerprint) -> dict[str, np.ndarray]:
    """Half the width of the band of a new simulation over its value [-], for each quantity: median, smallest, largest.

    Over the range of fill ratios, at the simulated speeds and balls; the band is from `Fingerprint.scaled`, NaN where
    it is not known.
    """
    inputs = fingerprint.at_settings(np.geomspace(*fingerprint.fill_range, FILLS_WITHIN))
    found = {}
    for quantity, predictor in fingerprint.predictors.items():
        deviations = predictor.predict(inputs).of_new
        found[quantity] = factor_of(fingerprint.width * np.quantile(deviations, [0.5, 0.0, 1.0])) - 1
    return found
