"""The wall clock of a roll-out beside that of our own DEM."""

import time

import numpy as np
import pandas as pd
import torch

from millprint.surrogate.rollout import Simulator, first_state
from millprint.surrogate.trajectory import Trajectory

PHYSICAL_S = 15.0


def seconds_per_step(
    simulator: Simulator, run: Trajectory, start_s: float, batch: int, window: int, steps: int
) -> float:
    """Median over five timings of `steps / 5` steps of a batch of `batch` trajectories, per step [s]."""
    state = first_state(run, simulator.scene, [start_s] * batch, window)
    simulator.run(state, min(50, steps), 1)
    block = max(1, steps // 5)
    timings = []
    for _ in range(5):
        start = time.perf_counter()
        simulator.run(state, block, block)
        timings.append((time.perf_counter() - start) / block)
    return float(np.median(timings))


def time_rollouts(
    simulator: Simulator, run: Trajectory, start_s: float, batches: list[int], window: int, steps: int
) -> pd.DataFrame:
    """A row a batch size: balls, batch, seconds for 15 s of physical time, and from how long they are extrapolated.

    One trajectory's share is the batch's time over its size.
    """
    rows = []
    for batch in batches:
        seconds = seconds_per_step(simulator, run, start_s, batch, window, steps) * PHYSICAL_S / simulator.step_s
        rows.append(
            {
                "balls": run.balls,
                "batch": batch,
                "seconds_for_15_s": seconds,
                "seconds_per_trajectory": seconds / batch,
                "basis": f"extrapolated from {5 * max(1, steps // 5)} steps of {simulator.step_s:g} s, "
                f"{torch.get_num_threads()} thread(s), {simulator.device.type}",
            }
        )
    return pd.DataFrame(rows)


def simulation_seconds(summary: dict) -> float:
    """Wall clock of our DEM for 15 s of the same case [s], from its measured time for a ball and a step."""
    steps = PHYSICAL_S / summary["time_step_s"]
    return summary["ns_per_ball_step"] * 1e-9 * summary["balls"] * steps
