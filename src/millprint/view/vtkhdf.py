"""Transient VTKHDF files of type PolyData, as ParaView reads them (VTK's file format specification, version 2.0).

Points, cells and their data are stored step after step; the group Steps has where each step begins. If the points of a
mesh move while its cells stay the same, the cells are stored once.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from millprint.run.hdf5 import whole_hdf5

VERSION = (2, 0)  # the first with transient PolyData: ParaView 5.12 and later read it
CELLS = ("Vertices", "Lines", "Polygons", "Strips")

# Chunks of about this size [bytes]: small enough to jump to a time, large enough to compress.
CHUNK_BYTES = 1 << 17


def _starts(counts: np.ndarray) -> np.ndarray:
    """The first row of each step, if step k has counts[k] rows."""
    return np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)


def _numbers(counts: np.ndarray) -> np.ndarray:
    """0 to counts[k] - 1 for each k, one after the other."""
    return np.arange(counts.sum()) - np.repeat(_starts(counts), counts)


class TransientPolyData:
    """A file that is being written: the sizes of all steps are known from the start, contents come in blocks of steps.

    kind: the only kind of cells, one of CELLS, with `corners` points each.
    points: points of every step, (steps,). cells: cells of every step, (steps,).
    connectivity: (cells, corners) if all steps share their cells. Otherwise None: in each step every cell then has
    separate points, numbered one after the other.
    """

    def __init__(
        self,
        file: h5py.File,
        time_s: np.ndarray,
        kind: str,
        corners: int,
        points: np.ndarray,
        cells: np.ndarray,
        connectivity: np.ndarray | None = None,
    ) -> None:
        self._root = file.create_group("VTKHDF")
        self._root.attrs["Version"] = np.array(VERSION, dtype=np.int64)
        # VTK requires a string of fixed length here.
        self._root.attrs.create("Type", b"PolyData", dtype=h5py.string_dtype("ascii", len("PolyData")))
        self._steps = self._root.create_group("Steps")
        self._steps.attrs["NSteps"] = np.int64(len(time_s))
        self._steps["Values"] = np.asarray(time_s, dtype=float)
        self._rows = {
            "": np.asarray(points),
            "PointData": np.asarray(points),
            "CellData": np.asarray(cells),
            "FieldData": np.ones(len(time_s), dtype=np.int64),
        }
        self._written: dict[str, int] = {}
        shared = connectivity is not None
        self._put_parts(shared)
        for name in CELLS:
            counts = self._rows["CellData"] if name == kind else np.zeros(len(time_s), dtype=np.int64)
            ids = connectivity.ravel() if name == kind and connectivity is not None else _numbers(corners * counts)
            self._put_cells(name, counts[:1] if shared else counts, corners, ids)

    def _put_parts(self, shared: bool) -> None:
        """One part for each step, or one part for all steps if only the points move."""
        points, steps = self._rows[""], len(self._steps["Values"])
        self._root["NumberOfPoints"] = (points[:1] if shared else points).astype(np.int64)
        self._steps["PartOffsets"] = np.zeros(steps, dtype=np.int64) if shared else np.arange(steps, dtype=np.int64)
        self._steps["NumberOfParts"] = np.ones(steps, dtype=np.int64)
        self._steps["PointOffsets"] = _starts(points)
        for name in ("CellOffsets", "ConnectivityIdOffsets"):
            self._steps[name] = np.zeros((steps, len(CELLS)), dtype=np.int64)

    def _put_cells(self, kind: str, counts: np.ndarray, corners: int, ids: np.ndarray) -> None:
        group = self._root.create_group(kind)
        group["NumberOfCells"] = counts.astype(np.int64)
        group["NumberOfConnectivityIds"] = (corners * counts).astype(np.int64)
        self._compressed(group, "Connectivity", ids.astype(np.int64))
        self._compressed(group, "Offsets", corners * _numbers(counts + 1))
        if len(counts) > 1:
            column = CELLS.index(kind)
            self._steps["CellOffsets"][:, column] = _starts(counts)
            self._steps["ConnectivityIdOffsets"][:, column] = _starts(corners * counts)

    @staticmethod
    def _compressed(group: h5py.Group, name: str, values: np.ndarray) -> None:
        group.create_dataset(name, data=values, **({"compression": "gzip", "shuffle": True} if len(values) else {}))

    def _offsets(self, place: str, name: str, values: np.ndarray) -> None:
        if place:
            self._steps.require_group(f"{place}Offsets")[name] = values

    def put_constant(self, place: str, name: str, values: np.ndarray) -> None:
        """Data of points or cells (`place` is PointData or CellData) that are the same in every step; stored once."""
        self._root.require_group(place)[name] = values
        self._offsets(place, name, np.zeros(len(self._steps["Values"]), dtype=np.int64))

    def append(self, place: str, name: str, values: np.ndarray) -> None:
        """The next rows of one quantity: of Points (`place` is empty), PointData, CellData or FieldData."""
        group, key = self._root.require_group(place) if place else self._root, f"{place}/{name}"
        if key not in self._written:
            shape = (int(self._rows[place].sum()), *values.shape[1:])
            width = values.dtype.itemsize * int(np.prod(values.shape[1:]))
            chunk = (min(shape[0], max(1, CHUNK_BYTES // width)), *shape[1:])
            options = {"chunks": chunk, "compression": "gzip", "compression_opts": 2, "shuffle": True}
            group.create_dataset(name, shape, values.dtype, **(options if shape[0] else {}))
            if place:
                self._offsets(place, name, _starts(self._rows[place]))
            self._written[key] = 0
        begin = self._written[key]
        group[name][begin : begin + len(values)] = values
        self._written[key] = begin + len(values)

    def check_complete(self) -> None:
        """Raise ValueError if a quantity is missing for some steps."""
        for key, rows in self._written.items():
            needed = int(self._rows[key.split("/")[0]].sum())
            if rows != needed:
                raise ValueError(f"{key}: {rows} rows of {needed} written")


@contextmanager
def transient_polydata(path: str | Path, time_s: np.ndarray, **layout: Any) -> Iterator[TransientPolyData]:
    """A new file, complete or absent; `layout`: arguments of TransientPolyData."""
    with whole_hdf5(path) as file:
        writer = TransientPolyData(file, time_s, **layout)
        yield writer
        writer.check_complete()
