"""Pictures of the charge of a tumbling mill, seen along its axis. They compute nothing."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from millprint.figures.style import COLOURS, PAGE_WIDTH_IN, letter_panels
from millprint.mill.vessel import Vessel

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

    balls: of `millprint.validation.tumbling_runs`; curve: of `millprint.validation.tumbling.intervals`; unit: of the
    speed. The drum turns clockwise.
    """
    runs = balls.groupby("run", sort=False)
    columns = min(COLUMNS, len(runs))
    rows = -(-len(runs) // columns)
    width = PAGE_WIDTH_IN / COLUMNS
    figure, grid = plt.subplots(rows, columns, figsize=(columns * width, rows * (width + 0.2) + 0.5), squeeze=False)
    outline = _outline(vessel, axis)
    radius = np.linalg.norm(outline, axis=1).max()
    fastest = balls["ball_speed_m_s"].quantile(0.98)
    drawn = None
    for panel, (_, own) in zip(grid.flat, runs, strict=False):
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
    for panel in list(grid.flat)[len(runs) :]:
        panel.set_visible(False)
    letter_panels(list(grid.flat)[: len(runs)])
    if drawn is not None:
        figure.colorbar(
            drawn, ax=grid, location="bottom", shrink=0.5, fraction=0.05, aspect=40, label="speed of a ball [m/s]"
        )
    return figure
