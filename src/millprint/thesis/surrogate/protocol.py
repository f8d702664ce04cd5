"""The protocol of every surrogate, and the settings for opening one."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from tqdm import tqdm

from millprint.config.surrogate import EdgeConfig
from millprint.thesis.surrogate.rollout import RollOut

if TYPE_CHECKING:
    # A second to import, and jobs that only name a surrogate need no torch.
    import torch


class Run(Protocol):
    """Rolls a batch of trajectories out, each time from the same first states."""

    def __call__(self, steps: int, steps_per_frame: int, bar: tqdm | None = None) -> RollOut:
        """Advance by `steps` steps and keep every `steps_per_frame`-th state."""
        ...


class Surrogate(Protocol):
    """A trained surrogate in the scene of a simulation."""

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""
        ...

    @property
    def balls(self) -> int:
        """How many balls there are."""
        ...

    def begin(self, starts_s: list[float]) -> Run:
        """Take the first states from the simulation, one a start [s]."""
        ...

    def roll_out(self, starts_s: list[float], steps: int, steps_per_frame: int) -> RollOut:
        """A roll-out with everything that the surrogate knows, and a progress bar."""
        ...


@dataclass(frozen=True)
class Setting:
    """What a surrogate is opened with: its weights, the simulation that gives scene and first states, and its rules.

    edges: which nodes of a graph are joined. snap_back_m: signed distance above which a ball is put back to it [m];
    None for never. until_s: first states are taken up to this time of motion [s].
    """

    weights: str | Path
    run: str | Path
    edges: EdgeConfig
    snap_back_m: float | None
    device: "torch.device"
    until_s: float
