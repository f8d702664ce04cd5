"""What is kept of roll-outs, whatever surrogate makes them."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class RollOut:
    """What is kept of a batch of roll-outs.

    time_s (frames,) since the start; position_m and velocity_m_s (frames, batch, balls, 3); dissipated_J
    (frames, batch) since the frame before; crossed_s (batch, balls): when a centre first crossed the wall, or left
    the finite numbers, infinity if never; edges: mean number of wall and of ball-ball edges of a graph. Of surrogates
    that know them: spin_rad_s (frames, batch, balls, 3); the two channels of dissipated_J and contacts that ended since
    the frame before (frames, batch); member_dissipated_J (frames, members) from the first start, of an ensemble, and
    its doubt (looks,): how far its members' expectations part, over the forces' own size.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    dissipated_J: np.ndarray
    crossed_s: np.ndarray
    start_s: np.ndarray
    edges: dict[str, float] = field(default_factory=dict)
    spin_rad_s: np.ndarray | None = None
    normal_J: np.ndarray | None = None
    tangential_J: np.ndarray | None = None
    collisions: np.ndarray | None = None
    member_dissipated_J: np.ndarray | None = None
    doubt: np.ndarray | None = None
