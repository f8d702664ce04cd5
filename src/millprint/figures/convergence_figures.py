"""The figure of a study of a mill's settings. It draws tables and computes nothing."""

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from millprint.dem.convergence import column_of
from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, legend_below, letter_panels
from millprint.fingerprint.columns import DESCRIPTORS
from millprint.fingerprint.study import DESCRIBED, POWERS

AXES = {
    "time_step": "time step over that of the sweep [-]",
    "stiffness": "Young's modulus over that of the contact set [-]",
    "facets": "facets over those of the mill [-]",
}


def _plot_setting(axis: Axes, table: pd.DataFrame, setting: str, tolerance: float) -> None:
    axis.axhspan(-tolerance, tolerance, color="0.9", linewidth=0)
    axis.axhline(0, color="0.6", linewidth=0.8)
    rows = table[table["setting"].isin([setting, "reference"])].sort_values("factor")
    for place, name in enumerate(DESCRIBED):
        # Side by side, to distinguish bars at the same factor.
        factors = rows["factor"] * (1 + 0.03 * (place - 2))
        changes, errors = (rows[column_of(name, f"deviation{kind}_percent")] for kind in ("", "_se"))
        axis.errorbar(
            factors, changes, yerr=errors, capsize=2, marker=MARKERS[place], color=COLOURS[place],
            label=DESCRIPTORS[name].title,
        )  # fmt: skip
    axis.set(xscale="log", xlabel=AXES[setting], ylabel="change [%]")
    axis.set_xticks(rows["factor"], [f"{factor:g}" for factor in rows["factor"]])
    axis.minorticks_off()
    if len(rows) == 1:
        axis.text(0.5, 0.8, "not tested", transform=axis.transAxes, ha="center", color="0.4")


def _plot_window(axis: Axes, window: pd.DataFrame, tolerance: float) -> None:
    axis.axhspan(-tolerance, tolerance, color="0.9", linewidth=0)
    axis.axhline(0, color="0.6", linewidth=0.8)
    for name in POWERS:
        place = DESCRIBED.index(f"{name}_power_W")
        axis.errorbar(
            window["turns"], window[f"{name}_power_change_percent"],
            yerr=window[f"{name}_power_change_se_percent"], capsize=2, marker=MARKERS[place], color=COLOURS[place],
        )  # fmt: skip
    axis.set(xlabel="first turns of the window [-]", ylabel="mean power against that\nof the whole window [%]")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))


def plot_study(table: pd.DataFrame, window: pd.DataFrame, tolerance: float) -> Figure:
    """Changes of the descriptors over time step, stiffness and facets, and how the powers settle over the window.

    table, window: study.tsv and window.tsv; tolerance: the grey band [%]. Bars are one standard error.
    """
    figure, axes = plt.subplots(2, 2, figsize=(PAGE_WIDTH_IN, 4.6))
    for axis, setting in zip(axes.flat, AXES, strict=False):
        _plot_setting(axis, table, setting, tolerance)
    _plot_window(axes.flat[3], window, tolerance)
    letter_panels(axes.flat)
    legend_below(figure, axes.flat[:1], 3)
    return figure
