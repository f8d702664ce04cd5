"""run.h5: everything that a run recorded, with units."""

import json
import platform
from pathlib import Path

import h5py
import numba
import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from millprint.dem.layout import OCCUPANCY, SNAPSHOT, SNAPSHOT_TOTAL
from millprint.dem.recording import Recording, settings_of
from millprint.dem.resources import COLLISION_ROWS_MAX
from millprint.dem.simulation import Simulation
from millprint.mill.creases import rim_rows
from millprint.mill.curved_surfaces import curve_rows
from millprint.mill.drawn_creases import crease_rows
from millprint.mill.kernel_columns import span_of
from millprint.mill.motion import POSE
from millprint.mill.vessel import Vessel
from millprint.mill.wall_features import features_of
from millprint.run.hdf5 import whole_hdf5

# Unit by the end of a column's name.
UNITS = {"_J": "J", "_s": "s", "_m_s": "m/s", "_N": "N", "_m": "m", "_rad_s": "rad/s"}

# Columns that need all their digits or are whole numbers already.
WIDE = {"start_s", "time_s", "position_m", "body_position_m"}

# Bits of a collision's value that are kept: the others are noise that does not compress. Values are rounded by 1.5e-5
# at most, up and down alike, sums of a thousand by 1e-6. Times, by which contacts are merged, keep theirs.
KEPT_BITS = 15
TIMES = {"start_s", "duration_s"}

COMPRESSION = {"compression": "gzip", "compression_opts": 2, "shuffle": True}


def unit_of(name: str) -> str:
    """The unit that a column's name ends with; 1 for a pure number."""
    ends = [end for end in sorted(UNITS, key=len, reverse=True) if name.endswith(end)]
    return UNITS[ends[0]] if ends else "1"


def put(group: h5py.Group, name: str, values: ArrayLike, narrow: bool = False) -> None:
    """Write one dataset with its unit; `narrow` ones in single precision."""
    values = np.asarray(values)
    if narrow and name not in WIDE and values.dtype == np.float64:
        values = values.astype(np.float32)
    options = COMPRESSION if values.size > 64 else {}
    group.create_dataset(name, data=values, **options).attrs["units"] = unit_of(name)


def rounded(values: np.ndarray) -> np.ndarray:
    """Numbers rounded to KEPT_BITS binary digits."""
    mantissa, exponent = np.frexp(values)
    return np.ldexp(np.rint(np.ldexp(mantissa, KEPT_BITS + 1)), exponent - KEPT_BITS - 1)


def put_frame(group: h5py.Group, frame: pd.DataFrame, narrow: bool = False) -> None:
    """Write the columns of a table."""
    for name in frame.columns:
        put(group, name, frame[name].to_numpy(), narrow)


def _put_occupancy(group: h5py.Group, recording: Recording) -> None:
    """Occupancy and granular temperature, Theta = (<V^2> - <V>^2) / 3 (Eq. 3.26), of velocities relative to the jar."""
    sums = recording.occupancy
    count, squares = sums[..., OCCUPANCY.balls], sums[..., OCCUPANCY.speed_squared]
    divisor = np.where(count > 0, count, np.nan)
    mean = sums[..., span_of(OCCUPANCY.velocity)] / divisor[..., None]
    put(group, "edges_x_m", recording.edges[0])
    put(group, "edges_y_m", recording.edges[1])
    put(group, "count", count.astype(np.int64))
    put(group, "mean_velocity_m_s", mean)
    put(group, "granular_temperature", (squares / divisor - (mean**2).sum(axis=-1)) / 3)
    group["granular_temperature"].attrs["units"] = "m2/s2"


def _put_poses(group: h5py.Group, pose: np.ndarray) -> None:
    """Poses (m, width) of a body (mill.motion); rotations and angular velocities only of one that turns."""
    put(group, "body_position_m", pose[:, span_of(POSE.position)])
    put(group, "body_velocity_m_s", pose[:, span_of(POSE.velocity)])
    rotation = pose[:, span_of(POSE.rotation)].reshape(-1, 3, 3)
    if (rotation != np.eye(3)).any():
        put(group, "body_rotation", rotation)
        put(group, "body_spin_rad_s", pose[:, span_of(POSE.angular_velocity)])


