"""Figures of thesis chapter 4. They draw tables and compute nothing."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from millprint.dose.energy_doses import AXES, HITS, YIELD
from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, LineLook, legend_below, plt

MODES = {"speed": ("constant speed", COLOURS[0], "o"), "power": ("constant power", COLOURS[1], "s")}
FILL_LABEL = "fill ratio [%]"


def plot_yield(cases: pd.DataFrame, slopes: pd.DataFrame) -> Figure:
    """Fig. 4.3: yield against fill ratio with both lines; the upper axis gives the dissipation ratio.

    cases: Table 4.2 (mode, fill_ratio, ratio, yield_percent); slopes: series, intercept, slope_per_pp, r2.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.9))
    for mode, (title, colour, marker) in MODES.items():
        line = cases[cases["mode"].isin(["reference", mode])].sort_values("fill_ratio")
        axis.plot(100 * line["fill_ratio"], line["yield_percent"], marker, color=colour, label=title)
        for fit in slopes[slopes["series"] == mode].itertuples():
            ends = 100 * line["fill_ratio"].iloc[[0, -1]]
            label = f"{fit.slope_per_pp:.3f} per point, $R^2$ = {fit.r2:.3f}"
            axis.plot(ends, 100 * (fit.intercept + fit.slope_per_pp * ends), color=colour, label=label)
    axis.set(xlabel=FILL_LABEL, ylabel="yield [%]", ylim=(0, 105))
    ratios = cases.drop_duplicates("fill_ratio").sort_values("fill_ratio")
    upper = axis.secondary_xaxis("top")
    upper.set_xticks(100 * ratios["fill_ratio"], [f"{ratio:.2f}" for ratio in ratios["ratio"]])
    upper.set_xlabel("tangential over normal dissipation [-]")
    axis.legend(fontsize=7)
    return figure


def _against_fill(published: pd.DataFrame, ours: pd.DataFrame, quantity: str, label: str) -> Figure:
    """A quantity of the cases against fill ratio: dashed and open of the published curves, solid of ours."""
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.7))
    for source, table in {"published curves": published, "our curves": ours}.items():
        for mode, (title, colour, marker) in MODES.items():
            line = table[table["mode"].isin(["reference", mode])].sort_values("fill_ratio")
            look: LineLook = {"linestyle": "-"} if table is ours else {"linestyle": "--", "markerfacecolor": "none"}
            look |= {"marker": marker, "color": colour}
            axis.plot(100 * line["fill_ratio"], line[quantity], label=f"{title}, {source}", **look)
    axis.set(xlabel=FILL_LABEL, ylabel=label, ylim=(0, None))
    axis.legend(fontsize=7)
    return figure


def plot_specific_yield(published: pd.DataFrame, ours: pd.DataFrame) -> Figure:
    """Fig. 4.4: yield over power against fill ratio, with the powers of the published and of our curves."""
    return _against_fill(published, ours, "specific_yield_per_W", "specific yield [1/W]")


def plot_mass_per_watt(published: pd.DataFrame, ours: pd.DataFrame) -> Figure:
    """Fig. 4.5: converted mass over power against fill ratio, with the powers of the published and of our curves."""
    return _against_fill(published, ours, "mass_per_watt_g_W", "converted mass [g/W]")


SETS = {"screening": "27 screening runs", "regimes": "five cases of chapter 4"}


def plot_doses(doses: pd.DataFrame, curves: pd.DataFrame) -> Figure:
    """Yield against time, each dose, and hits: points, and the law with the smallest AICc; a row per set of runs.

    doses: set, AXES, yield_percent, bpr; curves: set, x (one of AXES), value, yield_percent, model. Colours are
    ball-to-powder ratios.
    """
    figure, axes = plt.subplots(len(SETS), len(AXES), figsize=(PAGE_WIDTH_IN, 3.8), sharey=True)
    ratios = np.unique(doses["bpr"])
    for row, (name, title) in enumerate(SETS.items()):
        runs, lines = doses[doses["set"] == name], curves[curves["set"] == name]
        for axis, (column, label) in zip(axes[row], AXES.items(), strict=True):
            for ratio, group in runs.groupby("bpr"):
                colour = COLOURS[int(np.searchsorted(ratios, ratio))]
                axis.plot(group[column], group[YIELD], "o", markersize=3, color=colour, label=f"BPR {ratio:g}")
            line = lines[lines["x"] == column]
            axis.plot(line["value"], line[YIELD], color="#000000", linewidth=0.8)
            law = line["model"].iloc[0] if len(line) else "all runs as long"
            axis.set_title(law, fontsize=7)
            axis.set_xlim(left=0)
            if column == HITS:
                axis.xaxis.set_major_formatter(EngFormatter(sep=""))
            axis.xaxis.label.set_fontsize(7)
            axis.tick_params(labelsize=6)
            if row == len(SETS) - 1:
                axis.set_xlabel(label)
        axes[row, 0].set_ylabel(f"yield [%]\n{title}", fontsize=7)
        axes[row, 0].set_ylim(0, 100)
    legend_below(figure, axes.flat, columns=len(ratios), fontsize=7)
    return figure
