"""Figures of chapter 2: Pareto plot, interaction plots, residuals, and yields in the literature."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED, plt


def pareto(effects: pd.DataFrame) -> Figure:
    """F of each term, largest first, with the F that would be significant (thesis Fig. 2.3).

    Columns source, F, critical_F, and F_published (empty where Table 2.5 prints none).
    """
    figure, axes = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.75 * COLUMN_WIDTH_IN))
    ranked = effects.sort_values("F")
    place = np.arange(len(ranked))
    axes.barh(place, ranked["F"], height=0.6, color=COLOURS[0], label="computed")
    axes.plot(ranked["F_published"], place, **PUBLISHED, label="from the printed p")
    for row, critical in zip(place, ranked["critical_F"], strict=True):
        label = "significant at 0.05" if row == 0 else None
        axes.plot([critical, critical], [row - 0.4, row + 0.4], color=COLOURS[1], label=label)
    axes.set_yticks(place, ranked["source"])
    axes.set_xlabel("F (-)")
    axes.legend(loc="lower right")
    return figure


def _interaction_panel(axes: Axes, means: pd.DataFrame, labels: dict[str, str]) -> None:
    curve = means["curve"].iloc[0]
    for (level, group), marker in zip(means.groupby("curve_level"), "os^Dv", strict=False):
        group = group.sort_values("axis_level")
        low = group["mean_yield_percent"] - group["lowest_yield_percent"]
        high = group["highest_yield_percent"] - group["mean_yield_percent"]
        bars = axes.errorbar(
            group["axis_level"], group["mean_yield_percent"], [low, high], marker=marker, capsize=2, label=f"{level:g}"
        )
        for whisker in (*bars[1], *bars[2]):
            whisker.set_alpha(0.35)
    axes.set_xticks(sorted(means["axis_level"].unique()))
    axes.set_xlabel(labels[means["axis"].iloc[0]])
    axes.set_ylim(0, 100)
    axes.legend(title=labels[curve], fontsize=7, title_fontsize=7, ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1))


def interactions(means: pd.DataFrame, labels: dict[str, str]) -> Figure:
    """Mean yield for each pair of levels, bars from the lowest to the highest run (thesis Figs 2.4, 2.5).

    `means` is one figure's part of the interaction table; `labels` the axis label of each factor's letter.
    """
    panels = [panel for _, panel in means.groupby(["axis", "curve"], sort=False)]
    width = COLUMN_WIDTH_IN if len(panels) == 1 else PAGE_WIDTH_IN
    figure, grid = plt.subplots(1, len(panels), figsize=(width, 0.9 * COLUMN_WIDTH_IN), squeeze=False, sharey=True)
    for axes, panel in zip(grid[0], panels, strict=True):
        _interaction_panel(axes, panel, labels)
    grid[0, 0].set_ylabel("Yield (%)")
    return figure


def residuals(table: pd.DataFrame) -> Figure:
    """Residuals against normal quantiles and against the fitted yield, of the residual table."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(PAGE_WIDTH_IN, 0.75 * COLUMN_WIDTH_IN))
    left.plot(table["normal_quantile"], table["residual_percent"], "o")
    spread = table["residual_percent"].std()
    ends = np.array([table["normal_quantile"].min(), table["normal_quantile"].max()])
    left.plot(ends, spread * ends, color=COLOURS[1], label="normal, same spread")
    left.set_xlabel("Normal quantile (-)")
    left.set_ylabel("Residual yield (%)")
    left.legend(loc="upper left")
    right.axhline(0, color=COLOURS[6], linewidth=0.6)
    right.plot(table["fitted_percent"], table["residual_percent"], "o")
    for _, run in table.iloc[table["residual_percent"].abs().argsort()[-3:]].iterrows():
        right.annotate(
            f"case {run['case']}", (run["fitted_percent"], run["residual_percent"]), (4, 4), textcoords="offset points"
        )
    right.set_xlabel("Fitted yield (%)")
    right.set_ylabel("Residual yield (%)")
    return figure


def literature(studies: pd.DataFrame) -> Figure:
    """Best reported yield against speed; studies that do not report their speed stand at the side (thesis Fig. 1.4)."""
    figure, (axes, side) = plt.subplots(
        1, 2, figsize=(COLUMN_WIDTH_IN, 0.75 * COLUMN_WIDTH_IN), sharey=True, width_ratios=(4, 1)
    )
    known = studies["speed_rpm"].notna()
    axes.plot(studies["speed_rpm"][known], studies["yield_percent"][known], "o")
    side.plot(np.zeros((~known).sum()), studies["yield_percent"][~known], "s", color=COLOURS[1])
    for _, study in studies.iterrows():
        place, where = (side, 0.0) if np.isnan(study["speed_rpm"]) else (axes, study["speed_rpm"])
        place.annotate(study["reference"], (where, study["yield_percent"]), (4, 3), textcoords="offset points")
    axes.set_xlabel("Rotational speed (rpm)")
    axes.set_ylabel("Reported yield (%)")
    side.set_xticks([0], ["not\nreported"])
    side.set_xlim(-1, 1)
    return figure
