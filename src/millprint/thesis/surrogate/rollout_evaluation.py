"""Compares a roll-out with the simulation that it started from, in numbers and in a movie.

There are two kinds of second simulation. A twin starts from the same state as the roll-out, but for a disturbance of
1e-9 m: no model can diverge more slowly. Another seed shares nothing with the truth but the case: a perfect model of
the statistics would be as far away.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.run.hdf5 import open_hdf5
from millprint.thesis.surrogate import measures
from millprint.thesis.surrogate.rollout import RollOut, Scene, Trajectory, simulated
from millprint.view.frames import VIEWS, Frame, Movie, Snapshots, Stage

SIDES = ("DEM", "surrogate")
# Position at which an escaped ball is drawn [m]: outside every picture, but a number that every renderer can draw.
AWAY_M = 1.0


def movie_side_by_side(
    run: str | Path,
    time_s: np.ndarray,
    position_m: np.ndarray,
    velocity_m_s: np.ndarray,
    every: int,
    frames_per_second: int,
) -> Movie:
    """A movie with the simulation on the left and a prediction of it on the right.

    time_s (n,) since the start of the motion, position_m and velocity_m_s (n, balls, 3): the prediction; one frame in
    `every` is shown. Raises ConfigError for a run without snapshots at these times.
    """
    time_s, position_m, velocity_m_s = (values[::every] for values in (time_s, position_m, velocity_m_s))
    with open_hdf5(run) as file:
        first, stride, last = _rows(file["snapshots/time_s"][:], time_s, run)
        stage = Stage(Snapshots(file, stride, first, last))
    frames = []
    for block in stage.blocks:
        moments = time_s[block.rows]
        place, motion = (
            np.nan_to_num(values[block.rows], nan=AWAY_M, posinf=AWAY_M, neginf=-AWAY_M)
            for values in (position_m, velocity_m_s)
        )
        simulated = stage.frames(block, moments, block.balls["position_m"], block.balls["velocity_m_s"])
        predicted = stage.frames(block, moments, np.clip(place, -AWAY_M, AWAY_M), motion)
        frames += [_together(*pair) for pair in zip(simulated, predicted, strict=True)]
    panels = [stage.panel(view, f"{name}, {view.title}") for view in VIEWS for name in SIDES]
    return stage.movie(frames, panels, float(time_s[1] - time_s[0]), frames_per_second, len(SIDES))


def _together(simulated: Frame, predicted: Frame) -> Frame:
    pairs = zip(simulated.pictures, predicted.pictures, strict=True)
    return Frame(simulated.time_s, simulated.revolution, tuple(picture for pair in pairs for picture in pair))


def _rows(recorded_s: np.ndarray, asked_s: np.ndarray, run: str | Path) -> tuple[int, int, int]:
    """First, stride and last of the snapshots at the requested times."""
    rows = np.searchsorted(recorded_s, asked_s - 1e-6)
    if len(rows) < 2 or rows[-1] >= len(recorded_s) or np.abs(recorded_s[rows] - asked_s).max() > 1e-5:
        raise ConfigError(f"{run}: no snapshots at the frames of the roll-out: set snapshot_interval_s to divide them")
    return int(rows[0]), int(rows[1] - rows[0]), int(rows[-1]) + 1


INCREMENT_S = 0.005
# Shares of the error of two unrelated simulations: where trajectories count as diverged, and where their growth begins.
DIVERGED, CLOSE = 0.5, 1e-4
# The simulations that every roll-out is compared with, by their role in a test.
REFERENCES = ("dem", "other_seed", "twin")

Values = dict[str, float]


@dataclass(frozen=True)
class Evaluation:
    """Measures of a roll-out, what a second simulation scores in each, and the roll-outs behind them by name."""

    values: Values
    references: Values
    rollouts: dict[str, RollOut]


def of_test(test: str, inputs: Mapping[str, str]) -> dict[str, str]:
    """What a test is measured against, by role; the inputs of a test are named `test_role`."""
    prefix = f"{test}_"
    return {name.removeprefix(prefix): path for name, path in inputs.items() if name.startswith(prefix)}


def growth(rollout: RollOut, truth: RollOut, saturation_m2: float) -> Values:
    """How fast trajectories diverge: errors soon after the start, and times to a share of the saturated error."""
    error = measures.position_error(rollout.position_m, truth.position_m)
    found = {}
    for milliseconds in (10, 100):
        frame = np.searchsorted(truth.time_s, milliseconds / 1e3 - 1e-9)
        if frame < len(error):
            found[f"position_mse_{milliseconds}ms_m2"] = float(error[frame].mean())
    found["horizon_s"] = measures.horizon(truth.time_s, error, DIVERGED * saturation_m2)
    bounds = CLOSE * saturation_m2, DIVERGED * saturation_m2
    found["error_growth_time_s"] = measures.growth_time(truth.time_s, error, *bounds)
    return found


def increments_J(rollout: RollOut) -> np.ndarray:
    """Dissipation in every 5 ms, (n, batch) [J]."""
    frames = max(1, round(INCREMENT_S / (rollout.time_s[1] - rollout.time_s[0])))
    return measures.increments(rollout.cumulative_J, frames)


def statistics(rollout: RollOut, truth: RollOut, radius_m: float) -> Values:
    """The statistics in which two simulations of different seeds agree.

    The Wasserstein distances are those of distributions that do not depend on which ball is where.
    """
    error = measures.position_error(rollout.position_m, truth.position_m)
    increments = increments_J(rollout), increments_J(truth)
    with np.errstate(over="ignore"):
        square_speed = float((rollout.speed() ** 2).mean() / (truth.speed() ** 2).mean())
    pairs = {
        "speed_wasserstein_m_s": (rollout.speed(), truth.speed()),
        "wall_distance_wasserstein_m": (rollout.known("wall_distance_m"), truth.known("wall_distance_m")),
        "contacts_wasserstein": (rollout.contacts(radius_m), truth.contacts(radius_m)),
        "increments_5ms_wasserstein_J": increments,
    }
    distances = {name: measures.distribution_distance(*pair) for name, pair in pairs.items()}
    if not np.isfinite(rollout.position_m).all():
        distances["contacts_wasserstein"] = np.inf
    return {
        "position_mse_plateau_m2": measures.plateau(error),
        "dissipation_error_percent": measures.relative_error_percent(rollout.cumulative_J, truth.cumulative_J),
        "dissipation_power_W": float(rollout.cumulative_J[-1].mean() / truth.time_s[-1]),
        "cumulative_pearson_r": measures.correlation(rollout.cumulative_J, truth.cumulative_J),
        "increments_5ms_r": measures.correlation(*increments),
        "mean_square_speed_ratio": square_speed,
        **distances,
    }


@dataclass(frozen=True)
class References:
    """The simulations that roll-outs of one test are compared with, and what they score among themselves.

    rollouts: `dem` (the truth), `other_seed`, and where there are any `twin` and, of a modified geometry, `original`;
    saturation_m2: position error of two unrelated simulations; values: what a second simulation scores.
    """

    rollouts: dict[str, RollOut]
    saturation_m2: float
    values: Values


def references_of(runs: dict[str, Trajectory], scene: Scene, time_s: np.ndarray, start_s: np.ndarray) -> References:
    """The references of roll-outs with frames at `time_s` (frames,) after each of `start_s` (batch,).

    runs: by role; the walls of `original` are another's, and only its dissipation is taken. Raises ConfigError as
    `simulated`.
    """
    rollouts = {name: simulated(run, scene, time_s, start_s) for name, run in runs.items()}
    other = measures.position_error(rollouts["other_seed"].position_m, rollouts["dem"].position_m)
    saturation_m2 = measures.plateau(other)
    return References(rollouts, saturation_m2, _second_simulation(rollouts, saturation_m2, scene.ball_radius_m))


def evaluate(rollout: RollOut, references: References, scene: Scene) -> Evaluation:
    """Measures of a roll-out in a jar that moves; the references have its frames."""
    rollouts = references.rollouts | {"surrogate": rollout.in_scene(scene)}
    truth = rollouts["dem"]
    # A twin shares only the start of the first trajectory.
    first = rollout.first_trajectory(), truth.first_trajectory()
    values = growth(*first, references.saturation_m2) | statistics(rollouts["surrogate"], truth, scene.ball_radius_m)
    values["balls_left"] = _balls_left(rollout)
    if values["balls_left"]:
        values["first_left_s"] = float(rollout.crossed_s.min())
    values["stable"] = float(values["balls_left"] == 0 and values["mean_square_speed_ratio"] < measures.RUNAWAY)
    values |= {f"mean_{kind}_edges": number for kind, number in rollout.mean_edges.items()}
    values["dem_power_W"] = float(truth.cumulative_J[-1].mean() / truth.time_s[-1])
    values["position_mse_centroid_m2"] = measures.plateau(measures.centroid_error(truth.position_m))
    if "original" in rollouts:
        cumulative = rollout.cumulative_J, rollouts["original"].cumulative_J
        values["dissipation_error_original_percent"] = measures.relative_error_percent(*cumulative)
    return Evaluation(values, references.values, rollouts)


def evaluate_at_rest(rollout: RollOut, runs: dict[str, Trajectory], scene: Scene) -> Evaluation:
    """Measures of a roll-out in a jar that stands still; runs: `dem`, `other_seed`, and `driven`, the jar in motion."""
    names = ("dem", "other_seed")
    rollouts = {name: simulated(runs[name], scene, rollout.time_s, rollout.start_s) for name in names}
    rollouts["surrogate"] = rollout.in_scene(scene)
    driven = runs["driven"]
    driven_W = float(driven.dissipated_J[1:].sum() / (driven.time_s[-1] - driven.time_s[0]))
    values = rest_measures(rollout, driven_W) | {"balls_left": _balls_left(rollout)}
    return Evaluation(values, rest_measures(rollouts["other_seed"], driven_W), rollouts)


def rest_measures(rollout: RollOut, driven_W: float) -> Values:
    """Balls at rest in a jar at rest: energy that appears from nowhere, and the highest lift [m]. All should be zero.

    Energy shows as dissipation, of either sign, as a share of what the driven jar dissipates in that time [%], and as
    motion: the largest root mean square speed in any frame [m/s]. driven_W: mean power of the driven jar.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        span = np.abs(np.diff(rollout.cumulative_J, axis=0)).sum(axis=0).mean()
        fastest = (rollout.speed() ** 2).mean(axis=(1, 2)).max()
        share = 100 * span / (driven_W * rollout.time_s[-1])
    return {
        "rest_dissipation_share_percent": float(share) if np.isfinite(share) else np.inf,
        "rest_highest_lift_m": measures.highest_lift(rollout.position_m),
        "rest_rms_speed_max_m_s": float(np.sqrt(fastest)) if np.isfinite(fastest) else np.inf,
    }


