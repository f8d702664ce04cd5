"""A run's snapshots as three files for ParaView: balls, walls and contacts."""

from contextlib import ExitStack
from pathlib import Path

import numpy as np

from millprint.run.progress import progress
from millprint.view.snapshots import Block, Snapshots, body_of_feature, open_run
from millprint.view.vtkhdf import TransientPolyData, transient_polydata

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
        snapshots = Snapshots(files.enter_context(open_run(run)), every)
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
