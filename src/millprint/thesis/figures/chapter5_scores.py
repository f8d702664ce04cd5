"""Figures of proper scores, calibration and chance. They draw tables and compute nothing."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, PAGE_WIDTH_IN
from millprint.thesis.figures.chapter5_trust import SCHEMES, draw_range, model_title
from millprint.thesis.yields.metrics import LEFT_OUT, NESTED

BOTH = (LEFT_OUT, NESTED)
AXES = {"crps_pp": "CRPS [percentage points]", "log_score": "logarithmic score [nats]"}


def _names(table: pd.DataFrame) -> list[tuple[str, str]]:
    return list(dict.fromkeys(zip(table["model"], table["strategy"], strict=True)))


def plot_scores(scores: pd.DataFrame) -> Figure:
    """CRPS and logarithmic score of every model by both schemes, with ranges over repeats; smaller is better.

    scores: model, strategy, scheme, score, value, error, SPREAD.
    """
    names = _names(scores)
    height = np.arange(len(names))[::-1]
    figure, axes = plt.subplots(1, len(AXES), figsize=(PAGE_WIDTH_IN, 3.2), sharey=True)
    for axis, (score, label) in zip(axes, AXES.items(), strict=True):
        for shift, scheme in zip((0.15, -0.15), BOTH, strict=True):
            title, colour, marker = SCHEMES[scheme]
            rows = scores[(scores["score"] == score) & (scores["scheme"] == scheme)]
            part = rows.set_index(["model", "strategy"]).loc[names]
            style = {"fmt": marker, "color": colour, "capsize": 1.5, "linewidth": 0.8}
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
    names = _names(table)
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
