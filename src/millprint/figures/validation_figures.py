"""Figures of the validation: measured points over predicted curves with their intervals. They compute nothing."""

import math
from textwrap import fill

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.typing import LineStyleType

from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    MARKERS,
    PAGE_WIDTH_IN,
    LineLook,
    legend_below,
    letter_panels,
)

ROW_IN, LEGEND_COLUMNS = 2.4, 3
# Characters per line in the label of an axis.
LABEL_LETTERS = 32
# The model that predicts; all others are reference lines.
DEM = "DEM"
LINES: tuple[LineStyleType, ...] = ("--", "-.", ":", (0, (5, 1, 1, 1)), (0, (1, 1)))


def _draw_models(axis: Axes, lines: pd.DataFrame, models: list[str]) -> None:
    for model, line in lines.groupby("model", sort=False):
        line = line.sort_values("x")
        single = line["x"].isna().all()
        if model != DEM:
            place = models.index(str(model))
            look: LineLook = {"color": COLOURS[1 + place % 5], "linestyle": LINES[place % len(LINES)], "linewidth": 0.9}
            if single:
                axis.axhline(line["predicted"].iloc[0], label=model, **look)
            else:
                axis.plot(line["x"], line["predicted"], label=model, **look)
                if line["lower"].notna().any():
                    axis.fill_between(
                        line["x"], line["lower"], line["upper"], color=look["color"], alpha=0.25, linewidth=0
                    )
        elif single or len(line) == 1:
            x = line["x"].fillna(0.0)
            spread = [(line["predicted"] - line["lower"]).fillna(0), (line["upper"] - line["predicted"]).fillna(0)]
            axis.errorbar(x, line["predicted"], yerr=spread, fmt="s", color=COLOURS[0], capsize=3, label="predicted")
        else:
            if line["lower"].notna().any():
                axis.fill_between(
                    line["x"], line["lower"], line["upper"], color=COLOURS[0], alpha=0.2, linewidth=0,
                    label="interval of the prediction",
                )  # fmt: skip
            axis.plot(line["x"], line["predicted"], "-", marker=".", color=COLOURS[0], label="predicted")


def _draw_points(axis: Axes, points: pd.DataFrame) -> None:
    for place, (kind, group) in enumerate(points.groupby("class", sort=False)):
        x = group["x"].fillna(0.0)
        spread = [
            (group["measured"] - group["measured_lower"]).replace(math.inf, math.nan).fillna(0),
            (group["measured_upper"] - group["measured"]).replace(math.inf, math.nan).fillna(0),
        ]
        axis.errorbar(
            x, group["measured"], yerr=spread, fmt=MARKERS[place % len(MARKERS)], color="#000000",
            markerfacecolor="none" if place else "#000000", markersize=4, elinewidth=0.8, label=kind, zorder=4,
        )  # fmt: skip


def plot_setup(predictions: pd.DataFrame, points: pd.DataFrame, title: str) -> Figure:
    """A panel for each quantity of a set-up.

    predictions: columns as in millprint.validation.inputs; points: as in millprint.validation.measured, of this
    set-up. Bands and bars are intervals.
    """
    quantities = list(dict.fromkeys(predictions["quantity"]))
    models = [model for model in dict.fromkeys(predictions["model"]) if model != DEM]
    columns = min(len(quantities), 2)
    rows = -(-len(quantities) // columns)
    figure, grid = plt.subplots(rows, columns, figsize=(PAGE_WIDTH_IN, ROW_IN * rows + 0.4), squeeze=False)
    axes = list(grid.flat)
    names = dict(zip(points["quantity"], points["x_name"], strict=True))
    shared = next(iter(names.values()), "")
    for axis, quantity in zip(axes, quantities, strict=False):
        lines, measured = predictions[predictions["quantity"] == quantity], points[points["quantity"] == quantity]
        _draw_models(axis, lines, models)
        _draw_points(axis, measured)
        if lines["x"].isna().all():
            axis.set_xticks([])
            axis.set_xlim(-1, 1)
        axis.set(xlabel="" if lines["x"].isna().all() else names.get(quantity, shared))
        axis.set_ylabel(fill(f"{quantity} [{lines['unit'].iloc[0]}]", LABEL_LETTERS))
    for axis in axes[len(quantities) :]:
        axis.set_visible(False)
    letter_panels(axes[: len(quantities)])
    legend_below(figure, axes, LEGEND_COLUMNS)
    figure.suptitle(title, fontsize=9)
    return figure


def plot_bed(balls: pd.DataFrame, radius: float, diameter: float, title: str) -> Figure:
    """The bed of a drum seen along its axis, each ball coloured by its speed.

    balls: x_m, z_m [m] and speed_m_s [m/s]; radius of the drum and diameter of the balls [m].
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, COLUMN_WIDTH_IN))
    size = np.full(len(balls), 1e3 * diameter)
    circles = EllipseCollection(
        size, size, np.zeros(len(balls)), units="xy", offsets=1e3 * balls[["x_m", "z_m"]].to_numpy(),
        offset_transform=axis.transData, array=balls["speed_m_s"].to_numpy(), cmap="viridis", rasterized=True,
    )  # fmt: skip
    axis.add_collection(circles)
    axis.add_patch(Circle((0, 0), 1e3 * radius, fill=False, color="#000000", linewidth=0.9))
    edge = 1.03e3 * radius
    axis.set(xlim=(-edge, edge), ylim=(-edge, edge), aspect="equal", xlabel="x [mm]", ylabel="z [mm]")
    figure.colorbar(circles, ax=axis, label="speed [m/s]", shrink=0.8)
    axis.set_title(title, fontsize=9)
    return figure
