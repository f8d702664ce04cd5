"""A graph network in the scene of a simulation, as every surrogate is rolled out."""

from dataclasses import dataclass
from pathlib import Path

import torch
from tqdm import tqdm

from millprint.config.surrogate import EdgeConfig
from millprint.surrogate.rollout import RollOut
from millprint.surrogate.scene import read_scene
from millprint.surrogate.thesis.simulator import Simulator, State, first_state
from millprint.surrogate.thesis.store import read_weights
from millprint.surrogate.trajectory import Trajectory, read_trajectory


@dataclass(frozen=True)
class GraphRoller:
    """A graph network with the simulation that its first states are taken from."""

    simulator: Simulator
    source: Trajectory
    window: int

    @property
    def step_s(self) -> float:
        """Time step [s]."""
        return self.simulator.step_s

    @property
    def balls(self) -> int:
        """Balls in a trajectory."""
        return self.source.balls

    def first_state(self, starts_s: list[float]) -> State:
        """The states at each start [s], with the windows of snapshots before them."""
        return first_state(self.source, self.simulator.scene, starts_s, self.window)

    def run(self, state: State, steps: int, steps_per_frame: int, bar: tqdm | None = None) -> RollOut:
        """Advance `steps` steps, and keep every `steps_per_frame`-th."""
        return self.simulator.run(state, steps, steps_per_frame, bar)


def open_graph_roller(
    weights: str | Path,
    run: str | Path,
    rule: EdgeConfig,
    snap_back_m: float | None,
    device: torch.device,
    until_s: float,
) -> GraphRoller:
    """The network of a weights file in the scene of a simulation, with first states up to `until_s`.

    snap_back_m: signed distance above which a ball is put back to it [m]; None for never.
    """
    model, recipe = read_weights(weights, device)
    source = read_trajectory(run, until_s=until_s)
    simulator = Simulator(model, read_scene(run), rule, snap_back_m, source.interval_s, device)
    return GraphRoller(simulator, source, recipe.graph.window)
