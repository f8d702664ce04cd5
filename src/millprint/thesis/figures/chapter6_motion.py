"""Balls of a roll-out next to the balls of the simulation, at a few moments (Figs 6.9, 6.12, 6.13, 6.18)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from millprint.figures.animation import INK, SPEEDS, WALL_DARK, WALL_LIGHT
from millprint.figures.style import PAGE_WIDTH_IN, plt
from millprint.view.frames import Movie, Picture


def plot_motion(movie: Movie, moments: list[int]) -> Figure:
    """Frames of a movie, a column a moment and a row a panel; colours are speeds relative to the jar."""
    start_s = movie.frames[0].time_s
    sizes = [panel.limits_mm[1] - panel.limits_mm[0] for panel in movie.panels]
    shares = [size[1] / sizes[0][0] for size in sizes]
    width = (PAGE_WIDTH_IN - 1.5) / len(moments)
    figure, panels = plt.subplots(
        len(sizes),
        len(moments),
        figsize=(PAGE_WIDTH_IN, width * sum(shares) + 0.25 * len(sizes) + 0.5),
        height_ratios=shares,
        squeeze=False,
    )
    speeds = Normalize(0, movie.speed_max_m_s)
    for column, moment in enumerate(moments):
        frame = movie.frames[moment]
        panels[0, column].set_title(f"{1e3 * (frame.time_s - start_s):.0f} ms", fontsize=8)
        for axes, panel, picture in zip(panels[:, column], movie.panels, frame.pictures, strict=True):
            _draw(axes, picture, speeds)
            axes.set(xlim=panel.limits_mm[:, 0], ylim=panel.limits_mm[:, 1], aspect="equal")
            axes.tick_params(labelsize=6, length=2, labelbottom=axes in panels[-1], labelleft=column == 0)
    for axes, panel in zip(panels[:, 0], movie.panels, strict=True):
        who, view = panel.title.split(", ")[:2]
        axes.set_ylabel(f"{who}\n{view}\n{panel.labels[1]}", fontsize=7)
    for axes in panels[-1]:
        axes.set_xlabel(movie.panels[-1].labels[0], fontsize=7)
    figure.colorbar(
        ScalarMappable(speeds, SPEEDS), ax=panels, label="speed relative to the jar / m s$^{-1}$", shrink=0.5
    )
    return figure


def _draw(axes: Axes, picture: Picture, speeds: Normalize) -> None:
    grey = WALL_DARK + (WALL_LIGHT - WALL_DARK) * picture.wall_shade
    shades = np.repeat(grey[:, None], 3, axis=1)
    # Hundreds of triangles in shades of grey: as pixels also in a drawing of lines.
    walls = PolyCollection(list(picture.wall_mm), facecolors=shades, edgecolors=shades, linewidths=0.3, rasterized=True)
    axes.add_collection(walls)
    axes.add_collection(LineCollection(list(picture.outline_mm), colors=INK, linewidths=0.5))
    size = 2 * picture.radius_mm
    axes.add_collection(
        EllipseCollection(
            size,
            size,
            np.zeros(len(size)),
            units="xy",
            offsets=picture.centre_mm,
            offset_transform=axes.transData,
            facecolors=SPEEDS(speeds(picture.speed_m_s)),
            edgecolors=INK,
            linewidths=0.3,
        )
    )
