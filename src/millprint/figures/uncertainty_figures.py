"""Figures of what settings change: contact parameters (Sobol indices, intervals), and those of a mill's sweep."""

from typing import Any

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
    plt,
)
from millprint.fingerprint.study import DESCRIBED, POWERS
from millprint.observables.definitions import CURVES, DESCRIPTORS

COLUMNS = 4


def _panels(
    table: pd.DataFrame, height: float, sharey: bool = False
) -> tuple[Figure, list[tuple[Any, str]], np.ndarray]:
    """A panel for each quantity of a table; height: of a row [inch]."""
    quantities = [name for name in CURVES if (table["quantity"] == name).any()]
    rows = -(-len(quantities) // COLUMNS)
    figure, axes = plt.subplots(
        rows, COLUMNS, figsize=(PAGE_WIDTH_IN, height * rows), sharex=True, squeeze=False, sharey=sharey
    )
    for axis in axes.flat[len(quantities) :]:
        axis.axis("off")
    return figure, list(zip(axes.flat, quantities, strict=False)), axes


def plot_indices(indices: pd.DataFrame, title: str) -> Figure:
    """First-order (full) and total (pale) indices of each parameter, a panel per quantity, a bar per fill ratio.

    indices: as of `uncertainty.indices.sobol_indices`, with fill_ratio and quantity.
    """
    figure, panels, axes = _panels(indices, 2.0, sharey=True)
    fills, names = np.unique(indices["fill_ratio"]), list(PARAMETERS)
    places, width = np.arange(len(names)), 0.8 / len(fills)
    for axis, quantity in panels:
        table = indices[indices["quantity"] == quantity]
        for number, fill in enumerate(fills):
            rows = table[table["fill_ratio"] == fill].set_index("parameter").loc[names]
            at = places + (number - (len(fills) - 1) / 2) * width
            colour = COLOURS[number % len(COLOURS)]
            errors = np.abs(rows[["total_lower", "total_upper"]].to_numpy() - rows[["total"]].to_numpy()).T
            bars = {"width": width, "color": colour}
            axis.bar(at, rows["total"], alpha=0.35, yerr=errors, error_kw={"linewidth": 0.6}, **bars)
            axis.bar(at, rows["first"].clip(lower=0), label=f"fill {fill:g}", **bars)
        axis.set_xticks(places, [PARAMETERS[name].title.replace(", ", ",\n") for name in names], rotation=90)
        axis.tick_params(labelsize=6)
        axis.set_ylim(0, 1.1)
        axis.text(0.98, 0.97, DESCRIPTORS[quantity].title, transform=axis.transAxes, ha="right", va="top", fontsize=7)
    for axis in axes[:, 0]:
        axis.set_ylabel("Sobol index [-]")
    own = [axis for axis, _ in panels]
    letter_panels(own)
    legend_below(figure, own, columns=min(6, len(fills)), fontsize=7)
    figure.suptitle(f"{no_formula(title)}: first-order (full) and total (pale) indices", fontsize=8)
    return figure


def plot_intervals(intervals: pd.DataFrame, sets: pd.DataFrame, title: str) -> Figure:
    """Scaled quantities with their intervals by contact parameters against fill ratio, and those of other contact sets.

    intervals, sets: as `uncertainty.intervals.measure` returns them.
    """
    figure, panels, _ = _panels(intervals, 1.9)
    for axis, quantity in panels:
        table = intervals[intervals["quantity"] == quantity]
        fills, value = table["fill_ratio"], table["value"].to_numpy()
        axis.fill_between(fills, table["lower"], table["upper"], alpha=0.25, label="by contact parameters")
        scatter = np.exp(1.96 * table["scatter"].to_numpy())
        axis.fill_between(fills, value / scatter, value * scatter, alpha=0.5, label="scatter of one simulation")
        axis.plot(fills, value, label="contact set of the predictions")
        for number, (name, rows) in enumerate(sets[sets["quantity"] == quantity].groupby("contact", sort=False)):
            look = {"linestyle": "none", "marker": MARKERS[number % len(MARKERS)], "color": COLOURS[1 + number]}
            axis.plot(rows["fill_ratio"], rows["factor"].to_numpy() * value, label=f"set {name}", **look)
        axis.set(xlabel=FILL_LABEL, ylabel=DESCRIPTORS[quantity].label, ylim=(0, None))
        axis.yaxis.label.set_fontsize(7)
    own = [axis for axis, _ in panels]
    letter_panels(own)
    legend_below(figure, own, columns=4, fontsize=7)
    figure.suptitle(f"{no_formula(title)}: intervals by contact parameters only", fontsize=8)
    return figure


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
