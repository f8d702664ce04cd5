"""Descriptors against the time step or Young's modulus (thesis Fig. 3.4), and the largest step that changes none."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from millprint.config.counting import recorded_count
from millprint.config.fingerprint import ConvergenceConfig
from millprint.config.sweep import as_tabulated
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import AGREES, DIFFERS, Allowed, Verdict, judge, judge_all
from millprint.estimate.quantiles import student_exceeded

# Columns that a series of runs has in common.
SERIES = ["mill", "contact", "ball_diameter_mm", "fill_ratio", "speed_rpm"]

# The varied quantity, and whether its largest value is the reference.
VARIED = {"time_step_s": False, "young_modulus_gpa": True}

# The descriptors that decide whether a step is accepted.
DESCRIPTORS = ["normal_energy_J", "tangential_energy_J", "specific_frequency_hz"]
POWERS = ["normal_power_W", "tangential_power_W", "rolling_power_W", "wall_power_W", "power_W"]


def column_of(quantity: str, what: str) -> str:
    """The column of a quantity's se, deviation_percent or deviation_se_percent; the unit stays last."""
    stem, unit = quantity.rsplit("_", 1)
    return f"{stem}_{what}" if what.endswith("_percent") else f"{stem}_{what}_{unit}"


def counted_by(summary: dict, rule: str) -> dict[str, float]:
    """DESCRIPTORS of a run under the counting rule of that name."""
    count = recorded_count(summary, rule)
    values = (count["mean_normal_J"], count["mean_tangential_J"], count["specific_frequency_hz"])
    return dict(zip(DESCRIPTORS, values, strict=True))


def run_row(summary: dict, varied: str, rule: str, further: list[str]) -> dict:
    """The row of a run: the quantity `varied`, descriptors under `rule`, and those of further rules with a prefix."""
    case, power, revolutions = summary["case"], summary["power_W"], summary["per_revolution"]
    energies = np.add(revolutions["normal_J"], revolutions["tangential_J"])
    variance_J2 = np.var(energies, ddof=1) if len(energies) > 1 else np.nan
    return {
        "mill": summary["mill"],
        "contact": summary["contact"],
        **as_tabulated(case),
        "varied": case[varied],
        "balls": summary["balls"],
        "young_modulus_gpa": (summary["young_modulus_pa"] or np.nan) / 1e9,
        "time_step_s": summary["time_step_s"],
        "rayleigh_fraction": summary["rayleigh_fraction"],
        "revolutions": summary["revolutions"],
        **counted_by(summary, rule),
        **{f"{name}_{quantity}": value for name in further for quantity, value in counted_by(summary, name).items()},
        **{f"{name}_power_W": power[name] for name in ("normal", "tangential", "rolling", "wall")},
        "power_W": power["normal"] + power["tangential"],
        "revolution_power_variance_W2": variance_J2 * summary["frequency_hz"] ** 2,
        "closure": summary["closure"],
        "max_overlap_fraction": summary["max_overlap_fraction"],
        "mean_ball_height_m": summary["mean_ball_height_m"],
        "steps": summary["steps"],
        "processor_s": summary["processor_s"],
        "wall_clock_s": summary["wall_clock_s"],
        "ns_per_ball_step": summary["ns_per_ball_step"],
    }


def _over_seeds(runs: pd.DataFrame, quantities: list[str], descending: bool) -> pd.DataFrame:
    """Means over the seeds of each value of the varied quantity, reference first, with standard errors."""
    groups = runs.groupby([*SERIES, "varied"], sort=True)
    table = groups.mean(numeric_only=True)
    table.insert(0, "seeds", groups.size())
    for quantity in quantities:
        table[column_of(quantity, "se")] = groups[quantity].std(ddof=1) / np.sqrt(table["seeds"])
    table["power_two_sigma_W"] = 2 * np.sqrt(table.pop("revolution_power_variance_W2"))
    # The median, because one of the jobs may have compiled its kernels or shared its core.
    times = ["processor_s", "wall_clock_s", "ns_per_ball_step"]
    table[times] = groups[times].median()
    table["closure_worst"] = groups["closure"].max()
    table["max_overlap_fraction"] = groups["max_overlap_fraction"].max()
    table["revolutions"] = groups["revolutions"].sum()
    # Every seed takes the same steps, up to the last few of an interval that does not divide evenly.
    table[["balls", "steps"]] = table[["balls", "steps"]].round().astype(int)
    return table.reset_index().sort_values([*SERIES, "varied"], ascending=[True] * len(SERIES) + [not descending])


