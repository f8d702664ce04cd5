"""Pictures of a mill: its geometry, and a strip of its motion."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from millprint.figures.style import COLOURS, COLUMN_WIDTH_IN, plt
from millprint.view.mill_picture import Look, MillPicture

INK, DARK, LIGHT = "#303030", 0.74, 0.96


def _draw(axes: Axes, look: Look, limits: np.ndarray, linewidth: float = 0.7) -> None:
    """A mill in one view: walls that face the eye, outlines, and the inserts over them."""
    grey = np.repeat((DARK + (LIGHT - DARK) * look.wall_shade)[:, None], 3, axis=1)
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
    """The mill from above and from the side, inserts in blue."""
    figure, axes = plt.subplots(2, 1, figsize=(COLUMN_WIDTH_IN, 4.6))
    draw_views(list(axes), picture)
    figure.suptitle(picture.title, fontsize=8)
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
    figure.suptitle(f"{picture.title}, {picture.strip_view.title}", fontsize=7)
    return figure