def _second_simulation(rollouts: dict[str, RollOut], saturation_m2: float, radius_m: float) -> Values:
    """What a second simulation scores: the twin in growth, another seed in statistics.

    The other seed is compared with both runs that it shares nothing with, as one pair of seeds may happen to be close.
    Without a twin there is no reference for growth.
    """
    truth, seed = rollouts["dem"], rollouts["other_seed"]
    if "twin" not in rollouts:
        return statistics(seed, truth, radius_m)
    twin = rollouts["twin"].first_trajectory()
    pairs = [statistics(seed, truth, radius_m), statistics(seed.first_trajectory(), twin, radius_m)]
    return growth(twin, truth.first_trajectory(), saturation_m2) | {
        name: float(np.mean([pair[name] for pair in pairs])) for name in pairs[0]
    }


def _balls_left(rollout: RollOut) -> float:
    return float(np.isfinite(rollout.crossed_s).sum())


DRAWN, BINS = ("surrogate", "dem", "other_seed"), 50


def error_table(rollouts: dict[str, RollOut], test: str) -> pd.DataFrame:
    """Position errors over time, averaged over the batch: of the roll-out, the twin, another seed, the centre of mass.

    A twin exists only for the batch's first trajectory.
    """
    truth = rollouts["dem"]
    columns = {
        f"{name}_m2": measures.position_error(rollouts[name].position_m, truth.position_m).mean(axis=1)
        for name in ("surrogate", "other_seed")
    }
    if "twin" in rollouts:
        pair = (rollouts[name].first_trajectory().position_m for name in ("twin", "dem"))
        columns["twin_m2"] = measures.position_error(*pair)[:, 0]
    columns["centroid_m2"] = measures.centroid_error(truth.position_m).mean(axis=1)
    return pd.DataFrame({"test": test, "time_s": truth.time_s, **columns})


