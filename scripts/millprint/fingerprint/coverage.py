"""How often the bands hold left-out conditions: each is predicted from the rest and counted."""

import numpy as np
import pandas as pd
from statsmodels.stats.proportion import proportion_confint

from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import LEFT_OUT, grouped

# Fill ratios at which the width of an interval is looked at.
FILLS_WITHIN = 40


def tabulate_coverage(fingerprint: Fingerprint) -> pd.DataFrame:
    """Share of left-out values inside their interval, for each quantity and each way of leaving out.

    A `condition` is left out alone, with all others of its `fill ratio`, or with all others of its `setting` (speed,
    ball size, density and amplitude); the last two extrapolate at the ends of the range. The parameters of the
    processes stay those of all conditions. `covered_lower`, `covered_upper`: Wilson's interval of the share, at the
    fingerprint's own probability; `error_percent`: root mean square of the errors; `half_width_percent`: median.
    """
    probability = fingerprint.about["probability"]
    rows = []
    for quantity, process in fingerprint.processes.items():
        inverse = process.inverse()
        for left_out, shared in LEFT_OUT.items():
            groups = grouped(process.inputs, shared)
            if len(groups) < 2:
                continue
            left = np.concatenate(groups)
            means, deviations = process.leave_out(groups, inverse)
            errors = process.logs[left] - means
            held = np.abs(errors) <= fingerprint.width * deviations
            lower, upper = proportion_confint(held.sum(), held.size, alpha=1 - probability, method="wilson")
            rows.append(
                {
                    "contact": fingerprint.about["contact"],
                    "left_out": left_out,
                    "quantity": quantity,
                    "conditions": held.size,
                    "nominal": probability,
                    "covered": held.mean(),
                    "covered_lower": lower,
                    "covered_upper": upper,
                    "error_percent": 100 * np.sqrt(np.mean(errors**2)),
                    "half_width_percent": 100 * np.expm1(fingerprint.width * np.median(deviations)),
                    "stretch": process.stretch,
                }
            )
    # Each way of leaving out with all its quantities.
    rows.sort(key=lambda row: list(LEFT_OUT).index(row["left_out"]))
    return pd.DataFrame(rows)


def half_widths(fingerprint: Fingerprint) -> dict[str, np.ndarray]:
    """Half of the interval of a condition over its value [-], for each quantity: median, smallest, largest.

    Over the range of fill ratios, at the simulated speeds and balls; the interval is that of `Fingerprint.scaled`.
    """
    inputs = fingerprint.at_settings(np.geomspace(*fingerprint.fill_range, FILLS_WITHIN))
    found = {}
    for quantity, predictor in fingerprint.predictors.items():
        deviations = predictor.predict(inputs).of_new
        found[quantity] = np.expm1(fingerprint.width * np.quantile(deviations, [0.5, 0.0, 1.0]))
    return found
