"""The figure of the heat balance over a programme. It draws tables and computes nothing."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, legend_below, letter_panels, plt

BODY_NAMES = {"balls": "balls", "powder": "powder", "jar": "jar"}


def plot_heat(temperatures: pd.DataFrame, limits: pd.DataFrame, title: str) -> Figure:
    """Temperatures of the condition of the largest power over time, and of every condition after long milling.

    temperatures, limits: as of `millprint.dose.heat_table.heat_tables`.
    """
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 2.9))
    strongest = limits.loc[limits["total_W"].idxmax()]
    for number, (body, name) in enumerate(BODY_NAMES.items()):
        colour = COLOURS[number]
        rows = temperatures[(temperatures["condition"] == strongest["condition"]) & (temperatures["body"] == body)]
        left.fill_between(rows["time_h"], rows["lower_degC"], rows["upper_degC"], color=colour, alpha=0.18, linewidth=0)
        left.plot(rows["time_h"], rows["median_degC"], color=colour, label=name)
        lower, median, upper = (limits[f"{body}_steady_degC_{end}"].to_numpy() for end in ("lower", "median", "upper"))
        # Side by side, to distinguish bars at the same power.
        power = limits["total_W"].to_numpy() + 0.012 * strongest["total_W"] * (number - 1)
        right.errorbar(
            power, median, yerr=np.array([median - lower, upper - median]), linestyle="none", capsize=2,
            marker=MARKERS[number], color=colour, linewidth=0.8,
        )  # fmt: skip
    left.axhline(
        strongest["limit_degC"],
        color="black",
        linestyle="--",
        linewidth=0.8,
        label=f"limit ({strongest['limit_body']})",
    )
    left.set(xlabel="time [h]", ylabel="temperature [degC]")
    said = "{ball_diameter_mm:.3g} mm, fill {fill_ratio:g}, {speed_rpm:g} rpm: {total_W:.3g} W".format(**strongest)
    left.set_title(said, fontsize=7, loc="right")
    right.set(
        xlabel="dissipated power [W]",
        ylabel="temperature after\nlong milling [degC]",
        xlim=(0, 1.1 * strongest["total_W"]),
    )
    letter_panels([left, right])
    legend_below(figure, [left], columns=4, fontsize=7)
    figure.suptitle(title, fontsize=8)
    return figure
