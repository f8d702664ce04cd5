"""A graph network that predicts its own future, step by step (thesis Sec. 6.2.2, Fig. 6.5), and single steps of it.

Wall time of roll-outs and of our own DEM, in one job so that the machine is in the same state for both.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import torch
from torch import Tensor
from tqdm import tqdm

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.surrogate import EdgeConfig, Recipe
from millprint.config.sweep import Case, DemConfig
from millprint.dem.simulation import Simulation
from millprint.run.job import progress
from millprint.thesis.surrogate import measures
from millprint.thesis.surrogate.dataset import (
    Graphs,
    ball_features,
    featurise,
    graphs_at,
    on_device,
    threshold_edges,
    wall_features,
)
from millprint.thesis.surrogate.network import NormalisedNetwork, target
from millprint.thesis.surrogate.rollout import RollOut, Scene, Trajectory, read_attributes


@dataclass
class State:
    """A batch of trajectories at one time.

    time_s (batch,), position_m and velocity_m_s (batch, balls, 3), ball (batch, balls, window, 7) and wall
    (batch, window, 7): the features of the last `window` snapshots, oldest first.
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    ball: np.ndarray
    wall: np.ndarray


class Sums(NamedTuple):
    """What is added up over the steps of a batch: dissipated_J (batch,); crossed (batch, balls), the first step after
    which a centre was outside, infinity if none; edges (2,), to walls and between balls, each counted once.
    """

    dissipated_J: np.ndarray
    crossed: np.ndarray
    edges: np.ndarray


def no_sums(state: State) -> Sums:
    """The sums before the first step."""
    graphs, balls, _ = state.position_m.shape
    return Sums(np.zeros(graphs), np.full((graphs, balls), np.inf), np.zeros(2))


def euler_step(position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, dt: float) -> tuple:
    """Explicit Euler, Eqs 6.31 and 6.32: the position moves with the velocity before the update."""
    return position + velocity * dt, velocity + acceleration * dt


def snap_back(
    position: np.ndarray, distance: np.ndarray, gradient: np.ndarray, threshold: float
) -> tuple[np.ndarray, np.ndarray]:
    """Put balls with phi >= phi_sb back to phi_sb along the unit normal (step 7 of the recursion).

    The thesis's text calls the larger overlaps "phi < phi_sb", where no correction is made; with phi negative
    inside, a deeper overlap is a larger phi, and every one above the threshold is corrected.
    Returns the new positions and which balls moved.
    """
    beyond = distance >= threshold
    normal = gradient[beyond] / np.linalg.norm(gradient[beyond], axis=-1, keepdims=True)
    moved = position.copy()
    moved[beyond] -= (distance[beyond] - threshold)[:, None] * normal
    return moved, beyond


