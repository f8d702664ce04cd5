"""Descriptors of dissipation: one row a condition, the mean over its seeds."""

import numpy as np
import pandas as pd

from millprint.fingerprint.scaling import (
    effective_restitution,
    energy_scale,
    specific_frequency,
    specific_power,
)
from millprint.fingerprint.summaries import counted

# What tells conditions apart. `varied` names what a sweep changed of the mill or its balls: NOTHING where as built.
CONDITION = [
    "mill",
    "contact",
    "varied",
    "ball_diameter_mm",
    "fill_ratio",
    "speed_rpm",
    "density_kg_m3",
    "amplitude_m",
]
NOTHING = "nothing"
OVERRIDES = {"amplitude_mm": "amplitude", "density_kg_m3": "density"}

# What a table of descriptors must hold for the stages after it.
TEXT = ["mill", "contact", "varied", "counting_rule"]
NUMBERS = [
    *CONDITION[3:],
    "balls",
    "ball_diameter_m",
    "restitution",
    "static_friction",
    "effective_restitution",
    "speed_hz",
    "collision_gap_s",
    "normal_energy_J",
    "tangential_energy_J",
    "frequency_per_ball_hz",
    "normal_power_W",
    "tangential_power_W",
    "Pn",
    "Pt",
    "f",
    "ratio",
    "P",
    "En",
    "Et",
]

# Column of a table: key of a summary's count. In the order of a sorted table.
RULE_COLUMNS = {
    "collision_gap_s": "gap_s",
    "collision_peak_force_min_N": "peak_force_min_N",
    "collision_duration_min_s": "duration_min_s",
    "counting_rule": "name",
}


def condition_of(summary: dict) -> dict:
    """The condition of a run: CONDITION by name."""
    case = summary["case"]
    changed = [word for key, word in OVERRIDES.items() if case.get(key) is not None]
    return {
        "mill": summary["mill"],
        "contact": summary["contact"],
        "varied": " and ".join(changed) or NOTHING,
        **{name: case[name] for name in ("ball_diameter_mm", "fill_ratio", "speed_rpm")},
        **{name: summary[name] for name in ("density_kg_m3", "amplitude_m")},
    }