def dissipation_table(rollouts: dict[str, RollOut], test: str) -> pd.DataFrame:
    """Cumulative dissipation over time, averaged over the batch, of every roll-out."""
    columns = {f"{name}_J": part.cumulative_J.mean(axis=1) for name, part in rollouts.items()}
    return pd.DataFrame({"test": test, "time_s": rollouts["dem"].time_s, **columns})


def distribution_table(rollouts: dict[str, RollOut], radius_m: float, test: str) -> pd.DataFrame:
    """Probability densities of speed [m/s], wall distance [m], contacts of a ball [-] and increments over 5 ms [J].

    Of the surrogate, the simulation and another seed, between `low` and `high` of each bin.
    """
    samples: dict[str, Callable[[RollOut], np.ndarray]] = {
        "speed_m_s": lambda part: part.speed(),
        "wall_distance_m": lambda part: part.known("wall_distance_m"),
        "contacts": lambda part: part.contacts(radius_m),
        "increment_5ms_J": increments_J,
    }
    tables = [
        _densities({name: sample(rollouts[name]) for name in DRAWN}, quantity) for quantity, sample in samples.items()
    ]
    return pd.concat(tables, ignore_index=True).assign(test=test)


def _densities(samples: dict[str, np.ndarray], quantity: str) -> pd.DataFrame:
    samples = {name: values[np.isfinite(values)] for name, values in samples.items()}
    simulated = np.concatenate([samples["dem"], samples["other_seed"]])
    if quantity == "contacts":
        edges = np.arange(simulated.max() + 3) - 0.5
    else:
        low, high = min(0.0, simulated.min()), np.quantile(simulated, 0.999) * 1.3
        # Balls at rest have no spread.
        edges = np.linspace(low, max(high, low + np.finfo(float).eps), BINS + 1)
    # Values off the scale stay in the total, so that a density of a run-away roll-out is small and not rescaled.
    counts = {name: np.histogram(values, edges)[0] / max(1, len(values)) for name, values in samples.items()}
    places = {"quantity": quantity, "low": edges[:-1], "high": edges[1:]}
    return pd.DataFrame(places | {name: share / np.diff(edges) for name, share in counts.items()})
