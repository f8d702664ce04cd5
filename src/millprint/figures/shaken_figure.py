"""The figure of the shaken box: energy lost a period over the amplitude, and what must not change it."""

from textwrap import fill

import matplotlib.pyplot as plt
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, MARKERS, PAGE_WIDTH_IN, SOFT, legend_below, letter_panels
from millprint.figures.validation_figures import DEM, LABEL_LETTERS

# How far a prediction may be from the law [-].
AGREED = 0.05
BLACK = COLOURS[-1]
# Of the amplitude over the free gap.
TICKS = (0.2, 0.3, 0.5, 1.0, 2.0, 5.0)


def _draw_changed(axis: Axes, rows: pd.DataFrame) -> None:
    """Open markers for each run with one thing changed; rows: of all these models."""
    for place, (model, own) in enumerate(rows.groupby("model", sort=False)):
        axis.plot(
            own["x"], own["predicted"], MARKERS[1 + place % (len(MARKERS) - 1)], markerfacecolor="none",
            color=COLOURS[1 + place % (len(COLOURS) - 2)], label=str(model).removeprefix(f"{DEM}, "),
        )  # fmt: skip


def plot_shaken(predictions: pd.DataFrame, lost: str, same: str, x_name: str) -> Figure:
    """Energy lost by the DEM with its scatter, with one thing changed, and by the law; and the changes as ratios.

    predictions: columns as in validation.measured; lost, same: the quantities of both panels, the second one only if
    it is in the table; x_name: of the amplitude.
    """
    ratios = predictions[predictions["quantity"] == same]
    panels = 2 if len(ratios) else 1
    figure, grid = plt.subplots(1, panels, figsize=(PAGE_WIDTH_IN, 3.4), squeeze=False)
    axes = list(grid.flat)
    _draw_lost(axes[0], predictions[predictions["quantity"] == lost])
    axes[0].set(ylabel=f"{lost} [-]", ylim=(0, None))
    if panels == 2:
        axes[1].axhspan(1 - AGREED, 1 + AGREED, color=COLOURS[0], alpha=0.12, linewidth=0)
        _draw_changed(axes[1], ratios)
        axes[1].set_ylabel(fill(f"{same} [-]", LABEL_LETTERS))
        letter_panels(axes)
    for axis in axes:
        axis.set(xscale="log", xlabel=x_name)
        axis.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
        axis.minorticks_off()
    for axis, rows in zip(axes, (predictions, ratios), strict=False):
        axis.set_xlim(0.9 * rows["x"].min(), 1.1 * rows["x"].max())
    legend_below(figure, axes, 4)
    return figure


def _draw_lost(axis: Axes, rows: pd.DataFrame) -> None:
    changed = rows["model"].str.startswith(f"{DEM}, ")
    own, lines = rows[rows["model"] == DEM].sort_values("x"), rows[(rows["model"] != DEM) & ~changed]
    for (model, line), style in zip(lines.groupby("model", sort=False), ("-", ":"), strict=False):
        axis.plot(line["x"], line["predicted"], style, color=BLACK, linewidth=1.0, label=model)
    axis.axvline(lines["x"].min(), color=SOFT, linestyle="--", linewidth=0.6)
    _draw_changed(axis, rows[changed])
    spread = [(own["predicted"] - own["lower"]).fillna(0), (own["upper"] - own["predicted"]).fillna(0)]
    axis.errorbar(
        own["x"], own["predicted"], yerr=spread, fmt=MARKERS[0], color=COLOURS[0], capsize=2, label="DEM", zorder=4
    )