def as_built(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the mill and balls as they are described, without those of sweeps over amplitude or density."""
    return table[table["varied"] == NOTHING]


def run_row(summary: dict, rule_name: str) -> dict:
    """What one run measured, collisions counted by the rule of that name, which has no threshold."""
    rule = counted(summary, rule_name)
    power, error = summary["power_W"], summary["power_standard_error_W"]
    return {
        **condition_of(summary),
        "balls": summary["balls"],
        "ball_diameter_m": summary["ball_diameter_m"],
        "restitution": summary["restitution"],
        "static_friction": summary["static_friction"],
        "speed_hz": summary["frequency_hz"],
        "window_s": summary["window_s"],
        "counting_rule": rule["name"],
        "collision_gap_s": rule["gap_s"],
        "collision_frequency_hz": rule["frequency_hz"],
        "collisions": rule["count"],
        "normal_power_W": power["normal"],
        "tangential_power_W": power["tangential"],
        "rolling_power_W": power["rolling"],
        "wall_power_W": power["wall"],
        "normal_variance_W2": np.nan if error["normal"] is None else error["normal"] ** 2,
        "tangential_variance_W2": np.nan if error["tangential"] is None else error["tangential"] ** 2,
        "mean_ball_height_m": summary["mean_ball_height_m"],
        "median_contact_duration_s": summary["median_contact_duration_s"],
        "closure": summary["closure"],
    }


def _over_seeds(runs: pd.DataFrame) -> pd.DataFrame:
    """Mean of every measured column over the seeds of a condition, with the spread of powers and frequency."""
    groups = runs.groupby(CONDITION, sort=True)
    mean = groups.mean(numeric_only=True)
    mean.insert(0, "seeds", groups.size())
    mean.insert(1, "counting_rule", groups["counting_rule"].first())
    mean["collisions"] = groups["collisions"].sum()
    mean["closure"] = groups["closure"].agg(lambda closures: closures.abs().max())
    for name in ("normal", "tangential"):
        # Seeds are independent: the variance of their mean is the sum of variances over the square of their number.
        mean[f"{name}_power_se_W"] = np.sqrt(mean.pop(f"{name}_variance_W2") / mean["seeds"])
        mean[f"{name}_power_seed_sd_W"] = groups[f"{name}_power_W"].std(ddof=1)
    mean["collision_frequency_seed_sd_hz"] = groups["collision_frequency_hz"].std(ddof=1)
    mean["balls"] = mean["balls"].round().astype(int)
    return mean.reset_index()


def with_descriptors(table: pd.DataFrame) -> pd.DataFrame:
    """Add energies per collision and scaled quantities to powers [W] and frequencies [1/s].

    normal_energy_J, tangential_energy_J: Eqs 3.20 and 3.21, the dissipated energy over the number of collisions.
    Pn, Pt: Eq. 3.28; f: Eq. 3.29; ratio = Pt / Pn; P = Pn + Pt; En = Pn / f and Et = Pt / f, the energies over
    rho omega^2 A^2 d^3. A column ending in _se is a standard error in time: of the powers over revolutions, of the
    frequency as if collisions were independent (so a lower bound).
    """
    table = table.copy()
    machine = [table[name] for name in ("density_kg_m3", "speed_hz", "amplitude_m", "ball_diameter_m")]
    table["normal_energy_J"] = table["normal_power_W"] / table["collision_frequency_hz"]
    table["tangential_energy_J"] = table["tangential_power_W"] / table["collision_frequency_hz"]
    table["frequency_per_ball_hz"] = table["collision_frequency_hz"] / table["balls"]
    table["effective_restitution"] = effective_restitution(table["restitution"], table["static_friction"])
    table["Pn"] = specific_power(table["normal_power_W"], table["balls"], *machine)
    table["Pt"] = specific_power(table["tangential_power_W"], table["balls"], *machine)
    table["f"] = specific_frequency(table["collision_frequency_hz"], table["balls"], table["speed_hz"])
    table["ratio"] = table["Pt"] / table["Pn"]
    table["P"] = table["Pn"] + table["Pt"]
    table["En"] = table["normal_energy_J"] / energy_scale(*machine)
    table["Et"] = table["tangential_energy_J"] / energy_scale(*machine)
    normal = table["normal_power_se_W"] / table["normal_power_W"]
    tangential = table["tangential_power_se_W"] / table["tangential_power_W"]
    counting = 1.0 / np.sqrt(table["collisions"])
    table["Pn_se"] = table["Pn"] * normal
    table["Pt_se"] = table["Pt"] * tangential
    table["f_se"] = table["f"] * counting
    table["ratio_se"] = table["ratio"] * np.hypot(normal, tangential)
    table["P_se"] = np.hypot(table["Pn_se"], table["Pt_se"])
    table["En_se"] = table["En"] * np.hypot(normal, counting)
    table["Et_se"] = table["Et"] * np.hypot(tangential, counting)
    return table


def tabulate_descriptors(summaries: list[dict], rule_name: str) -> pd.DataFrame:
    """Descriptors of every condition, one row each; raises ConfigError if a run lacks the counting rule."""
    return with_descriptors(_over_seeds(pd.DataFrame([run_row(summary, rule_name) for summary in summaries])))


def tabulate_counting_rules(summaries: list[dict]) -> pd.DataFrame:
    """Collision frequency and energies per collision of every condition under every recorded counting rule.

    ball_ball_share: fraction of the counted collisions that are between balls; dropped_share: fraction of all
    collisions that a threshold of the rule drops. Energies of a rule that counts none are empty.
    """
    rows = []
    for summary in summaries:
        for rule in summary["collisions"]:
            frequency = rule["frequency_hz"]
            rows.append(
                {
                    **condition_of(summary),
                    **{column: rule[key] for column, key in RULE_COLUMNS.items()},
                    "speed_hz": summary["frequency_hz"],
                    "ball_diameter_m": summary["ball_diameter_m"],
                    "frequency_per_ball_hz": frequency / summary["balls"],
                    "collision_frequency_hz": frequency,
                    "f": specific_frequency(frequency, summary["balls"], summary["frequency_hz"]),
                    "normal_energy_J": rule["mean_normal_J"] if frequency else np.nan,
                    "tangential_energy_J": rule["mean_tangential_J"] if frequency else np.nan,
                    "ball_ball_share": rule["shares"]["ball_ball"]["count"],
                    "dropped_share": rule["dropped"]["count"],
                }
            )
    return pd.DataFrame(rows).groupby([*CONDITION, *RULE_COLUMNS], sort=True).mean().reset_index()