def _put_snapshots(group: h5py.Group, simulation: Simulation, recording: Recording) -> None:
    pose, total = np.concatenate(recording.poses), np.concatenate(recording.snapshot_works)
    per_ball = np.concatenate(recording.snapshots)
    contacts = np.concatenate(recording.snapshot_contacts)
    # Contacts are counted from the start of each piece.
    after = [piece[:, SNAPSHOT_TOTAL.contacts] for piece in recording.snapshot_works]
    counts = np.concatenate([np.diff(piece, prepend=0) for piece in after])
    put(group, "time_s", total[:, SNAPSHOT_TOTAL.time_s])
    _put_poses(group, pose[:, 0])
    for index, body in enumerate(simulation.bodies[1:], start=1):
        _put_poses(group.create_group(f"inserts/{body.name}"), pose[:, index])
    for name, columns in SNAPSHOT._asdict().items():
        put(group, name, per_ball[:, :, span_of(columns)], narrow=True)
    # There is nothing before the first snapshot.
    for name in ("normal_J", "tangential_J"):
        energy = total[:, getattr(SNAPSHOT_TOTAL, name)]
        put(group, name, np.diff(energy, prepend=energy[0]))
    put(group, "contact_offset", np.concatenate([[0], np.cumsum(counts)]).astype(np.int64))
    put(group, "contact_first", contacts[:, 0].astype(np.int32))
    put(group, "contact_second", contacts[:, 1].astype(np.int32))


def put_geometry(group: h5py.Group, vessel: Vessel) -> None:
    """Walls in the body frame: triangles to look at, and features in the order in which contacts number them."""
    vertices, triangles = vessel.triangles()
    put(group, "vertices_m", vertices)
    put(group, "triangles", triangles)
    put(group, "facet_normal", vessel.normals)
    put(group, "facet_offset_m", vessel.offsets)
    features = features_of(vessel)
    put(group, "edge_m", np.reshape([(edge.start, edge.end) for edge in features.lines], (-1, 2, 3)))
    put(group, "curves", curve_rows(vessel.curves))
    put(group, "rims", rim_rows(features.rims))
    if features.creases:
        put(group, "creases", crease_rows(features.creases))
    put(group, "corner_m", np.reshape([corner.point for corner in features.corners], (-1, 3)))


def write_run(
    path: str | Path, simulation: Simulation, recording: Recording, series: pd.DataFrame, table: pd.DataFrame
) -> None:
    """Write run.h5: attributes config, seed, versions; groups geometry, ledger, collisions, occupancy, snapshots."""
    versions = {"python": platform.python_version(), "numba": numba.__version__, "numpy": np.__version__}
    with whole_hdf5(path) as file:
        file.attrs["config"] = json.dumps(settings_of(simulation), sort_keys=True)
        file.attrs["seed"] = simulation.case.seed
        file.attrs["versions"] = json.dumps(versions)
        file.attrs["facets"] = sum(len(body.vessel.normals) for body in simulation.bodies)
        file.attrs["ball_radius_m"] = simulation.radius
        put(file.create_group("balls"), "radius_m", simulation.balls.radius[simulation.balls.species])
        put_geometry(file.create_group("geometry"), simulation.vessel)
        for body in simulation.bodies[1:]:
            put_geometry(file.create_group(f"geometry/inserts/{body.name}"), body.vessel)
        put_frame(file.create_group("ledger"), series)
        group = file.create_group("collisions")
        group.attrs["begin_s"] = simulation.begin_s
        group.attrs["window_s"] = simulation.window_s
        group.attrs["rows"] = len(table)
        if len(table) <= COLLISION_ROWS_MAX:
            values = [name for name in table.select_dtypes(float).columns if name not in TIMES]
            put_frame(group, table.assign(**{name: rounded(table[name].to_numpy()) for name in values}), narrow=True)
        _put_occupancy(file.create_group("occupancy"), recording)
        if recording.snapshots:
            _put_snapshots(file.create_group("snapshots"), simulation, recording)
