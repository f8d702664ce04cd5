"""A run's snapshots as three files for ParaView: balls, walls and contacts.

The files are transient VTKHDF of type PolyData (VTK's file format specification, version 2.0): points, cells and their
data are stored step after step; the group Steps has where each step begins. If the points of a mesh move while its
cells stay the same, the cells are stored once.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from millprint.run.hdf5 import open_hdf5, whole_hdf5
from millprint.run.job import progress
from millprint.view.frames import Block, Snapshots, body_of_feature

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


BALL, WALL = 0, 1  # partners of a contact


def export_run(run: str | Path, balls: str | Path, walls: str | Path, contacts: str | Path, every: int = 1) -> int:
    """Write one snapshot in `every` of run.h5 as transient VTKHDF files; returns how many.

    balls: a point for each ball with radius, velocity, speed in the laboratory and relative to the wall,
        angular velocity, net contact force, number of contacts; dissipated energies since the previous step as field
        data.
    walls: triangles of vessel and inserts, moving, each with the number of its body. contacts: lines between the
        centres of two balls, or from a ball's centre to the wall, with the partner (0 ball, 1 wall), both numbers and
        the overlap.
    Raises ConfigError for a run without snapshots.
    """
    with ExitStack() as files:
        snapshots = Snapshots(files.enter_context(open_hdf5(run)), every)
        count, lines = len(snapshots), snapshots.contact_count
        vertices, triangles, owner = _all_walls(snapshots)
        ball_file, wall_file, contact_file = (
            files.enter_context(transient_polydata(path, snapshots.time_s, **layout))
            for path, layout in (
                (balls, _layout(count, "Vertices", snapshots.balls, np.arange(snapshots.balls)[:, None])),
                (walls, _layout(count, "Polygons", vertices, triangles)),
                (contacts, {"kind": "Lines", "corners": 2, "points": 2 * lines, "cells": lines}),
            )
        )
        ball_file.put_constant("PointData", "radius_m", snapshots.radius_m)
        ball_file.put_constant("PointData", "ball", np.arange(snapshots.balls, dtype=np.int32))
        wall_file.put_constant("CellData", "body", owner)
        with progress(count, "exporting", "snapshot") as bar:
            for block in snapshots.blocks():
                _append_balls(ball_file, snapshots, block)
                pairs = zip(block.body_poses, snapshots.bodies, strict=True)
                moved = np.concatenate([poses.to_laboratory(body.vertices_m) for poses, body in pairs], axis=1)
                wall_file.append("", "Points", moved.reshape(-1, 3).astype(np.float32))
                _append_contacts(contact_file, snapshots, block)
                bar.update(block.rows.stop - block.rows.start)
        return count


def _all_walls(snapshots: Snapshots) -> tuple[int, np.ndarray, np.ndarray]:
    """Number of vertices of vessel and inserts, their triangles (t, 3), and the body (t,) of each."""
    counts = [len(body.vertices_m) for body in snapshots.bodies]
    starts = np.cumsum([0, *counts])[:-1]
    triangles = [body.triangles + start for body, start in zip(snapshots.bodies, starts, strict=True)]
    owner = np.repeat(np.arange(len(counts), dtype=np.int32), [len(part) for part in triangles])
    return sum(counts), np.concatenate(triangles), owner


def _layout(steps: int, kind: str, points: int, connectivity: np.ndarray) -> dict:
    """Cells that all steps share."""
    return {
        "kind": kind,
        "corners": connectivity.shape[1],
        "points": np.full(steps, points),
        "cells": np.full(steps, len(connectivity)),
        "connectivity": connectivity,
    }


def _append_balls(file: TransientPolyData, snapshots: Snapshots, block: Block) -> None:
    position, velocity = block.balls["position_m"], block.balls["velocity_m_s"]
    relative = velocity - block.poses.velocity_at(position)
    columns = {
        "velocity_m_s": velocity,
        "speed_m_s": np.linalg.norm(velocity, axis=-1),
        "relative_speed_m_s": np.linalg.norm(relative, axis=-1).astype(velocity.dtype),
        "spin_rad_s": block.balls["spin_rad_s"],
        "contact_force_N": block.balls["contact_force_N"],
        "contacts": contact_number(block, snapshots.balls),
    }
    file.append("", "Points", position.reshape(-1, 3))
    for name, values in columns.items():
        file.append("PointData", name, values.reshape(-1, *values.shape[2:]))
    file.append("FieldData", "normal_J", snapshots.normal_J[block.rows])
    file.append("FieldData", "tangential_J", snapshots.tangential_J[block.rows])


def contact_number(block: Block, balls: int) -> np.ndarray:
    """Contacts of every ball in every snapshot (n, balls); a contact of two balls counts for both."""
    steps = len(block.contact_count)
    is_pair = block.second >= 0
    place = block.contact_step * balls
    of_first = np.bincount(place + block.first, minlength=steps * balls)
    of_second = np.bincount((place + block.second)[is_pair], minlength=steps * balls)
    return (of_first + of_second).reshape(steps, balls).astype(np.int32)


def _append_contacts(file: TransientPolyData, snapshots: Snapshots, block: Block) -> None:
    """Lines of two points each, and the data of each contact."""
    position, step = block.balls["position_m"], block.contact_step
    start = position[step, block.first]
    end = np.empty_like(start)
    is_pair = block.second >= 0
    end[is_pair] = position[step[is_pair], block.second[is_pair]]
    end[~is_pair] = _feet(snapshots, block, start[~is_pair], -1 - block.second[~is_pair], step[~is_pair])
    # A wall has no radius to add to the ball's.
    radius = np.append(snapshots.radius_m, 0.0)
    reach = radius[block.first] + radius[np.where(is_pair, block.second, -1)]
    file.append("", "Points", np.stack([start, end], axis=1).reshape(-1, 3))
    file.append("CellData", "partner", np.where(is_pair, BALL, WALL).astype(np.int32))
    file.append("CellData", "first", block.first.astype(np.int32))
    file.append("CellData", "second", block.second.astype(np.int32))
    file.append("CellData", "overlap_m", (reach - np.linalg.norm(end - start, axis=1)).astype(np.float32))


def _feet(snapshots: Snapshots, block: Block, start: np.ndarray, feature: np.ndarray, step: np.ndarray) -> np.ndarray:
    """The points (n, 3) of wall features (n,) nearest to points (n, 3) at steps (n,), all in the laboratory [m]."""
    feet = np.empty_like(start)
    owner, local = body_of_feature(snapshots.bodies, feature)
    for number, (body, poses) in enumerate(zip(snapshots.bodies, block.body_poses, strict=True)):
        on = owner == number
        turn, origin = poses.rotation[step[on]], poses.position_m[step[on]]
        inside = np.einsum("nji,nj->ni", turn, start[on] - origin)
        feet[on] = np.einsum("nij,nj->ni", turn, body.foot(local[on], inside)) + origin
    return feet
