"""Pictures of a mill: its geometry, and a strip of its motion; and of several: their collapse, and a scale-up."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, MARKERS, no_formula, plt
from millprint.view.mill_picture import Look, MillPicture

INK, DARK, LIGHT = "#303030", 0.74, 0.96
# Walls that look round and are flat facets are yellowish, exact ones grey.
FLAT = np.array([1.0, 0.97, 0.84])


def _draw(axes: Axes, look: Look, limits: np.ndarray, linewidth: float = 0.7) -> None:
    """A mill in one view: walls that face the eye, outlines, and the inserts over them."""
    grey = np.repeat((DARK + (LIGHT - DARK) * look.wall_shade)[:, None], 3, axis=1)
    grey[look.wall_is_flat] *= FLAT
    axes.add_collection(PolyCollection(list(look.wall_mm), facecolors=grey, edgecolors=grey, linewidths=0.2))
    axes.add_collection(LineCollection(list(look.outline_mm), colors=INK, linewidths=linewidth))
    axes.add_collection(LineCollection(list(look.insert_mm), colors=COLOURS[0], linewidths=linewidth))
    axes.set(xlim=limits[:, 0], ylim=limits[:, 1], aspect="equal")


def draw_views(axes: list[Axes], picture: MillPicture) -> None:
    """The mill from above and from the side at the start of a turn."""
    for axis, view, look, limits in zip(axes, picture.views, picture.looks, picture.limits_mm, strict=True):
        _draw(axis, look, limits)
        axis.set(xlabel=f"{'xyz'[view.right]} [mm]", ylabel=f"{'xyz'[view.up]} [mm]")
        axis.set_title(view.title, loc="left", fontsize=7)


def plot_geometry(picture: MillPicture) -> Figure:
    """The mill from above and from the side: exact walls grey, facets that look round yellowish, inserts blue."""
    figure, axes = plt.subplots(2, 1, figsize=(COLUMN_WIDTH_IN, 4.6))
    draw_views(list(axes), picture)
    figure.suptitle(f"{no_formula(picture.title)}\n{picture.walls}", fontsize=8)
    return figure


def draw_strip(axes: list[Axes], picture: MillPicture) -> None:
    """Moments of a turn side by side, with the path of a marked point of the wall."""
    for number, (axis, look) in enumerate(zip(axes, picture.strip, strict=True)):
        _draw(axis, look, picture.strip_limits_mm, 0.4)
        axis.plot(*picture.path_mm.T, color=COLOURS[1], linewidth=0.5)
        axis.plot(*look.mark_mm, "o", color=COLOURS[1], markersize=2.5)
        axis.set_title(f"{number / len(picture.strip):.3g} turn", fontsize=6, pad=2)
        axis.tick_params(labelsize=5, length=2)
        if number % 4:
            axis.set_yticklabels([])
        else:
            axis.set_ylabel(f"{'xyz'[picture.strip_view.up]} [mm]", fontsize=6)
        if number < len(axes) - 4:
            axis.set_xticklabels([])
        else:
            axis.set_xlabel(f"{'xyz'[picture.strip_view.right]} [mm]", fontsize=6)


def plot_motion(picture: MillPicture) -> Figure:
    """Eight moments of one turn of the mill, in the view that shows most of its motion."""
    size = np.ptp(picture.strip_limits_mm, axis=0)
    height = min(6.5, 0.8 + 2 * (COLUMN_WIDTH_IN - 0.6) / 4 * size[1] / size[0])
    figure, axes = plt.subplots(2, 4, figsize=(COLUMN_WIDTH_IN, max(height, 1.6)))
    draw_strip(list(axes.flat), picture)
    figure.suptitle(f"{no_formula(picture.title)}, {picture.strip_view.title}", fontsize=7)
    return figure


def plot_collapse(collapse: pd.DataFrame, largest: float) -> Figure:
    """Spread of the power per ball of several mills: before scaling, by the thesis's exponents, by their own.

    collapse: power_spread_before, power_spread_thesis, power_spread_own of each mill; largest: largest spread that
    counts as a collapse.
    """
    figure, axis = plt.subplots(figsize=(COLUMN_WIDTH_IN, 0.9 + 0.3 * len(collapse)))
    places = np.arange(len(collapse))
    for number, (name, label) in enumerate(
        {"before": "before scaling", "thesis": "by the scaling law", "own": "exponents of its own"}.items()
    ):
        axis.plot(collapse[f"power_spread_{name}"], places, MARKERS[number], color=COLOURS[number], label=label)
    axis.axvline(largest, color="0.5", linestyle="--", linewidth=0.8)
    axis.set(xlabel="spread of log power per ball [-]", xscale="log")
    axis.set_yticks(places, collapse["mill"])
    axis.set_ylabel("mill")
    axis.invert_yaxis()
    figure.legend(loc="outside lower center", ncols=2, fontsize=7)
    return figure


def plot_scale_up(sheet: pd.DataFrame) -> Figure:
    """Ratios of the large mill to the small one, for each way to run it: what stays the same and what changes."""
    quantities = {
        "weighted_normal_energy_ratio": "weighted normal\nenergy E*n",
        "weighted_normal_frequency_ratio": "weighted normal\nfrequency f*n",
        "specific_power_ratio": "power over mass\nof balls",
    }
    figure, axes = plt.subplots(len(quantities), 1, figsize=(COLUMN_WIDTH_IN, 4.4), sharex=True)
    places = np.arange(len(sheet))
    for axis, (quantity, label) in zip(axes, quantities.items(), strict=True):
        axis.axhline(1.0, color="0.5", linewidth=0.8)
        axis.plot(places, sheet[quantity], "o", color=COLOURS[0])
        axis.set(ylabel=f"{label} [-]", yscale="log")
        axis.yaxis.label.set_fontsize(7)
    axes[-1].set_xticks(places, [name.replace(", ", ",\n") for name in sheet["keeps"]], fontsize=6)
    axes[-1].set_xlabel("what is kept")
    return figure