@dataclass(frozen=True)
class GraphSurrogate:
    """A graph network in the scene of a simulation, with which it shares the step.

    model: graphs to accelerations [m/s2] and dissipation [J]; source: the simulation that gives the first states;
    window: snapshots that the network sees; edges: thresholds; snap_back_m: see `snap_back`, None for never.
    """

    model: Callable[[Graphs], tuple[Tensor, Tensor]]
    scene: Scene
    source: Trajectory
    window: int
    edges: EdgeConfig
    snap_back_m: float | None
    device: torch.device

    @property
    def step_s(self) -> float:
        """Length of a step [s]."""
        return self.source.interval_s

    def first_state(self, starts_s: list[float]) -> State:
        """The windows of DEM snapshots that end at each start [s], or as early as there are enough (step 0).

        Raises ConfigError for a start outside the recorded time.
        """
        run = self.source
        last = [max(run.index(start), self.window - 1) for start in starts_s]
        rows = np.array(last)[:, None] + np.arange(1 - self.window, 1)
        position, velocity, wall = run.position_m[rows], run.velocity_m_s[rows], run.wall_position_m[rows]
        distance, gradient = self.scene.signed_distance(position, wall[:, :, None, :])
        return State(
            time_s=run.time_s[rows[:, -1]].astype(float),
            position_m=position[:, -1].astype(float),
            velocity_m_s=velocity[:, -1].astype(float),
            ball=ball_features(velocity, distance, gradient).swapaxes(1, 2).astype(np.float32),
            wall=wall_features(wall, self.scene.speed_rpm).astype(np.float32),
        )

    def roll_out(self, starts_s: list[float], steps: int, steps_per_frame: int) -> RollOut:
        """A roll-out from the states of the simulation at each start [s], which advance as one, with a progress bar."""
        with progress(steps, None, "step") as bar:
            return self.run(self.first_state(starts_s), steps, steps_per_frame, bar)

    def graphs(self, state: State) -> Graphs:
        """The graphs of a state, with edges by thresholds on its newest snapshot."""
        ball = torch.from_numpy(state.ball).to(self.device)
        wall = torch.from_numpy(state.wall).to(self.device)
        position = torch.from_numpy(state.position_m.astype(np.float32)).to(self.device)
        batch, balls = position.shape[:2]
        edges = threshold_edges(position, ball[:, :, -1], self.edges, self.scene.ball_radius_m)
        return Graphs(ball.reshape(batch * balls, -1), wall.reshape(batch, -1), edges, balls)

    def advance(self, state: State, graphs: Graphs) -> tuple[State, np.ndarray, np.ndarray]:
        """The state a step later, the dissipation of the step (batch,) [J], and which balls' centres were outside.

        A ball counts as outside before the snap-back, which would hide it.
        """
        acceleration, dissipation = (value.cpu().numpy().astype(float) for value in self.model(graphs))
        position, velocity = euler_step(state.position_m, state.velocity_m_s, acceleration, self.step_s)
        time_s = state.time_s + self.step_s
        wall = self.scene.wall_position(time_s)
        distance, gradient = self.scene.signed_distance(position, wall[:, None, :])
        outside = ~(distance < 0)
        if self.snap_back_m is not None:
            position, beyond = snap_back(position, distance, gradient, self.snap_back_m)
            if beyond.any():
                centre = np.broadcast_to(wall[:, None, :], position.shape)[beyond]
                distance[beyond], gradient[beyond] = self.scene.signed_distance(position[beyond], centre)
        newest_ball = ball_features(velocity, distance, gradient)[:, :, None]
        newest_wall = wall_features(wall, self.scene.speed_rpm)[:, None]
        ball = np.concatenate([state.ball[:, :, 1:], newest_ball], axis=2, dtype=np.float32)
        wall_window = np.concatenate([state.wall[:, 1:], newest_wall], axis=1, dtype=np.float32)
        return State(time_s, position, velocity, ball, wall_window), dissipation, outside

    def advance_many(self, state: State, steps: int) -> tuple[State, Sums]:
        """The state some steps later, and what is added up over them."""
        sums = no_sums(state)
        with torch.inference_mode():
            for step in range(1, steps + 1):
                graphs = self.graphs(state)
                sums.edges[:] += len(graphs.edges.wall), graphs.edges.pair.shape[1] // 2
                state, energy, outside = self.advance(state, graphs)
                sums.dissipated_J[:] += energy
                np.minimum(sums.crossed, step, out=sums.crossed, where=outside)
        return state, sums

    def run(self, state: State, steps: int, steps_per_frame: int, bar: tqdm | None = None) -> RollOut:
        """Advance `steps` steps and keep every `steps_per_frame`-th state."""
        frames = steps // steps_per_frame
        kept = np.full((2, frames + 1, *state.position_m.shape), np.nan, dtype=np.float32)
        kept[:, 0] = state.position_m, state.velocity_m_s
        dissipated = np.zeros((frames + 1, len(state.time_s)))
        crossed = np.full(state.position_m.shape[:2], np.inf)
        start_s, edges = state.time_s, np.zeros(2)
        with np.errstate(invalid="ignore", over="ignore"):
            for frame in range(1, frames + 1):
                state, sums = self.advance_many(state, steps_per_frame)
                kept[:, frame] = state.position_m, state.velocity_m_s
                dissipated[frame] = sums.dissipated_J
                edges += sums.edges
                np.minimum(crossed, (frame - 1) * steps_per_frame + sums.crossed, out=crossed)
                if bar is not None:
                    bar.update(steps_per_frame)
                if not np.isfinite(state.position_m).any():
                    dissipated[frame + 1 :] = np.nan
                    break
        per_graph = edges / max(1, frames * steps_per_frame * len(start_s))
        return RollOut(
            time_s=np.arange(frames + 1) * steps_per_frame * self.step_s,
            position_m=kept[0],
            velocity_m_s=kept[1],
            dissipated_J=dissipated,
            crossed_s=crossed * self.step_s,
            start_s=start_s,
            mean_edges={"wall": float(per_graph[0]), "pair": float(per_graph[1])},
        )


