"""The style of every figure: column width, units on axes, SVG for print and PNG for the screen, points as a table."""

import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from string import ascii_lowercase
from typing import Any, TypedDict

import matplotlib
import pandas as pd
from matplotlib.axes import Axes

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.collections import Collection, EllipseCollection, PathCollection, QuadMesh
from matplotlib.figure import Figure, SubFigure
from matplotlib.image import AxesImage
from matplotlib.rcsetup import cycler
from matplotlib.transforms import Bbox
from matplotlib.typing import LineStyleType

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
SOFT = "#555555"
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


def no_formula(text: str) -> str:
    """A text of a user for a figure: its `$` is a dollar and begins no formula."""
    return text.replace("$", r"\$")


def panels_for(
    count: int, columns: int, size_in: tuple[float, float], further_in: float = 0.0, **look: Any
) -> tuple[Figure, list[Axes]]:
    """A figure with this number of panels, row by row.

    size_in: width of the figure and height of a row; further_in: height of what is above and below all rows.
    """
    rows = -(-count // columns)
    size = size_in[0], size_in[1] * rows + further_in
    figure, grid = plt.subplots(rows, columns, figsize=size, squeeze=False, **look)
    for axis in grid.flat[count:]:
        axis.remove()
    return figure, list(grid.flat[:count])


def ticks_at(axis: Axes, values: Iterable[float]) -> None:
    """Ticks of the horizontal axis at some values only."""
    places = sorted(set(values))
    axis.set_xticks(places, [f"{place:g}" for place in places])
    axis.minorticks_off()


def show_tolerance(axis: Axes, tolerance: float) -> None:
    """A line at 0 in a grey band of a tolerance to both sides."""
    axis.axhspan(-tolerance, tolerance, color="0.9", linewidth=0)
    axis.axhline(0, color="0.6", linewidth=0.8)


def letter_panels(axes: Iterable[Axes]) -> None:
    """Write (a), (b) and so on over the panels of a figure."""
    for letter, axis in zip(ascii_lowercase, axes, strict=False):
        axis.set_title(f"({letter})", loc="left", fontsize=8)


def write_rows(
    axis: Axes, rows: Iterable[tuple[str, str | None]], widths: tuple[int, int], size: float, room: int
) -> None:
    """Text in two columns: what it is, in grey, and what it says; a row with None in place of text is a heading.

    The second column begins where the longest line of the first ends. widths: characters in a line of each; size [pt],
    smaller where there are more lines than `room`.
    """
    heads: list[str] = []
    names: list[str] = []
    texts: list[str] = []
    for name, text in rows:
        if text is None and heads:
            for lines in (heads, names, texts):
                lines.append("")
        left = [""] if text is None else textwrap.wrap(name, widths[0]) or [""]
        right = [""] if text is None else textwrap.wrap(text, widths[1]) or [""]
        for number in range(max(len(left), len(right))):
            names.append(left[number] if number < len(left) else "")
            texts.append(right[number] if number < len(right) else "")
            heads.append(name if text is None else "")
    axis.axis("off")
    size *= min(1.0, room / max(len(texts), 1))
    look: dict[str, Any] = {"va": "top", "fontsize": size, "linespacing": 1.3}
    joined = [no_formula("\n".join(lines)) for lines in (heads, names, texts)]
    axis.text(0, 1, joined[0], transform=axis.transAxes, fontweight="bold", **look)
    first = axis.text(0, 1, joined[1], transform=axis.transAxes, color=SOFT, **look)
    axis.annotate(joined[2], (1, 1), (size, 0), xycoords=first, textcoords="offset points", **look)


def draw_table(
    axis: Axes, heads: Sequence[str], cells: Sequence[Sequence[str]], size: float, room: float = 1.0
) -> None:
    """A table with thin lines, its heads and its second column, the value, in bold; in the upper `room` of the axis."""
    axis.axis("off")
    widths = [0.28, 0.12, *[0.2] * (len(heads) - 2)]
    shown = [[no_formula(cell) for cell in row] for row in cells]
    table = axis.table(
        shown, colLabels=heads, colWidths=widths, cellLoc="left", colLoc="left", edges="horizontal",
        bbox=Bbox.from_bounds(0, 1 - room, min(1.0, sum(widths)), room),
    )  # fmt: skip
    table.auto_set_font_size(False)
    table.set_fontsize(size)
    for (row, column), cell in table.get_celld().items():
        cell.set(linewidth=0.3, edgecolor=SOFT)
        cell.get_text().set_fontweight("bold" if row == 0 or column == 1 else "normal")


def legend_below(figure: Figure | SubFigure, axes: Iterable[Axes], columns: int, **look: Any) -> None:
    """One legend for all axes, each label once."""
    entries: dict[str, Artist] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns, **look)


