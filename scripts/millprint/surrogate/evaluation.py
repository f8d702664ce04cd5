"""A roll-out against the simulation it started from, with the distance of two simulations beside every measure."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import torch

from millprint.config.surrogate import EdgeConfig, Recipe
from millprint.surrogate import measures
from millprint.surrogate.features import featurise
from millprint.surrogate.graphs import graphs_at
from millprint.surrogate.normalise import Surrogate, target
from millprint.surrogate.rollout import RollOut
from millprint.surrogate.scene import Scene
from millprint.surrogate.tables import tabulate
from millprint.surrogate.trajectory import Trajectory

INCREMENT_S = 0.005
# The error at which two trajectories count as parted, over that of two unrelated simulations.
PARTED = 0.1


@dataclass(frozen=True)
class Series:
    """A batch of trajectories at the frames of a roll-out.

    position_m and velocity_m_s (frames, batch, balls, 3), wall_m (frames, batch, 3), cumulative_J (frames, batch).
    """

    time_s: np.ndarray
    position_m: np.ndarray
    velocity_m_s: np.ndarray
    wall_m: np.ndarray
    cumulative_J: np.ndarray

    def speed(self) -> np.ndarray:
        return np.linalg.norm(self.velocity_m_s, axis=-1)

    def wall_distance(self, scene: Scene) -> np.ndarray:
        """Distance of every centre from the wall, positive inside [m]."""
        return -scene.signed_distance(self.position_m, self.wall_m[:, :, None, :])[0]


def simulated_series(run: Trajectory, time_s: np.ndarray, start_s: np.ndarray) -> Series:
    """The simulation at `time_s` (frames,) after each of `start_s` (batch,)."""
    start = np.array([run.index(start) for start in start_s])
    frames = np.rint(time_s / run.interval_s).astype(int)
    rows = start + frames[:, None]
    run.index(float(start_s.max() + time_s[-1]))
    total = np.cumsum(run.dissipated_J)
    return Series(
        time_s=time_s,
        position_m=run.position_m[rows].astype(float),
        velocity_m_s=run.velocity_m_s[rows].astype(float),
        wall_m=run.wall_position_m[rows].astype(float),
        cumulative_J=total[rows] - total[start],
    )


def rolled_series(rollout: RollOut, wall_m: np.ndarray) -> Series:
    """A roll-out beside a simulation whose wall stood at `wall_m`."""
    return Series(
        time_s=rollout.time_s,
        position_m=rollout.position_m.astype(float),
        velocity_m_s=rollout.velocity_m_s.astype(float),
        wall_m=wall_m,
        cumulative_J=np.cumsum(rollout.dissipated_J, axis=0),
    )


def compare(series: Series, truth: Series, scene: Scene, saturation_m2: float) -> dict[str, float]:
    """Every measure of one series against another."""
    error = measures.position_error(series.position_m, truth.position_m)
    step = max(1, round(INCREMENT_S / (truth.time_s[1] - truth.time_s[0])))
    found = {"position_mse_plateau_m2": measures.plateau(error)}
    for milliseconds in (10, 100):
        frame = np.searchsorted(truth.time_s, milliseconds / 1e3 - 1e-9)
        if frame < len(error):
            found[f"position_mse_{milliseconds}ms_m2"] = float(error[frame].mean())
    found["horizon_s"] = measures.horizon(truth.time_s, error, PARTED * saturation_m2)
    found["dissipation_error_percent"] = measures.relative_error_percent(series.cumulative_J, truth.cumulative_J)
    found["dissipation_power_W"] = float(series.cumulative_J[-1].mean() / truth.time_s[-1])
    found["cumulative_pearson_r"] = measures.correlation(series.cumulative_J, truth.cumulative_J)
    found["increments_5ms_r"] = measures.correlation(
        measures.increments(series.cumulative_J, step), measures.increments(truth.cumulative_J, step)
    )
    found["speed_wasserstein_m_s"] = measures.distribution_distance(series.speed(), truth.speed())
    found["wall_distance_wasserstein_m"] = measures.distribution_distance(
        series.wall_distance(scene), truth.wall_distance(scene)
    )
    with np.errstate(over="ignore"):
        found["mean_square_speed_ratio"] = float((series.speed() ** 2).mean() / (truth.speed() ** 2).mean())
    return found


def evaluate(
    rollout: RollOut, runs: dict[str, Trajectory], scene: Scene, test: str, variant: str, ablation: bool = False
) -> tuple[pd.DataFrame, dict[str, Series]]:
    """The table of measures of one test, and the series behind it.

    runs: `dem` (the truth), `other_seed`, and, for a modified geometry, `original`. Columns: variant, test, measure,
    value, dem_reference (other_seed against dem), thesis, aim.
    """
    series = {name: simulated_series(run, rollout.time_s, rollout.start_s) for name, run in runs.items()}
    series["surrogate"] = rolled_series(rollout, series["dem"].wall_m)
    truth, seed = series["dem"], series["other_seed"]
    saturation = measures.plateau(measures.position_error(seed.position_m, truth.position_m))
    values = compare(series["surrogate"], truth, scene, saturation)
    reference = compare(seed, truth, scene, saturation)
    values["position_mse_centroid_m2"] = measures.plateau(measures.centroid_error(truth.position_m))
    values["balls_left"] = float(np.isfinite(rollout.crossed_s).sum())
    values["stable"] = float(values["balls_left"] == 0 and values["mean_square_speed_ratio"] < 2)
    values["mean_wall_edges"], values["mean_pair_edges"] = rollout.edges["wall"], rollout.edges["pair"]
    if "original" in series:
        cumulative = series["surrogate"].cumulative_J, series["original"].cumulative_J
        values["dissipation_error_original_percent"] = measures.relative_error_percent(*cumulative)
    return tabulate(values, reference, test, variant, ablation), series


def one_step(
    model: Surrogate, recipe: Recipe, rule: EdgeConfig, run: Trajectory, scene: Scene, graphs: int, device: torch.device
) -> dict[str, float]:
    """Single steps from DEM states, with the edges of the roll-out: what is lost before any error can grow.

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
            parts = [model(batch.to(device)) for batch in batches]
        acceleration, dissipation = (torch.cat(values).cpu().numpy() for values in zip(*parts, strict=True))
        found[f"one_step_acceleration_r2{suffix}"] = measures.explained_share(acceleration, truth[0])
        found[f"one_step_dissipation_r2{suffix}"] = measures.explained_share(dissipation, truth[1])
        found[f"one_step_dissipation_bias{suffix}_percent"] = float(100 * (dissipation.sum() / truth[1].sum() - 1))
    return found