def single_steps(
    model: NormalisedNetwork,
    recipe: Recipe,
    rule: EdgeConfig,
    run: Trajectory,
    scene: Scene,
    graphs: int,
    device: torch.device,
) -> dict[str, float]:
    """Single steps from up to `graphs` states, with the edges of the roll-out.

    Returns the explained share of accelerations and of dissipation, and the bias of dissipation [%], each also with
    the DEM's own contacts as edges (`_contacts`).
    """
    snapshots = featurise(run, scene)
    last = len(run.time_s) - 2
    count = min(graphs, last - recipe.graph.window + 2)
    rows = torch.from_numpy(np.linspace(recipe.graph.window - 1, last, count).astype(np.int64))
    truth = target(snapshots, recipe.graph)[rows].numpy(), snapshots.dissipation[rows].numpy()
    found = {}
    for suffix, edges in (("", rule), ("_contacts", None)):
        with torch.inference_mode():
            batches = (graphs_at(snapshots, part, recipe.graph.window, edges) for part in rows.split(256))
            parts = [model(on_device(batch, device)) for batch in batches]
        acceleration, dissipation = (torch.cat(values).cpu().numpy() for values in zip(*parts, strict=True))
        found[f"one_step_acceleration_r2{suffix}"] = measures.explained_share(acceleration, truth[0])
        found[f"one_step_dissipation_r2{suffix}"] = measures.explained_share(dissipation, truth[1])
        found[f"one_step_dissipation_bias{suffix}_percent"] = float(100 * (dissipation.sum() / truth[1].sum() - 1))
    return found


PHYSICAL_S = 15.0
# Timings whose median is taken, and wall time after which no further one is begun [s].
TIMINGS, ENOUGH_S = 5, 10.0


def seconds_per_step(surrogate: GraphSurrogate, start_s: float, batch: int, steps: int) -> tuple[float, int]:
    """Median time for one step of a batch [s], and how many steps were timed.

    Up to five timings of `steps / 5` steps, each from the same first states; no further one after ten seconds, as
    large batches of large networks take seconds a step.
    """
    run = partial(surrogate.run, surrogate.first_state([start_s] * batch))
    begin = time.perf_counter()
    run(1, 1)
    run(1, 1)
    block = max(1, min(steps // TIMINGS, round(2 * ENOUGH_S / TIMINGS / (time.perf_counter() - begin))))
    run(min(50, block), 1)
    timings: list[float] = []
    begin = time.perf_counter()
    while len(timings) < TIMINGS and (not timings or time.perf_counter() - begin < ENOUGH_S):
        start = time.perf_counter()
        run(block, block)
        timings.append((time.perf_counter() - start) / block)
    return float(np.median(timings)), len(timings) * block


def time_rollouts(
    surrogate: GraphSurrogate, start_s: float, batches: list[int], steps: int, machine: str
) -> pd.DataFrame:
    """A row a batch size: balls, batch, seconds for 15 s of physical time, and from how long they are extrapolated.

    One trajectory's share is the batch's time over its size. machine: what it was timed on, as a text.
    """
    rows = []
    for batch in batches:
        per_step, timed = seconds_per_step(surrogate, start_s, batch, steps)
        seconds = per_step * PHYSICAL_S / surrogate.step_s
        rows.append(
            {
                "balls": surrogate.source.balls,
                "batch": batch,
                "seconds_for_15_s": seconds,
                "seconds_per_trajectory": seconds / batch,
                "basis": f"extrapolated from {timed} steps of {surrogate.step_s:g} s, {machine}",
            }
        )
    return pd.DataFrame(rows)


def simulation_seconds(run: str | Path, duration_s: float) -> float:
    """Wall clock of our DEM for 15 s of the case of a run [s], from simulating `duration_s` of its motion again."""
    parts = read_attributes(run)
    case = Case(**parts["case"]).model_copy(
        update={"discard_s": 0.0, "window_s": duration_s, "snapshot_interval_s": None, "disturbance_m": None}
    )
    # One step throughout, that of the run.
    dem = DemConfig(**parts["dem"]).model_copy(update={"run_up_fraction": 0.0})
    models = MillConfig(**parts["mill"]), ContactConfig(**parts["contact"]), dem
    # The first kernel call of a process loads the kernels.
    short = case.model_copy(update={"settle_s": 1e-4, "window_s": 1e-3})
    Simulation(short, *models).run()
    simulation = Simulation(case, *models)
    simulation.run(f"time {case.path}")
    steps = simulation.settle_steps + simulation.window_steps
    return simulation.wall_clock_s / (steps * simulation.step) * PHYSICAL_S


def scaled_thresholds(
    rule: EdgeConfig, snap_back_m: float | None, radius_m: float, trained_m: float
) -> tuple[EdgeConfig, float | None]:
    """Thresholds for balls of another radius, at the same gaps and overlaps: those of Table 6.3 are for 5 mm."""
    shift = trained_m - radius_m
    shifted = rule.model_copy(update={"wall_threshold_m": rule.wall_threshold_m + shift})
    return shifted, None if snap_back_m is None else snap_back_m + shift
