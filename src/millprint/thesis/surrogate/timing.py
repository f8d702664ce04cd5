"""Wall time of roll-outs and of our own DEM, in one job so that the machine is in the same state for both."""

import time
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.config.surrogate import EdgeConfig
from millprint.config.sweep import Case, DemConfig
from millprint.dem.simulation import Simulation
from millprint.thesis.surrogate.graph_surrogate import GraphSurrogate
from millprint.thesis.surrogate.scene import read_attributes

PHYSICAL_S = 15.0
# Timings whose median is taken, and wall time after which no further one is begun [s].
TIMINGS, ENOUGH_S = 5, 10.0


def seconds_per_step(surrogate: GraphSurrogate, start_s: float, batch: int, steps: int) -> tuple[float, int]:
    """Median time for one step of a batch [s], and how many steps were timed.

    Up to five timings of `steps / 5` steps, each from the same first states; no further one after ten seconds, as
    large batches of large networks take seconds a step.
    """
    run = surrogate.begin([start_s] * batch)
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
                "balls": surrogate.balls,
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
    models = MillConfig(**parts["mill"]), ContactConfig(**parts["contact"]), DemConfig(**parts["dem"])
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
