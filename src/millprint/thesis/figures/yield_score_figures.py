"""Figures of chapter 5: how far the yield models can be trusted. Scores, coverage, calibration, shuffled yields."""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN, PUBLISHED
from millprint.thesis.figures.chapter5_figures import BARS, interval_errors, model_title, names_of
from millprint.thesis.yields.metrics import LEFT_OUT, NESTED, SPREAD
from millprint.thesis.yields.regressors import CLIMATOLOGY

SCHEMES = {
    "locked": ("locked split", COLOURS[1], "s"),
    "random_split": ("random 21/6 splits", COLOURS[4], "v"),
    "nested_cv": ("repeated k-fold", COLOURS[2], "^"),
    "leave_one_out": ("leave-one-out", COLOURS[0], "o"),
}
METHODS = {
    "gaussian": ("own normal distribution", COLOURS[1], "s"),
    "mixture": ("own mixture", COLOURS[2], "^"),
    "logit": ("Student's t of the logit", COLOURS[3], "D"),
    "cv_plus": ("CV+", COLOURS[0], "o"),
    "errors": ("spread of the training yields", "#666666", "x"),
}
R2_FROM = -1.0
# The range of a score over its repeats, with a tick at the median.
RANGE: dict[str, Any] = {"linewidth": 4, "alpha": 0.25, "zorder": 1, "capstyle": "butt"}


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
    names = names_of(rows)
    figure, axis = plt.subplots(figsize=(PAGE_WIDTH_IN, 4.6))
    height = np.arange(len(names))[::-1]
    shifts = np.linspace(0.32, -0.32, len(SCHEMES))
    for shift, (scheme, (title, colour, marker)) in zip(shifts, SCHEMES.items(), strict=True):
        part = rows[rows["scheme"] == scheme].set_index(["model", "strategy"]).reindex(names)
        # Values beyond the axis are drawn at its edge.
        inside = part[["value", "lower", "upper", *SPREAD]].clip(lower=R2_FROM)
        draw_range(axis, inside, height + shift, colour)
        errors = interval_errors(inside, "value")
        axis.errorbar(inside["value"], height + shift, xerr=errors, fmt=marker, color=colour, label=title, **BARS)
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

    coverage: model, strategy, scheme, method, nominal, covered, lower, upper, width_pp. Only repeated k-fold is drawn.
    """
    rows = coverage[coverage["scheme"] == NESTED]
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
            errors = interval_errors(row, "covered", 100)
            axis.errorbar(100 * row["covered"], place, xerr=errors, fmt=marker, color=colour, **BARS)
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


BOTH = (LEFT_OUT, NESTED)
AXES = {"crps_pp": "CRPS [percentage points]", "log_score": "logarithmic score [nats]"}


def plot_scores(scores: pd.DataFrame) -> Figure:
    """CRPS and logarithmic score of every model by both schemes, with ranges over repeats; smaller is better.

    scores: model, strategy, scheme, score, value, error, SPREAD.
    """
    names = names_of(scores)
    height = np.arange(len(names))[::-1]
    figure, axes = plt.subplots(1, len(AXES), figsize=(PAGE_WIDTH_IN, 3.2), sharey=True)
    for axis, (score, label) in zip(axes, AXES.items(), strict=True):
        for shift, scheme in zip((0.15, -0.15), BOTH, strict=True):
            title, colour, marker = SCHEMES[scheme]
            rows = scores[(scores["score"] == score) & (scores["scheme"] == scheme)]
            part = rows.set_index(["model", "strategy"]).loc[names]
            style = {"fmt": marker, "color": colour, **BARS}
            shown = title if score == "crps_pp" else None
            draw_range(axis, part, height + shift, colour)
            axis.errorbar(part["value"], height + shift, xerr=part["error"], label=shown, **style)
        axis.set(xlabel=label)
        axis.tick_params(axis="y", length=0)
    axes[0].set_yticks(height, [model_title(*name) for name in names])
    figure.legend(loc="outside upper center", ncols=2, fontsize=7)
    return figure


def plot_pit(table: pd.DataFrame) -> Figure:
    """Histogram of the probability integral of every model by both schemes; flat if predictive distributions are right.

    table: model, strategy, scheme, from, to, share, expected, SPREAD, whose range is shaded.
    """
    names = names_of(table)
    columns = 4
    lines = -(-len(names) // columns)
    size = (PAGE_WIDTH_IN, 1.3 * lines + 0.4)
    figure, axes = plt.subplots(lines, columns, figsize=size, sharex=True, sharey=True, squeeze=False)
    for axis in axes.flat[len(names) :]:
        axis.remove()
    for axis, (model, strategy) in zip(axes.flat, names, strict=False):
        own = table[(table["model"] == model) & (table["strategy"] == strategy)]
        for scheme in BOTH:
            title, colour, _ = SCHEMES[scheme]
            rows = own[own["scheme"] == scheme]
            edges = [*rows["from"], rows["to"].iloc[-1]]
            axis.stairs(rows["share"], edges, color=colour, label=title if axis is axes[0, 0] else None)
            if (rows["repeats"] > 1).all():
                axis.stairs(rows["highest"], edges, baseline=rows["lowest"], fill=True, color=colour, alpha=0.2)
        axis.axhline(own["expected"].iloc[0], color="#999999", linewidth=0.8, zorder=0)
        axis.set_title(model_title(model, strategy), fontsize=7)
    axes[0, 0].set(xlim=(0, 1), ylim=(0, None))
    figure.supxlabel("probability integral of the measured yield [-]", fontsize=8)
    figure.supylabel("share of runs [-]", fontsize=8)
    figure.legend(loc="outside upper center", ncols=2, fontsize=7)
    return figure


def plot_permutations(table: pd.DataFrame) -> Figure:
    """Scores of the averaged model on shuffled yields, and on the measured ones.

    table: permutation (0: measured), r2.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 2.2))
    shuffled, measured = table[table["permutation"] > 0]["r2"], table[table["permutation"] == 0]["r2"].iloc[0]
    axis.hist(shuffled, bins=25, color="#999999", label="shuffled yields")
    axis.axvline(measured, color=COLOURS[1], label="measured yields")
    axis.set(xlabel="$R^2$ by leave-one-out in closed form [-]", ylabel="shuffles", xlim=(None, 1))
    axis.legend(fontsize=7, loc="upper left")
    return figure
