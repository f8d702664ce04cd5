"""Figures of the validation: measured points over predicted curves with their intervals, and the shaken box."""

import math
from collections.abc import Mapping
from textwrap import fill

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.typing import LineStyleType

from millprint.figures.style import (
    COLOURS,
    COLUMN_WIDTH_IN,
    MARKERS,
    PAGE_WIDTH_IN,
    SOFT,
    LineLook,
    legend_below,
    letter_panels,
    no_formula,
    panels_for,
    ticks_at,
)
from millprint.mill.vessel import Vessel

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


def plot_setup(
    predictions: pd.DataFrame, points: pd.DataFrame, title: str, x_names: Mapping[str, str] | None = None
) -> Figure:
    """A panel for each quantity of a set-up.

    predictions, points: columns as in validation.measured, of this set-up; x_names: of a quantity that was not
    measured. Bands and bars are intervals.
    """
    quantities = list(dict.fromkeys(predictions["quantity"]))
    models = [model for model in dict.fromkeys(predictions["model"]) if model != DEM]
    figure, axes = panels_for(len(quantities), min(len(quantities), 2), (PAGE_WIDTH_IN, ROW_IN), 0.4)
    names = dict(zip(points["quantity"], points["x_name"], strict=True))
    shared = next(iter(names.values()), "")
    names = {**(x_names or {}), **names}
    for axis, quantity in zip(axes, quantities, strict=True):
        lines, measured = predictions[predictions["quantity"] == quantity], points[points["quantity"] == quantity]
        _draw_models(axis, lines, models)
        _draw_points(axis, measured)
        if lines["x"].isna().all():
            axis.set_xticks([])
            axis.set_xlim(-1, 1)
        axis.set(xlabel="" if lines["x"].isna().all() else no_formula(names.get(quantity, shared)))
        axis.set_ylabel(fill(f"{quantity} [{lines['unit'].iloc[0]}]", LABEL_LETTERS))
    letter_panels(axes)
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


COLUMNS = 3
WALL = "#d8d8d8"


def _outline(vessel: Vessel, axis: str) -> np.ndarray:
    """The outline (k, 2) of the drum's cross-section [m], x to the right and z up, from one of its ends."""
    across = "xyz".index(axis)
    end = max((facet for facet in vessel.facets if abs(facet.normal[across]) > 0.99), key=lambda facet: facet.area)
    return end.loops[0][:, [0, 2]]


def _turned(points: np.ndarray, angle_deg: float) -> np.ndarray:
    """Points (k, 2) turned clockwise."""
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.column_stack([cos * points[:, 0] + sin * points[:, 1], cos * points[:, 1] - sin * points[:, 0]])


def plot_charge(balls: pd.DataFrame, curve: pd.DataFrame, vessel: Vessel, axis: str, unit: str) -> Figure:
    """A panel for each speed: balls coloured by their speed, walls, and lines from the axis to toe and shoulder.

    balls: of `validation.tumbling_runs`; curve: of `validation.tumbling.intervals`; unit: of the
    speed. The drum turns clockwise.
    """
    runs = balls.groupby("run", sort=False)
    columns, width = min(COLUMNS, len(runs)), PAGE_WIDTH_IN / COLUMNS
    figure, panels = panels_for(len(runs), columns, (columns * width, width + 0.2), 0.5)
    outline = _outline(vessel, axis)
    radius = np.linalg.norm(outline, axis=1).max()
    fastest = balls["ball_speed_m_s"].quantile(0.98)
    drawn = None
    for panel, (_, own) in zip(panels, runs, strict=True):
        first = own.iloc[0]
        panel.add_patch(Circle((0, 0), 1.06 * radius, facecolor=WALL, edgecolor="#606060", linewidth=0.6))
        hollow = _turned(outline, first["angle_deg"])
        panel.add_patch(Polygon(hollow, facecolor="#ffffff", edgecolor="#606060", linewidth=0.6))
        circles = [Circle((x, z), d / 2) for x, z, d in own[["x_m", "z_m", "diameter_m"]].to_numpy()]
        drawn = PatchCollection(circles, edgecolor="#303030", linewidth=0.3, cmap="viridis")
        drawn.set_array(own["ball_speed_m_s"].to_numpy())
        drawn.set_clim(0, fastest)
        panel.add_collection(drawn)
        found = curve[(curve["number"] == first["number"]) & np.isclose(curve["speed"], first["speed"])].iloc[0]
        for name, column, style in (("toe", "toe_deg", "--"), ("shoulder", "shoulder_deg", "-")):
            if found[column] == found[column]:
                end = 1.06 * radius * np.array([np.sin(np.radians(found[column])), np.cos(np.radians(found[column]))])
                panel.plot([0, end[0]], [0, end[1]], style, color=COLOURS[1], linewidth=1.0, label=name)
        panel.text(
            0.5, 0.0, f"{first['speed']:g} {unit},\n{first['number']:g} balls", ha="center", va="top", fontsize=7,
            transform=panel.transAxes,
        )  # fmt: skip
        panel.set(xlim=(-1.08 * radius, 1.08 * radius), ylim=(-1.08 * radius, 1.08 * radius), aspect="equal")
        panel.axis("off")
    letter_panels(panels)
    if drawn is not None:
        figure.colorbar(
            drawn, ax=panels, location="bottom", shrink=0.5, fraction=0.05, aspect=40, label="speed of a ball [m/s]"
        )
    return figure


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
        ticks_at(axis, TICKS)
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