def in_pairs(paths: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The SVG and the PNG of each of several figures, whose paths a rule lists one after the other."""
    return zip(paths[::2], paths[1::2], strict=True)


def both_of(name: str | Path) -> tuple[str, str]:
    """The SVG and the PNG of a figure, by the name that a user gives, with one of both endings or without."""
    stem = str(name).removesuffix(".svg").removesuffix(".png")
    return f"{stem}.svg", f"{stem}.png"


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
        # It imports fontTools, for a quarter of a second that most figures do not need.
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        with whole_file(pdf) as partial:
            FigureCanvasPdf(figure).print_pdf(partial, metadata={"CreationDate": None})
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


# panel: number of the axes, from 1; kind: what is drawn; label: its name in the legend; part: number of the line or
# outline, from 1 in each panel; x and y: in the units of the axes; value: the number shown by its colour, if any.
DRAWN_COLUMNS = ["panel", "kind", "label", "part", "x", "y", "value"]


def drawn(figure: Figure) -> pd.DataFrame:
    """Every point of every line, outline, mark and map of a figure, in the order in which they were drawn."""
    parts = []
    for panel, axes in enumerate(figure.axes, start=1):
        # A colour bar only explains the values; matplotlib labels its axes.
        if axes.get_label() != "<colorbar>":
            parts += [(panel, part, *found) for part, found in enumerate(_parts(axes), start=1)]
    if not parts:
        return pd.DataFrame(columns=DRAWN_COLUMNS)
    # One table of all parts: a map has thousands of outlines, and a table of each would take longer than the drawing.
    panels, numbers, artists, points, values = zip(*parts, strict=True)
    x, y = np.concatenate(points).T
    lengths = [len(part) for part in points]
    filled = [np.broadcast_to(value, length) for value, length in zip(values, lengths, strict=True)]
    columns = {
        "panel": np.repeat(panels, lengths),
        "kind": np.repeat([type(artist).__name__ for artist in artists], lengths),
        "label": np.repeat([_label(artist) for artist in artists], lengths),
        "part": np.repeat(numbers, lengths),
        "x": x,
        "y": y,
        "value": np.concatenate(filled),
    }
    return pd.DataFrame(columns)[DRAWN_COLUMNS]


def _label(artist: Artist) -> str:
    """The name in the legend; matplotlib's own names of artists without one begin with an underscore."""
    name = str(artist.get_label())
    return "" if name.startswith("_") else name


def _parts(axes: Axes) -> Iterator[tuple[Artist, np.ndarray, np.ndarray | float]]:
    """Each artist, the points [n, 2] of one of its parts in units of the axes, and a value for each point."""
    for line in axes.lines:
        # Lines over the whole width or height of the axes are guides, not data.
        if line.get_transform() == axes.transData:
            yield line, np.asarray(line.get_xydata(), dtype=float), np.nan
    for image in axes.images:
        yield image, *_of_image(image)
    for collection in axes.collections:
        yield from _of_collection(collection)
    for patch in axes.patches:
        path = patch.get_path().transformed(patch.get_patch_transform())
        yield patch, np.asarray(path.vertices, dtype=float), np.nan


def _of_image(image: AxesImage) -> tuple[np.ndarray, np.ndarray]:
    """The centre of every pixel, and its value."""
    values: np.ndarray = np.ma.filled(np.ma.asarray(image.get_array(), dtype=float), np.nan)
    left, right, bottom, top = image.get_extent()
    rows, columns = values.shape[:2]
    x = left + (np.arange(columns) + 0.5) * (right - left) / columns
    y = bottom + (np.arange(rows) + 0.5) * (top - bottom) / rows
    if image.origin == "upper":
        y = y[::-1]
    across, along = np.meshgrid(x, y)
    return np.column_stack([across.ravel(), along.ravel()]), values.ravel()


def _of_collection(collection: Collection) -> Iterator[tuple[Artist, np.ndarray, np.ndarray | float]]:
    """Markers have a point each, meshes a point for each cell, everything else the points of its outlines."""
    array = collection.get_array()
    values: np.ndarray | float = (
        np.nan if array is None else np.ma.filled(np.ma.asarray(array, dtype=float), np.nan).ravel()
    )
    if isinstance(collection, QuadMesh):
        corners = np.asarray(collection.get_coordinates(), dtype=float)
        centres = (corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]) / 4
        yield collection, centres.reshape(-1, 2), values
    elif isinstance(collection, EllipseCollection | PathCollection):
        yield collection, np.ma.filled(np.ma.asarray(collection.get_offsets(), dtype=float), np.nan), values
    else:
        for number, path in enumerate(collection.get_paths()):
            yield (
                collection,
                np.asarray(path.vertices, dtype=float),
                values if isinstance(values, float) else values[number % len(values)],
            )
