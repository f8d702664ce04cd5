"""A roll-out as it is measured: whatever surrogate made it, its file has the same arrays."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from millprint.errors import ConfigError
from millprint.hdf5 import open_hdf5

WANTED = ("time_s", "position_m", "velocity_m_s", "dissipated_J", "crossed_s", "start_s")
# What a surrogate may know beyond its balls and their dissipation.
OPTIONAL = ("normal_J", "tangential_J", "collisions", "member_dissipated_J", "doubt")
# How a surrogate counts collisions that does not say so: contacts that ended (a rule of dem.counting_rules).
LIFETIMES = "lifetimes"


@dataclass(frozen=True)
class Rolled:
    """Frames of a batch of trajectories that a surrogate rolled out.

    time_s (frames,) since the start; position_m, velocity_m_s (frames, batch, balls, 3); dissipated_J (frames, batch)
    since the frame before; crossed_s (batch, balls): when a centre first crossed the wall, infinity if never;
    start_s (batch,). extra: those of OPTIONAL that the surrogate wrote, since the frame before: both channels of the
    dissipation and collisions by `counting_rule` (frames, batch), and of an ensemble the dissipation of each member
    from the first start (frames, members) and how far the members' forces part, over those forces (looks,). edges:
    mean numbers of edges.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    dissipated_J: np.ndarray
    crossed_s: np.ndarray
    start_s: np.ndarray
    extra: dict[str, np.ndarray] = field(default_factory=dict)
    edges: dict[str, float] = field(default_factory=dict)
    counting_rule: str = LIFETIMES

    def member_totals_J(self) -> np.ndarray | None:
        """Cumulative dissipation of each member of an ensemble, (frames, members); None of a single surrogate."""
        members = self.extra.get("member_dissipated_J")
        return None if members is None or members.shape[1] < 2 else np.cumsum(members, axis=0)


def read_rolled(path: str | Path) -> Rolled:
    """Read a roll-out; raises ConfigError for a file that lacks an array."""
    with open_hdf5(path) as file:
        for name in WANTED:
            if name not in file:
                raise ConfigError(f"{path}: {name} is missing: not a roll-out, or one of another version")
        edges = {
            kind: float(file.attrs[key]) for kind in ("wall", "pair") if (key := f"mean_{kind}_edges") in file.attrs
        }
        extra = {name: file[name][:].astype(float) for name in OPTIONAL if name in file}
        arrays = {name: file[name][:].astype(float) for name in WANTED}
        return Rolled(**arrays, extra=extra, edges=edges, counting_rule=file.attrs.get("counting_rule", LIFETIMES))