def error_table(series: dict[str, Series], test: str) -> pd.DataFrame:
    """Position errors over time, averaged over the batch: of the roll-out, of another seed, of the centre of mass."""
    truth = series["dem"].position_m
    return pd.DataFrame(
        {
            "test": test,
            "time_s": series["dem"].time_s,
            "surrogate_m2": measures.position_error(series["surrogate"].position_m, truth).mean(axis=1),
            "other_seed_m2": measures.position_error(series["other_seed"].position_m, truth).mean(axis=1),
            "centroid_m2": measures.centroid_error(truth).mean(axis=1),
        }
    )


def dissipation_table(series: dict[str, Series], test: str) -> pd.DataFrame:
    """Cumulative dissipation over time, averaged over the batch, of every series."""
    columns = {f"{name}_J": part.cumulative_J.mean(axis=1) for name, part in series.items()}
    return pd.DataFrame({"test": test, "time_s": series["dem"].time_s, **columns})


def distribution_table(series: dict[str, Series], scene: Scene, test: str, bins: int = 50) -> pd.DataFrame:
    """Probability densities of speed [m/s] and wall distance [m]: surrogate, simulation and another seed."""
    tables = []
    names = ("surrogate", "dem", "other_seed")
    for quantity in ("speed_m_s", "wall_distance_m"):
        samples = {}
        for name in names:
            part = series[name]
            values = part.speed() if quantity == "speed_m_s" else part.wall_distance(scene)
            samples[name] = values[np.isfinite(values)]
        top = max(np.quantile(samples["dem"], 0.999), np.quantile(samples["other_seed"], 0.999)) * 1.3
        edges = np.linspace(0, top, bins + 1)
        # Values off the scale stay in the total, so that a density of a run-away roll-out is small and not rescaled.
        counts = {name: np.histogram(values, edges)[0] / max(1, len(values)) for name, values in samples.items()}
        density = {name: share / (edges[1] - edges[0]) for name, share in counts.items()}
        places = {"test": test, "quantity": quantity, "low": edges[:-1], "high": edges[1:]}
        tables.append(pd.DataFrame(places | density))
    return pd.concat(tables, ignore_index=True)
