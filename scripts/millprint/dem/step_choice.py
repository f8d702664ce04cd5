"""The largest time step that changes no descriptor and keeps the energy balance; is the default small enough?"""

import numpy as np
import pandas as pd

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of
from millprint.quantiles import student_exceeded


def closure_order(series: pd.DataFrame) -> float:
    """Order at which the balance error falls with the step: the slope of its logarithm over that of the step."""
    return float(np.polyfit(np.log(series["time_step_s"]), np.log(series["closure"]), 1)[0])


def chance_factor(series: pd.DataFrame, confidence: float) -> float:
    """Standard errors within which all deviations of a series stay with probability `confidence`, if steps are alike.

    Student's t with the degrees of freedom of the pooled spread, shared out among the comparisons (Bonferroni). Zero
    where one seed a step leaves the spread unknown: then only the tolerance counts.
    """
    freedom = int((series["seeds"] - 1).sum())
    comparisons = (len(series) - 1) * len(DESCRIPTORS)
    return float(student_exceeded((1 - confidence) / (2 * comparisons), freedom)) if freedom else 0.0


def judge_row(row: pd.Series, factor: float, settings: ConvergenceConfig) -> dict:
    """Whether one step passes: each descriptor within the tolerance or within chance, and a balance that closes."""
    deviations = {name: row[column_of(name, "deviation_percent")] for name in DESCRIPTORS}
    chance = {name: factor * np.nan_to_num(row[column_of(name, "deviation_se_percent")]) for name in DESCRIPTORS}
    beyond = [name for name in DESCRIPTORS if abs(deviations[name]) > max(settings.tolerance_percent, chance[name])]
    largest = max(DESCRIPTORS, key=lambda name: abs(deviations[name]))
    return {
        "time_step_s": float(row["time_step_s"]),
        "rayleigh_fraction": float(row["rayleigh_fraction"]),
        "largest_deviation_percent": float(deviations[largest]),
        "largest_deviation_of": largest,
        # With so few seeds, a smaller deviation cannot be distinguished from chance.
        "resolution_percent": float(max(chance.values())),
        "deviating": beyond,
        "closure_worst": float(row["closure_worst"]),
        "closes": bool(row["closure_worst"] <= settings.closure_max),
        "passes": bool(not beyond and row["closure_worst"] <= settings.closure_max),
    }


def judge_series(series: pd.DataFrame, settings: ConvergenceConfig) -> dict:
    """Verdict on each step of a series, finest first, and the largest that passes with every finer one."""
    factor = chance_factor(series, settings.confidence)
    steps = [judge_row(row, factor, settings) for _, row in series.iterrows()]
    failed = next((index for index, step in enumerate(steps) if not step["passes"]), len(steps))
    return {
        **{name: series[name].iloc[0] for name in SERIES[:2]},
        **{name: float(series[name].iloc[0]) for name in SERIES[2:]},
        "largest_step_s": steps[failed - 1]["time_step_s"] if failed else None,
        "closure_order": closure_order(series),
        "steps": steps,
    }


def choose_step(table: pd.DataFrame, settings: ConvergenceConfig, configured_s: float) -> dict:
    """The largest step that passes in every series of the time-step table, against the configured one [s].

    A step passes where each of DESCRIPTORS is within settings.tolerance_percent of that at the finest step, or within
    what chance does to so few seeds, where the balance closes within settings.closure_max, and every finer step passes.
    """
    series = [judge_series(rows, settings) for _, rows in table.groupby(SERIES, sort=False)]
    steps = [verdict["largest_step_s"] for verdict in series]
    largest = None if None in steps else min(steps)
    # A step is a little smaller than requested, so that a whole number of them makes an energy sample.
    holds = largest is not None and configured_s <= largest * 1.01
    return {
        "criteria": settings.model_dump(exclude={"study"}),
        "configured_step_s": configured_s,
        "largest_step_s": largest,
        "configured_step_holds": holds,
        "series": series,
    }


def in_words(choice: dict) -> str:
    """A line for the log: the largest step, the reason against the next one, and the result for the configured step."""
    configured, largest = choice["configured_step_s"], choice["largest_step_s"]
    verdict = "holds" if choice["configured_step_holds"] else "is too large: make dem.time_step_s smaller"
    if largest is None:
        return f"no step of the sweep passes; dem.time_step_s = {configured:g} s {verdict}"
    limits = []
    for series in choice["series"]:
        failed = next((step for step in series["steps"] if not step["passes"]), None)
        name = f"{series['ball_diameter_mm']:g} mm balls"
        if failed is None:
            limits.append(f"every step passes for {name}")
        else:
            reasons = [] if failed["closes"] else [f"a balance open by {100 * failed['closure_worst']:.2g} %"]
            limits.append(f"{name} fail at {failed['time_step_s']:.3g} s by {', '.join(reasons + failed['deviating'])}")
    found = f"the largest step that passes is {largest:.3g} s ({'; '.join(limits)})"
    return f"{found}; dem.time_step_s = {configured:g} s {verdict}"
