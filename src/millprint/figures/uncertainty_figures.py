"""Figures of what settings change: contact parameters (Sobol indices, intervals), and those of a mill's sweep."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from millprint.config.fingerprint import PARAMETERS
from millprint.dem.convergence import column_of
from millprint.figures.style import (
    COLOURS,
    FILL_LABEL,
    MARKERS,
    PAGE_WIDTH_IN,
    legend_below,
    letter_panels,
    no_formula,
    panels_for,
    plt,
    show_tolerance,
    ticks_at,
)
from millprint.fingerprint.study import DESCRIBED
from millprint.observables.counted_collisions import CHANNELS
from millprint.observables.definitions import CURVES, DESCRIPTORS

COLUMNS = 4


def _panels(table: pd.DataFrame, height: float, sharey: bool = False) -> tuple[Figure, dict[str, Axes]]:
    """A panel for each quantity of a table; height: of a row [inch]."""
    quantities = [name for name in CURVES if (table["quantity"] == name).any()]
    figure, axes = panels_for(len(quantities), COLUMNS, (PAGE_WIDTH_IN, height), sharex=True, sharey=sharey)
    return figure, dict(zip(quantities, axes, strict=True))


def plot_indices(indices: pd.DataFrame, title: str) -> Figure:
    """First-order (full) and total (pale) indices of each parameter, a panel per quantity, a bar per fill ratio.

    indices: as of `uncertainty.indices.sobol_indices`, with fill_ratio and quantity.
    """
    figure, panels = _panels(indices, 2.0, sharey=True)
    fills, names = np.unique(indices["fill_ratio"]), list(PARAMETERS)
    places, width = np.arange(len(names)), 0.8 / len(fills)
    for quantity, axis in panels.items():
        table = indices[indices["quantity"] == quantity]
        for number, fill in enumerate(fills):
            rows = table[table["fill_ratio"] == fill].set_index("parameter").loc[names]
            at = places + (number - (len(fills) - 1) / 2) * width
            errors = np.abs(rows[["total_lower", "total_upper"]].to_numpy() - rows[["total"]].to_numpy()).T
            colour, first = COLOURS[number % len(COLOURS)], rows["first"].clip(lower=0)
            axis.bar(at, rows["total"], width, color=colour, alpha=0.35, yerr=errors, error_kw={"linewidth": 0.6})
            axis.bar(at, first, width, color=colour, label=f"fill {fill:g}")
        axis.set_xticks(places, [PARAMETERS[name].title.replace(", ", ",\n") for name in names], rotation=90)
        axis.tick_params(labelsize=6)
        axis.set_ylim(0, 1.1)
        axis.text(0.98, 0.97, DESCRIPTORS[quantity].title, transform=axis.transAxes, ha="right", va="top", fontsize=7)
    own = list(panels.values())
    for axis in own[::COLUMNS]:
        axis.set_ylabel("Sobol index [-]")
    letter_panels(own)
    legend_below(figure, own, columns=min(6, len(fills)), fontsize=7)
    figure.suptitle(f"{no_formula(title)}: first-order (full) and total (pale) indices", fontsize=8)
    return figure


def plot_intervals(intervals: pd.DataFrame, sets: pd.DataFrame, title: str) -> Figure:
    """Scaled quantities with their intervals by contact parameters against fill ratio, and those of other contact sets.

    intervals, sets: as `uncertainty.intervals.measure` returns them.
    """
    figure, panels = _panels(intervals, 1.9)
    for quantity, axis in panels.items():
        table = intervals[intervals["quantity"] == quantity]
        fills, value = table["fill_ratio"], table["value"].to_numpy()
        axis.fill_between(fills, table["lower"], table["upper"], alpha=0.25, label="by contact parameters")
        scatter = np.exp(1.96 * table["scatter"].to_numpy())
        axis.fill_between(fills, value / scatter, value * scatter, alpha=0.5, label="scatter of one simulation")
        axis.plot(fills, value, label="contact set of the predictions")
        for number, (name, rows) in enumerate(sets[sets["quantity"] == quantity].groupby("contact", sort=False)):
            marker, points = MARKERS[number % len(MARKERS)], rows["factor"].to_numpy() * value
            axis.plot(rows["fill_ratio"], points, marker, color=COLOURS[1 + number], label=f"set {name}")
        axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
        axis.yaxis.label.set_fontsize(7)
    letter_panels(panels.values())
    legend_below(figure, panels.values(), columns=4, fontsize=7)
    figure.suptitle(f"{no_formula(title)}: intervals by contact parameters only", fontsize=8)
    return figure


AXES = {
    "time_step": "time step over that of the sweep [-]",
    "stiffness": "Young's modulus over that of the contact set [-]",
    "facets": "facets over those of the mill [-]",
}


def _plot_setting(axis: Axes, table: pd.DataFrame, setting: str, tolerance: float) -> None:
    show_tolerance(axis, tolerance)
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
    ticks_at(axis, rows["factor"])
    if len(rows) == 1:
        axis.text(0.5, 0.8, "not tested", transform=axis.transAxes, ha="center", color="0.4")


def _plot_window(axis: Axes, window: pd.DataFrame, tolerance: float) -> None:
    show_tolerance(axis, tolerance)
    for name in CHANNELS:
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
