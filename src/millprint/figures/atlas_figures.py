"""A map of what a mill does over two of its settings or dimensions, by the atlas."""

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from millprint.atlas.atlas_model import KindModel
from millprint.atlas.estimate_mill import estimate_many
from millprint.atlas.kind_groups import SETTINGS
from millprint.figures.style import PAGE_WIDTH_IN, plt
from millprint.run.numbers import three

# Points of a map along each axis; contours.
POINTS, LEVELS = 60, 8
# Letters of a label.
WIDTH = 36
PANELS = ("power per mass of balls [W/kg]", "a strong hit, E*n [mJ]")


def plot_map(model: KindModel, condition: Mapping[str, float], bounds: Mapping[str, tuple[float, float]]) -> Figure:
    """Contours of PANELS over two of the condition's values, from and to `bounds`, the others kept.

    White where the atlas says nothing, and for hits where there are hardly any.
    """
    (across, up), axes = bounds, [np.linspace(*ends, POINTS) for ends in bounds.values()]
    x, y = (own.ravel() for own in np.meshgrid(*axes))
    asked: dict[str, Any] = {**condition, across: x, up: y}
    logs, hits = estimate_many(model, asked)
    ball_kg = asked["density_kg_m3"] * np.pi / 6 * (asked["ball_diameter_mm"] / 1e3) ** 3
    shown = [np.exp(logs["wall_power_W"]) / (asked["number"] * ball_kg),
             np.where(hits, 1e3 * np.exp(logs["weighted_normal_energy_J"]), np.nan)]  # fmt: skip
    words = {own.name: textwrap.fill(own.means, WIDTH) for own in (*model.kind.dimensions, *SETTINGS)}
    figure, panels = plt.subplots(1, len(PANELS), figsize=(PAGE_WIDTH_IN, 2.8), layout="constrained")
    for axis, title, values in zip(panels, PANELS, shown, strict=True):
        known = values[np.isfinite(values)]
        levels = np.geomspace(known.min(), known.max(), LEVELS + 2)[1:-1] if known.size else np.empty(0)
        drawn = axis.contour(*axes, np.ma.masked_invalid(values.reshape(POINTS, POINTS)), levels=levels, norm="log")
        axis.clabel(drawn, fontsize=6, fmt=three)
        axis.set(xlabel=words[across], ylabel=words[up], title=title)
        axis.plot(condition[across], condition[up], "k+")
    return figure
