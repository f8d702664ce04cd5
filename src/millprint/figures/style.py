"""The style of every figure: column width, units on axes, SVG for print and PNG for the screen."""

from collections.abc import Iterable
from pathlib import Path
from string import ascii_lowercase
from typing import Any, TypedDict

import matplotlib
import pandas as pd
from matplotlib.axes import Axes

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure, SubFigure
from matplotlib.rcsetup import cycler
from matplotlib.typing import LineStyleType

from millprint.figures.drawn import drawn
from millprint.run.files import whole_file, write_table


class LineLook(TypedDict, total=False):
    """Keywords of a line that several figures share."""

    color: str
    linestyle: LineStyleType
    linewidth: float
    marker: str
    markeredgecolor: str
    markerfacecolor: str
    zorder: float


COLUMN_WIDTH_IN = 85 / 25.4
PAGE_WIDTH_IN = 175 / 25.4
PNG_DPI = 200

# Okabe and Ito's palette, distinguishable with any colour vision.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "v", "<", ">", "P", "X")
PUBLISHED: LineLook = {"marker": "D", "linestyle": "none", "markerfacecolor": "none", "markeredgecolor": "#000000"}

plt.rcParams.update(
    {
        "font.size": 8,
        "axes.prop_cycle": cycler(color=COLOURS),
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "lines.markersize": 4,
        "lines.linewidth": 1.2,
        "figure.constrained_layout.use": True,
        "svg.hashsalt": "millprint",
        "svg.fonttype": "none",
    }
)


def letter_panels(axes: Iterable[Axes]) -> None:
    """Write (a), (b) and so on over the panels of a figure."""
    for letter, axis in zip(ascii_lowercase, axes, strict=False):
        axis.set_title(f"({letter})", loc="left", fontsize=8)


def legend_below(figure: Figure | SubFigure, axes: Iterable[Axes], columns: int, **look: Any) -> None:
    """One legend for all axes, each label once."""
    entries: dict[str, Artist] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns, **look)


def save(
    figure: Figure, svg: str | Path, png: str | Path, pdf: str | Path | None = None, tsv: str | Path | None = None
) -> None:
    """Write a figure as SVG, PNG and optionally PDF, all without a date, and close it.

    tsv: path of a table of the points, for a figure that is not drawn from one table.
    """
    # The layout is computed once, not for each file: it takes longer than the drawing. Figure.savefig would still go
    # through the whole figure for it, so the methods of the canvases are called directly.
    if engine := figure.get_layout_engine():
        engine.execute(figure)
        figure.set_layout_engine("none")
    if tsv:
        write_table(drawn(figure), tsv, digits=6)
    if pdf:
        with whole_file(pdf) as partial:
            figure.savefig(partial, metadata={"CreationDate": None})
    with whole_file(svg) as partial:
        FigureCanvasSVG(figure).print_svg(partial, metadata={"Date": None})
    figure.set_dpi(PNG_DPI)
    with whole_file(png) as partial:
        FigureCanvasAgg(figure).print_png(partial)
    plt.close(figure)


FILL_LABEL = "fill ratio [-]"


def draw_curve(axis: Axes, curves: pd.DataFrame, quantity: str, label: str) -> None:
    """A master curve in its band of a new simulation. curves: fill_ratio, Q, Q_lower and Q_upper of the quantity Q."""
    fill, lower, upper = (curves[name] for name in ("fill_ratio", f"{quantity}_lower", f"{quantity}_upper"))
    axis.fill_between(fill, lower, upper, color=COLOURS[0], alpha=0.15, linewidth=0, label="band of a new simulation")
    axis.plot(fill, curves[quantity], color=COLOURS[0], label=label)
