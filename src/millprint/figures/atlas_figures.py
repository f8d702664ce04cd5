"""A map of what a mill does over two of its settings or dimensions, by the atlas."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from millprint.atlas.atlas_model import KindModel
from millprint.atlas.estimate_mill import estimate_many
from millprint.figures.style import PAGE_WIDTH_IN, plt

# Points of a map along each axis.
POINTS = 60
PANELS = ("power per mass of balls [W/kg]", "a strong hit, E*n [mJ]")


def plot_map(model: KindModel, condition: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]) -> Figure:
    """Contours of PANELS over two of the condition's values, from and to `bounds`, the others kept.

    White where the atlas says nothing, and for hits where there are hardly any.
    """
    (across, up), axes = bounds, [np.geomspace(*ends, POINTS) for ends in bounds.values()]
    x, y = (own.ravel() for own in np.meshgrid(*axes))
    asked: dict[str, Any] = {**condition, across: x, up: y}
    logs, hits = estimate_many(model, asked)
    ball_kg = asked["density_kg_m3"] * np.pi / 6 * (asked["ball_diameter_mm"] / 1e3) ** 3
    shown = [np.exp(logs["wall_power_W"]) / (asked["number"] * ball_kg),
             np.where(hits, 1e3 * np.exp(logs["weighted_normal_energy_J"]), np.nan)]  # fmt: skip
    figure, panels = plt.subplots(1, len(PANELS), figsize=(PAGE_WIDTH_IN, 2.8), layout="constrained")
    for axis, title, values in zip(panels, PANELS, shown, strict=True):
        drawn = axis.contour(*axes, np.ma.masked_invalid(values.reshape(POINTS, POINTS)), levels=10)
        axis.clabel(drawn, fontsize=6)
        axis.set(xscale="log", yscale="log", xlabel=across, ylabel=up, title=title)
        axis.plot(condition[across], condition[up], "k+")
    return figure
