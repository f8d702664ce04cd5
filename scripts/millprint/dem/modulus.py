"""Power and run time against Young's modulus (thesis Fig. 3.4)."""

import numpy as np
import pandas as pd


def modulus_table(summaries: list[dict]) -> pd.DataFrame:
    """A row a run, sorted by modulus: mean power over the revolutions and two standard deviations of it [W].

    wall_power_W is the work of the walls; power_W is the dissipation in the normal and tangential channels. Steps and
    nanoseconds a ball-step are given beside the wall clock, because times of short runs are noisy.
    """
    rows = []
    for summary in summaries:
        revolutions, frequency = summary["per_revolution"], summary["frequency_hz"]
        dissipated = np.add(revolutions["normal_J"], revolutions["tangential_J"]) * frequency
        wall = np.array(revolutions["wall_J"]) * frequency
        rows.append(
            {
                "young_modulus_gpa": summary["young_modulus_pa"] / 1e9,
                "seed": summary["case"]["seed"],
                "balls": summary["balls"],
                "speed_rpm": summary["case"]["speed_rpm"],
                "power_W": dissipated.mean(),
                "power_two_sigma_W": 2 * dissipated.std(ddof=1),
                "wall_power_W": wall.mean(),
                "wall_power_two_sigma_W": 2 * wall.std(ddof=1),
                "revolutions": len(wall),
                "time_step_s": summary["time_step_s"],
                "rayleigh_fraction": summary["rayleigh_fraction"],
                "simulated_s": summary["steps"] * summary["time_step_s"],
                "steps": summary["steps"],
                "ns_per_ball_step": summary["ns_per_ball_step"],
                "wall_clock_s": summary["wall_clock_s"],
            }
        )
    return pd.DataFrame(rows).sort_values(["young_modulus_gpa", "seed"], ascending=[False, True])
