"""A roll-out as it is measured: whatever surrogate made it, its file has the same arrays."""

from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from millprint.errors import ConfigError

WANTED = ("time_s", "position_m", "velocity_m_s", "dissipated_J", "crossed_s", "start_s")
# What a surrogate may know beyond its balls and their dissipation.
OPTIONAL = ("normal_J", "tangential_J", "collisions", "spread_dissipated_J")


@dataclass(frozen=True)
class Rolled:
    """Frames of a batch of trajectories that a surrogate rolled out.

    time_s (frames,) since the start; position_m, velocity_m_s (frames, batch, balls, 3); dissipated_J (frames, batch)
    since the frame before; crossed_s (batch, balls): when a centre first crossed the wall, infinity if never;
    start_s (batch,). extra: those of OPTIONAL that the surrogate wrote, each (frames, batch), since the frame before
    but for the spread of an ensemble, which is that of the cumulative dissipation. edges: mean numbers of edges.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    dissipated_J: np.ndarray
    crossed_s: np.ndarray
    start_s: np.ndarray
    extra: dict[str, np.ndarray] = field(default_factory=dict)
    edges: dict[str, float] = field(default_factory=dict)


def read_rolled(path: str | Path) -> Rolled:
    """Read a roll-out; raises ConfigError for a file that lacks an array."""
    with h5py.File(path) as file:
        for name in WANTED:
            if name not in file:
                raise ConfigError(f"{path}: {name} is missing: not a roll-out, or one of another version")
        edges = {
            kind: float(file.attrs[key]) for kind in ("wall", "pair") if (key := f"mean_{kind}_edges") in file.attrs
        }
        extra = {name: file[name][:].astype(float) for name in OPTIONAL if name in file}
        return Rolled(**{name: file[name][:].astype(float) for name in WANTED}, extra=extra, edges=edges)
