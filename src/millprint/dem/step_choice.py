"""The largest time step that changes no descriptor and keeps the energy balance, compared with the step taken."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from millprint.config.fingerprint import ConvergenceConfig
from millprint.dem.convergence import DESCRIPTORS, SERIES, column_of
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import AGREES, DIFFERS, Allowed, Verdict, judge, judge_all
from millprint.estimate.quantiles import student_exceeded

# Probability that no comparison of a sweep is significant by chance, and the largest energy balance error over the wall
# work at a step that passes [-].
CONFIDENCE, CLOSURE_MAX = 0.95, 0.001


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


def judge_deviation(percent: float, chance: float, tolerance: float) -> Verdict:
    """Whether a deviation [%] is within the tolerance, or else, with what chance does, agrees with none."""
    value = Estimate(percent, "%")
    near = judge(value, Allowed(-tolerance, tolerance))
    if near.agrees:
        return near
    return judge(value.having({"repeats": Interval(percent - chance, percent + chance)}), Estimate(0.0, "%"))


def judge_row(row: pd.Series, factor: float, settings: ConvergenceConfig) -> dict:
    """Whether one step agrees with the finest: by each descriptor, and by a balance that closes."""
    deviations = {name: row[column_of(name, "deviation_percent")] for name in DESCRIPTORS}
    chance = {name: factor * np.nan_to_num(row[column_of(name, "deviation_se_percent")]) for name in DESCRIPTORS}
    found = {name: judge_deviation(deviations[name], chance[name], settings.tolerance_percent) for name in DESCRIPTORS}
    beyond = [name for name in DESCRIPTORS if found[name].word == DIFFERS]
    closes = judge(Estimate(float(row["closure_worst"]), "-"), Allowed(upper=CLOSURE_MAX))
    largest = max(DESCRIPTORS, key=lambda name: abs(deviations[name]))
    return {
        "time_step_s": float(row["time_step_s"]),
        "rayleigh_fraction": float(row["rayleigh_fraction"]),
        "largest_deviation_percent": float(deviations[largest]),
        "largest_deviation_of": largest,
        # A smaller deviation cannot be distinguished from chance with this number of seeds.
        "resolution_percent": float(max(chance.values())),
        "deviating": beyond,
        "closure_worst": float(row["closure_worst"]),
        "closes": closes.agrees,
        "verdict": DIFFERS if beyond else closes.word,
    }


def judge_series(series: pd.DataFrame, settings: ConvergenceConfig, taken_s: float) -> dict:
    """Verdict on each step of a series, finest first, and the largest that agrees with every finer one.

    taken_s: the step that the sweeps take for these balls [s]. It is a little smaller than requested, so that a whole
    number of steps makes an energy sample.
    """
    factor = chance_factor(series, CONFIDENCE)
    steps = [judge_row(row, factor, settings) for _, row in series.iterrows()]
    failed = next((index for index, step in enumerate(steps) if step["verdict"] == DIFFERS), len(steps))
    largest = steps[failed - 1]["time_step_s"] if failed else None
    taken = judge(Estimate(taken_s, "s"), Allowed(upper=(largest or 0.0) * 1.01))
    return {
        **{name: series[name].iloc[0] for name in SERIES[:2]},
        **{name: float(series[name].iloc[0]) for name in SERIES[2:]},
        "largest_step_s": largest,
        "taken_step_s": taken_s,
        "verdict": taken.word,
        "closure_order": closure_order(series),
        "steps": steps,
    }


def choose_step(table: pd.DataFrame, settings: ConvergenceConfig, taken_s: Mapping[float, float]) -> dict:
    """The largest step that passes in each series of the time-step table, compared with the step of the sweeps.

    A step passes where each of DESCRIPTORS is within settings.tolerance_percent of that at the finest step, or within
    what chance does with these seeds, the balance closes within CLOSURE_MAX, and every finer step passes.
    taken_s: the step of the sweeps [s] for each ball diameter [mm].
    """
    series = [
        judge_series(rows, settings, taken_s[rows["ball_diameter_mm"].iloc[0]])
        for _, rows in table.groupby(SERIES, sort=False)
    ]
    return {
        "criteria": {
            **settings.model_dump(exclude={"study"}),
            "tolerance_percent": settings.tolerance_percent,
            "confidence": CONFIDENCE,
            "closure_max": CLOSURE_MAX,
        },
        "verdict": judge_all(Verdict(each["verdict"], "") for each in series).word,
        "series": series,
    }


def in_words(choice: dict) -> str:
    """A line for the log: for each series the largest step, the reason against the next one, and the one taken."""
    parts = []
    for series in choice["series"]:
        failed = next((step for step in series["steps"] if step["verdict"] == DIFFERS), None)
        largest, taken = series["largest_step_s"], series["taken_step_s"]
        found = f"the largest step that agrees is {largest:.3g} s" if largest else "no step agrees with the finest"
        if failed:
            reasons = [] if failed["closes"] else [f"a balance open by {100 * failed['closure_worst']:.2g} %"]
            found += f" ({failed['time_step_s']:.3g} s differs by {', '.join(reasons + failed['deviating'])})"
        agrees = series["verdict"] == AGREES
        verdict = "agrees" if agrees else "differs: make dem.time_step_s or its sweep's smaller"
        parts.append(f"{series['ball_diameter_mm']:g} mm balls: {found}; the step taken, {taken:.3g} s, {verdict}")
    return "; ".join(parts)
