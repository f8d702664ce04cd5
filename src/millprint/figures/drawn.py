"""The points of a figure as a table, for figures that are not drawn from one table."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection, EllipseCollection, PathCollection, QuadMesh
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

# panel: number of the axes, from 1; kind: what is drawn; label: its name in the legend; part: number of the line or
# outline, from 1 in each panel; x and y: in the units of the axes; value: the number shown by its colour, if any.
DRAWN_COLUMNS = ["panel", "kind", "label", "part", "x", "y", "value"]


def drawn(figure: Figure) -> pd.DataFrame:
    """Every point of every line, outline, mark and map of a figure, in the order in which they were drawn."""
    parts = []
    for panel, axes in enumerate(figure.axes, start=1):
        # A colour bar only explains the values.
        if not hasattr(axes, "_colorbar"):
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
        "kind": np.repeat([_kind(artist) for artist in artists], lengths),
        "label": np.repeat([_label(artist) for artist in artists], lengths),
        "part": np.repeat(numbers, lengths),
        "x": x,
        "y": y,
        "value": np.concatenate(filled),
    }
    return pd.DataFrame(columns)[DRAWN_COLUMNS]


def _kind(artist: Artist) -> str:
    return type(artist).__name__


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