def pooled_variance(mean: pd.Series, error: pd.Series, seeds: pd.Series) -> float:
    """Variance between seeds over the squared mean [-], pooled over rows; NaN where no row has two seeds.

    error: standard errors of the means, empty for one seed; v = sum (n_i - 1) (s_i / m_i)^2 / sum (n_i - 1).
    """
    relative = (error / mean) ** 2 * seeds
    freedom = (seeds - 1).sum()
    return ((seeds - 1) * relative.fillna(0.0)).sum() / freedom if freedom else np.nan


def deviations(series: pd.DataFrame, quantity: str) -> pd.DataFrame:
    """Deviation of each row from the first [%], and its standard error [%].

    series: the quantity, its standard error (column_of) and `seeds`, a row for each value; the first is the reference.
    The spread between seeds is taken as the same fraction of the mean in every row, and pooled: few seeds say little
    of it, many rows more. v as of `pooled_variance`; se = m_i / m_0 sqrt(v (1/n_i + 1/n_0)).
    """
    mean, seeds = series[quantity], series["seeds"]
    ratio = mean / mean.iloc[0]
    variance = pooled_variance(mean, series[column_of(quantity, "se")], seeds)
    error = ratio * np.sqrt(variance * (1 / seeds + 1 / seeds.iloc[0]))
    error.iloc[0] = 0.0
    return pd.DataFrame(
        {
            column_of(quantity, "deviation_percent"): 100 * (ratio - 1),
            column_of(quantity, "deviation_se_percent"): 100 * error,
        }
    )


def convergence_table(summaries: list[dict], varied: str, rule: str, further: list[str]) -> pd.DataFrame:
    """A row for each value of the varied quantity and each series (mill, contact set, ball, fill, speed).

    varied: `time_step_s` or `young_modulus_gpa`. The first row of a series is its reference: the finest step or the
    stiffest ball. Descriptors count collisions by `rule`, prefixed ones by the `further` rules. `_se_` columns are
    standard errors over seeds, empty for one seed; deviations are from the reference, with a pooled standard error.
    closure is the mean over seeds and closure_worst the largest; power_W is normal and tangential dissipation, and
    power_two_sigma_W two standard deviations of it between revolutions; seconds are medians over seeds.
    """
    quantities = [*DESCRIPTORS, *POWERS, *(f"{name}_{quantity}" for name in further for quantity in DESCRIPTORS)]
    runs = pd.DataFrame([run_row(summary, varied, rule, further) for summary in summaries])
    table = _over_seeds(runs, quantities, descending=VARIED[varied])
    for quantity in quantities:
        pieces = [deviations(series, quantity) for _, series in table.groupby(SERIES, sort=False)]
        table = table.join(pd.concat(pieces))
    front = [*SERIES, varied, *(name for name in ("time_step_s", "young_modulus_gpa") if name != varied)]
    front += ["rayleigh_fraction", "balls", "seeds", "revolutions", "counting_rule"]
    measured = [
        column
        for quantity in quantities
        for column in (quantity, *(column_of(quantity, w) for w in ("se", "deviation_percent", "deviation_se_percent")))
    ]
    table["counting_rule"] = rule
    rest = [name for name in table.columns if name not in {*front, *measured, "varied"}]
    return table[[*front, *measured, *rest]].reset_index(drop=True)


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
    failed = next((index for index, step in enumerate(steps) if step["verdict"] != AGREES), len(steps))
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
        failed = next((step for step in series["steps"] if step["verdict"] != AGREES), None)
        largest, taken = series["largest_step_s"], series["taken_step_s"]
        found = f"the largest step that agrees is {largest:.3g} s" if largest else "no step agrees with the finest"
        if failed:
            reasons = [] if failed["closes"] else [f"a balance open by {100 * failed['closure_worst']:.2g} %"]
            found += f" ({failed['time_step_s']:.3g} s differs by {', '.join(reasons + failed['deviating'])})"
        agrees = series["verdict"] == AGREES
        verdict = "agrees" if agrees else "differs: make dem.time_step_s or its sweep's smaller"
        parts.append(f"{series['ball_diameter_mm']:g} mm balls: {found}; the step taken, {taken:.3g} s, {verdict}")
    return "; ".join(parts)
