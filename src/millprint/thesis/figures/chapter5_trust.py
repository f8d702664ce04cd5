"""Figures on the reliability of the yield models, and the next experiments. They draw tables and compute nothing."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED
from millprint.thesis.figures.chapter5_figures import STRATEGIES, interval_errors
from millprint.thesis.yields.metrics import SPREAD
from millprint.thesis.yields.regressors import AVERAGED, CLIMATOLOGY, TITLES

SCHEMES = {
    "locked": ("locked split", COLOURS[1], "s"),
    "random_split": ("random 21/6 splits", COLOURS[4], "v"),
    "nested_cv": ("repeated k-fold", COLOURS[2], "^"),
    "leave_one_out": ("leave-one-out", COLOURS[0], "o"),
}
METHODS = {
    "gaussian": ("own normal distribution", COLOURS[1], "s"),
    "mixture": ("own mixture", COLOURS[2], "^"),
    "cv_plus": ("CV+", COLOURS[0], "o"),
    "errors": ("spread of the training yields", "#666666", "x"),
}
SEARCHES = {
    "expected_improvement": ("expected improvement", COLOURS[0], "-"),
    "highest_mean": ("highest mean", COLOURS[2], "--"),
    "least_squares": ("least squares", COLOURS[1], "-."),
    "ridge": ("ridge", COLOURS[3], "-."),
    "most_balls_longest_time": ("most balls, longest time", COLOURS[4], "--"),
    "random": ("random", "#666666", ":"),
}
PURPOSES = {
    "repeat": ("repeated run", COLOURS[2], "D"),
    "centre": ("centre point", COLOURS[3], "^"),
    "yield": ("for a higher yield", COLOURS[1], "s"),
    "learning": ("for a better model", COLOURS[0], "o"),
}
DESCRIPTORS = {
    (AVERAGED, "power and share"): ("averaged GPR, power and share", COLOURS[2], "^"),
    (AVERAGED, "power alone"): ("averaged GPR, power alone", COLOURS[3], "v"),
    ("gpr_starts two_step", "energies and frequency"): ("two-step GPR", COLOURS[0], "o"),
    ("xgb two_step", "energies and frequency"): ("two-step XGBoost", COLOURS[1], "s"),
}
ADDED = {
    "nothing": "none",
    "other regime": "two of\nthe other",
    "1 of the regime": "one of\nits own",
    "other regime, 1 of the regime": "one own,\ntwo other",
}
R2_FROM = -1.0
# The range of a score over its repeats, with a tick at the median.
RANGE: dict[str, Any] = {"linewidth": 4, "alpha": 0.25, "zorder": 1, "capstyle": "butt"}


def model_title(model: str, strategy: str) -> str:
    """Name of a model in figures."""
    return TITLES[model] if model in (AVERAGED, CLIMATOLOGY) else f"{TITLES[model]}, {STRATEGIES[strategy][0]}"


def draw_range(axis: Axes, rows: pd.DataFrame, height: np.ndarray, colour: str) -> None:
    """The range of every score over its repeats, and a tick at the median; rows: SPREAD."""
    several = (rows["repeats"] > 1).to_numpy()
    low, middle, high = (rows.loc[several, name] for name in ("lowest", "median", "highest"))
    axis.hlines(height[several], low, high, color=colour, **RANGE)
    axis.plot(middle, height[several], "|", color=colour, markersize=7)


def plot_evaluation(scores: pd.DataFrame, claims: pd.DataFrame) -> Figure:
    """R2 of every model by every scheme, with intervals and ranges over repeats, and the printed values of Table 5.6.

    scores: model, strategy, scheme, metric, value, lower, upper, SPREAD, without climatology, whose R2 is 0 by
    definition; claims: id, value.
    """
    published = claims.set_index("id")["value"]
    rows = scores[(scores["metric"] == "r2") & (scores["model"] != CLIMATOLOGY)]
    names = list(dict.fromkeys(zip(rows["model"], rows["strategy"], strict=True)))
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 4.6))
    height = np.arange(len(names))[::-1]
    shifts = np.linspace(0.32, -0.32, len(SCHEMES))
    for shift, (scheme, (title, colour, marker)) in zip(shifts, SCHEMES.items(), strict=True):
        part = rows[rows["scheme"] == scheme].set_index(["model", "strategy"]).loc[names]
        # Values beyond the axis are drawn at its edge.
        inside = part[["value", "lower", "upper", *SPREAD]].clip(lower=R2_FROM)
        draw_range(axis, inside, height + shift, colour)
        axis.errorbar(
            inside["value"],
            height + shift,
            xerr=interval_errors(inside, "value"),
            fmt=marker,
            color=colour,
            capsize=1.5,
            linewidth=0.8,
            label=title,
        )
    claimed = [f"5.{model}.r2" if model == "linear" else f"5.{model}.{strategy}.r2" for model, strategy in names]
    printed = pd.Series(height + shifts[0], index=claimed)[[name in published for name in claimed]]
    axis.plot(published[printed.index].astype(float), printed, label="printed", **PUBLISHED)
    for place in height[:-1]:
        axis.axhline(place - 0.5, color="#DDDDDD", linewidth=0.6, zorder=0)
    axis.set_yticks(height, [model_title(model, strategy) for model, strategy in names])
    axis.tick_params(axis="y", length=0)
    axis.axvline(0, color="#999999", linewidth=0.8, zorder=0)
    axis.set(xlabel="coefficient of determination $R^2$ [-]")
    axis.set(xlim=(R2_FROM - 0.03, 1.03), ylim=(-0.6, len(names) - 0.4))
    figure.legend(loc="outside upper center", ncols=6, fontsize=7, handletextpad=0.3, columnspacing=1.2)
    return figure


def plot_coverage(coverage: pd.DataFrame) -> Figure:
    """Share of left-out runs within their predictive intervals against the nominal level, and the intervals' width.

    coverage: model, strategy, scheme, method, nominal, covered, lower, upper, width_pp. Only leave-one-out is drawn.
    """
    rows = coverage[coverage["scheme"] == "leave_one_out"]
    kinds = list(dict.fromkeys(zip(rows["model"], rows["strategy"], rows["method"], strict=True)))
    levels = sorted(rows["nominal"].unique())
    figure, axes = plt.subplots(1, len(levels) + 1, figsize=(PAGE_WIDTH_IN, 3.4), sharey=True)
    height = np.arange(len(kinds))[::-1]
    table = rows.set_index(["model", "strategy", "method", "nominal"])
    for axis, level in zip(axes[:-1], levels, strict=True):
        axis.axvline(100 * level, color="#999999", linewidth=0.8, zorder=0)
        axis.set(xlabel="runs held [%]", title=f"nominal {100 * level:g} %")
    axes[-1].set(xlabel="mean width [pp]", title=f"{100 * levels[-1]:g} % intervals")
    labelled: set[str] = set()
    for place, kind in zip(height, kinds, strict=True):
        title, colour, marker = METHODS[kind[2]]
        for axis, level in zip(axes[:-1], levels, strict=True):
            row = table.loc[[(*kind, level)]]
            style = {"fmt": marker, "color": colour, "capsize": 1.5, "linewidth": 0.8}
            axis.errorbar(100 * row["covered"], place, xerr=interval_errors(row, "covered", 100), **style)
        label = None if title in labelled else title
        labelled.add(title)
        axes[-1].plot(table.loc[(*kind, levels[-1]), "width_pp"], place, marker, color=colour, label=label)
    axes[-1].set_xlim(0, 105)
    axes[0].set_yticks(height, [model_title(model, strategy) for model, strategy, _ in kinds], fontsize=7)
    for axis in axes:
        axis.title.set_fontsize(8)
        axis.tick_params(axis="y", length=0)
    figure.legend(loc="outside upper center", ncols=3, fontsize=7)
    return figure


def plot_retrospective(table: pd.DataFrame) -> Figure:
    """Share of starts that have found the best run against the runs done, for the first target only.

    table: target, strategy, runs, found, lower, upper.
    """
    table = table[table["target"] == table["target"].iloc[0]]
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.4))
    for strategy, (title, colour, line) in SEARCHES.items():
        rows = table[table["strategy"] == strategy]
        axis.plot(rows["runs"], 100 * rows["found"], line, color=colour, label=title)
        axis.fill_between(rows["runs"], 100 * rows["lower"], 100 * rows["upper"], color=colour, alpha=0.15, linewidth=0)
    axis.set(xlabel="runs done", ylabel="best run found [% of starts]", ylim=(0, 102))
    axis.set_xlim(table["runs"].min(), table["runs"].max())
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.legend(fontsize=7, loc="lower right")
    return figure


def plot_proposals(proposals: pd.DataFrame) -> Figure:
    """The predicted yield of each proposed experiment, with its settings as labels.

    proposals: purpose, rank, the settings, predicted_percent, lower_percent, upper_percent.
    """
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 0.9 + 0.27 * len(proposals)))
    height = np.arange(len(proposals))[::-1]
    for purpose, (title, colour, marker) in PURPOSES.items():
        part = (proposals["purpose"] == purpose).to_numpy()
        rows = proposals[part]
        if rows.empty:
            continue
        errors = interval_errors(rows, "predicted_percent")
        axis.errorbar(
            rows["predicted_percent"], height[part], xerr=errors, fmt=marker, color=colour, capsize=2, label=title
        )
    labels = [
        f"{row.rank}. BPR {row.bpr:g}, ratio {row.molar_ratio:g}, {row.time_h:g} h, {row.speed_rpm:g} rpm, "
        f"fill {100 * row.fill_ratio:g} %"
        for row in proposals.itertuples()
    ]
    axis.set_yticks(height, labels)
    axis.tick_params(axis="y", length=0)
    axis.set(xlabel="predicted yield [%]", xlim=(0, 102))
    figure.legend(loc="outside upper center", ncols=4, fontsize=7)
    return figure


def plot_regimes(summary: pd.DataFrame) -> Figure:
    """RMSE at fill ratios that were left out, against the cases added to the training rows.

    summary: model, descriptors, added, rmse_pp.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.9))
    place = np.arange(len(ADDED))
    for (model, descriptors), (title, colour, marker) in DESCRIPTORS.items():
        rows = summary[(summary["model"] == model) & (summary["descriptors"] == descriptors)].set_index("added")
        axis.plot(place, rows.loc[list(ADDED), "rmse_pp"], marker, linestyle="-", color=colour, label=title)
    axis.set_xticks(place, list(ADDED.values()), fontsize=6)
    axis.set(xlabel="cases at other fill ratios in training", ylabel="RMSE [percentage points]")
    axis.set_ylim(bottom=0)
    figure.legend(loc="outside upper center", ncols=2, fontsize=6, columnspacing=1.0)
    return figure
