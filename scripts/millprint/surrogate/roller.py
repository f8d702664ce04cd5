"""One door to every surrogate: weights and a simulation in, something that rolls out."""

from pathlib import Path
from typing import Any, Protocol

import torch
from tqdm import tqdm

from millprint.config.surrogate import EdgeConfig
from millprint.surrogate.contact.roller import ContactRoller
from millprint.surrogate.contact.store import is_ensemble


class Roller(Protocol):
    """A surrogate in a scene. `run` advances a state by `steps` steps of step_s and keeps every so many-th."""

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""
        ...

    @property
    def balls(self) -> int:
        """How many balls there are."""
        ...

    def first_state(self, starts_s: list[float]) -> Any:
        """The states that a batch of roll-outs begins from, one a start [s]."""

    def run(self, state: Any, steps: int, steps_per_frame: int, bar: tqdm | None = None) -> Any:
        """Advance, and keep what RollOut says."""


def open_roller(
    weights: str | Path,
    run: str | Path,
    rule: EdgeConfig,
    snap_back_m: float | None,
    device: torch.device,
    until_s: float,
) -> Roller:
    """The surrogate of a weights file in the scene of a simulation, with first states up to `until_s`.

    snap_back_m: signed distance above which a ball is put back to it [m]; None for never.
    """
    if is_ensemble(weights):
        return ContactRoller(weights, run)
    # Takes long to import, and the other kind does without.
    from millprint.surrogate.thesis.roller import open_graph_roller

    return open_graph_roller(weights, run, rule, snap_back_m, device, until_s)
