"""Descriptors against the time step or against Young's modulus (thesis Fig. 3.4), with their standard errors."""

import numpy as np
import pandas as pd

from millprint.config.counting import recorded_count
from millprint.config.sweep import as_tabulated

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
        "simulated_s": summary["steps"] * summary["time_step_s"],
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
    # The minimum, because a job may have compiled its kernels or shared its core.
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
