"""How often the bands hold: of conditions that are left out of a fit, and of new simulations that it has not seen."""

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd

from millprint.estimate.estimates import Estimate, Interval, columns_of
from millprint.estimate.judge import judge
from millprint.fingerprint.descriptors import CONDITION, tabulate_descriptors
from millprint.fingerprint.model import Fingerprint
from millprint.fingerprint.processes import LEFT_OUT, grouped, logarithms


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
    `millprint.fingerprint.coverage`. The band is for the mean of as many seeds as the condition has.
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


# The powers of a new simulation together, as the claim on its band is stated.
POWERS = ("Pn", "Pt")
NEW = "nothing: new simulations"
HELD_OUT_COLUMNS = [*CONDITION, "seed", "quantity", "value", "predicted", "lower", "upper", "verdict"]


def describe_each(summaries: Iterable[dict], rule: str) -> pd.DataFrame:
    """Descriptors of simulations by a counting rule, one simulation a row, with its `seed`."""
    tables = [tabulate_descriptors([each], rule).assign(seed=each["case"]["seed"]) for each in summaries]
    return pd.concat(tables, ignore_index=True)


def judge_held_out(value: float, predicted: float, lower: float, upper: float) -> str:
    """The verdict on a predicted value with its band, by a value that was simulated; open where no band is known."""
    known = {} if np.isnan(lower) else {"scatter": Interval(lower, upper)}
    return judge(Estimate(predicted, "").having(known), Estimate(value, "")).word


def predict_held_out(fingerprint: Fingerprint, descriptors: pd.DataFrame) -> pd.DataFrame:
    """HELD_OUT_COLUMNS: a row for each new simulation and quantity, with the band of a new simulation, if it is known.

    The row has its condition and seed, the simulated and the predicted value, and the verdict on
    the second by the first.
    """
    bands, tables = fingerprint.told(logarithms(descriptors, fingerprint.kinds)), []
    for name in fingerprint.processes:
        own = descriptors[[*CONDITION, "seed"]].assign(quantity=name, value=descriptors[name], predicted=bands[name])
        own["lower"], own["upper"] = (bands[column] for column in columns_of(name, "scatter"))
        each = own[["value", "predicted", "lower", "upper"]].itertuples(index=False)
        tables.append(own.assign(verdict=[judge_held_out(*numbers) for numbers in each]))
    return pd.concat(tables, ignore_index=True)[HELD_OUT_COLUMNS]


def count_held_out(fingerprint: Fingerprint, predicted: pd.DataFrame) -> pd.DataFrame:
    """Rows of `tabulate_coverage` with NEW as what is left out: each quantity, and `powers`, normal and tangential.

    Only bands that are known are counted; a quantity has no row without any, as has a part where nothing hits.
    """
    rows, processes = [], fingerprint.processes
    known = predicted.dropna(subset=["lower", "upper"])
    for name, names in {"powers": POWERS, **{name: (name,) for name in processes}}.items():
        own = known[known["quantity"].isin(names)]
        if own.empty:
            continue
        errors, below, above = (
            np.log(own[end] / own["predicted"]).to_numpy(dtype=float) for end in ("value", "lower", "upper")
        )
        # An end of the band of a part is nearer where the whole limits it.
        halves = np.where(errors < 0, -below, above)
        stretch = max(processes[quantity].stretch for quantity in names if quantity in processes)
        rows.append(coverage_row(fingerprint, NEW, name, errors, halves, stretch))
    return pd.DataFrame(rows)


def sum_coverage(tables: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """The rows of new simulations of several mills, and of each quantity over `all` mills.

    tables: coverage of each mill. Columns: mill, quantity, conditions, held, covered, and Wilson's interval.
    """
    from statsmodels.stats.proportion import proportion_confint

    each = pd.concat([table[table["left_out"] == NEW].assign(mill=mill) for mill, table in tables.items()])
    total = each.groupby("quantity", sort=False)[["conditions", "held"]].sum().reset_index().assign(mill="all")
    table = pd.concat([each[["mill", "quantity", "nominal", "conditions", "held"]], total], ignore_index=True)
    table["nominal"] = table["nominal"].ffill()
    table["covered"] = table["held"] / table["conditions"]
    alpha = 1 - table["nominal"].iloc[0]
    ends = proportion_confint(table["held"], table["conditions"], alpha=alpha, method="wilson")
    return table.assign(covered_lower=ends[0], covered_upper=ends[1])
