"""The collisions of a run, by a counting rule, as statistics of them ask for them."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

CHANNELS = ("normal", "tangential")
# The channels of the power.
PARTS = (*CHANNELS, "rolling")
PAIRS = ("ball_ball", "ball_wall")
BOTH = "both"


@dataclass(frozen=True)
class Collisions:
    """The collisions of a run that a rule keeps, of which `self[NAME]` is a value (collisions,).

    NAME is one of: start_s, duration_s (time in contact), approach_speed_m_s and slip_speed_m_s (speeds along the line
    of centres and along the surface where the bodies touch first), peak_force_N, peak_overlap_m; the energies normal_J,
    tangential_J and rolling_J within the window; first and second, the bodies (the second under 0 for a wall).
    dropped_W: power of each channel below a threshold of the rule.
    """

    values: pd.DataFrame
    begin_s: float
    window_s: float
    dropped_W: dict[str, float]

    def __getitem__(self, name: str) -> np.ndarray:
        """A value of each collision (collisions,). Raises KeyError for one that the run did not record."""
        if name not in self.values:
            raise KeyError(f"collisions have no {name}, but {', '.join(self.values)}")
        return self.values[name].to_numpy()

    @property
    def energy(self) -> dict[str, np.ndarray]:
        """Of each of CHANNELS, within the window [J] (collisions,)."""
        return {channel: self[f"{channel}_J"] for channel in CHANNELS}

    @property
    def begins(self) -> np.ndarray:
        """Which begin in the window, and so count (collisions,)."""
        return self["start_s"] >= self.begin_s

    @property
    def rate(self) -> np.ndarray:
        """1 / window for a collision that begins in it, else 0 [1/s] (collisions,)."""
        return self.begins / self.window_s

    @property
    def between_balls(self) -> np.ndarray:
        """Which are of two balls (collisions,)."""
        return self["second"] >= 0

    def quantile(self, name: str, share: float = 0.5) -> float:
        """A quantile of NAME over the collisions that begin in the window; the median by default."""
        return float(np.quantile(self[name][self.begins], share))

    def chosen(self, pair: str) -> np.ndarray:
        """Which collisions belong to this pair: one of PAIRS, or BOTH."""
        return np.ones_like(self.between_balls) if pair == BOTH else self.between_balls == (pair == PAIRS[0])

    def without(self, block: int, blocks: int) -> "Collisions":
        """Those that do not begin in one of several equal parts of the window."""
        place = np.floor((self["start_s"] - self.begin_s) / self.window_s * blocks).clip(0, blocks - 1)
        return replace(self, values=self.values[place != block], window_s=self.window_s * (1 - 1 / blocks))
