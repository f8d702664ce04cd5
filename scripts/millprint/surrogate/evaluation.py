"""A roll-out against the simulation it started from, with the distance of two simulations beside every measure.

Two kinds of second simulation stand beside a roll-out. A twin goes on from the very state that the roll-out starts
from, but for a disturbance of 1e-9 m: how fast it parts is what no model can beat. Another seed shares nothing with
the truth but the case: how far it is away is what a perfect model of the statistics would score.
"""

from dataclasses import dataclass

import numpy as np

from millprint.surrogate import measures
from millprint.surrogate.descriptors import compare_descriptors, rolled_descriptors, simulated_descriptors
from millprint.surrogate.rest import rest_measures
from millprint.surrogate.rolled import Rolled
from millprint.surrogate.scene import Scene
from millprint.surrogate.series import Series, rolled_series, simulated_series
from millprint.surrogate.trajectory import Trajectory

INCREMENT_S = 0.005
# Shares of the error of two unrelated simulations: what counts as parted, and from where growth is looked at.
PARTED, CLOSE = 0.5, 1e-4
# A mean square speed over that of the simulation, above which a roll-out runs away.
RUNAWAY = 2.0

Values = dict[str, float]


@dataclass(frozen=True)
class Evaluation:
    """Measures of a roll-out, what a second simulation scores in each, and the series behind them by name."""

    values: Values
    references: Values
    series: dict[str, Series]


def growth(series: Series, truth: Series, saturation_m2: float) -> Values:
    """How fast trajectories part: errors soon after the start, and times to a share of the saturated error."""
    error = measures.position_error(series.position_m, truth.position_m)
    found = {}
    for milliseconds in (10, 100):
        frame = np.searchsorted(truth.time_s, milliseconds / 1e3 - 1e-9)
        if frame < len(error):
            found[f"position_mse_{milliseconds}ms_m2"] = float(error[frame].mean())
    found["horizon_s"] = measures.horizon(truth.time_s, error, PARTED * saturation_m2)
    bounds = CLOSE * saturation_m2, PARTED * saturation_m2
    found["error_growth_time_s"] = measures.growth_time(truth.time_s, error, *bounds)
    return found


def distances(series: Series, truth: Series, radius_m: float) -> Values:
    """Wasserstein distances of the distributions of what does not depend on which ball is where."""
    step = _frames_in(INCREMENT_S, truth.time_s)
    pairs = {
        "speed_wasserstein_m_s": (series.speed(), truth.speed()),
        "wall_distance_wasserstein_m": (series.wall_distance_m, truth.wall_distance_m),
        "contacts_wasserstein": (series.contacts(radius_m), truth.contacts(radius_m)),
        "increments_5ms_wasserstein_J": tuple(measures.increments(part.cumulative_J, step) for part in (series, truth)),
    }
    found = {name: measures.distribution_distance(*pair) for name, pair in pairs.items()}
    if not np.isfinite(series.position_m).all():
        found["contacts_wasserstein"] = np.inf
    return found


def statistics(series: Series, truth: Series, radius_m: float) -> Values:
    """Everything that two simulations of different seeds agree in."""
    error = measures.position_error(series.position_m, truth.position_m)
    step = _frames_in(INCREMENT_S, truth.time_s)
    increments = [measures.increments(part.cumulative_J, step) for part in (series, truth)]
    with np.errstate(over="ignore"):
        square_speed = float((series.speed() ** 2).mean() / (truth.speed() ** 2).mean())
    return {
        "position_mse_plateau_m2": measures.plateau(error),
        "dissipation_error_percent": measures.relative_error_percent(series.cumulative_J, truth.cumulative_J),
        "dissipation_power_W": float(series.cumulative_J[-1].mean() / truth.time_s[-1]),
        "cumulative_pearson_r": measures.correlation(series.cumulative_J, truth.cumulative_J),
        "increments_5ms_r": measures.correlation(*increments),
        "mean_square_speed_ratio": square_speed,
        **distances(series, truth, radius_m),
    }


def evaluate(rollout: Rolled, runs: dict[str, Trajectory], scene: Scene, summaries: dict[str, dict]) -> Evaluation:
    """Measures of a roll-out in a jar that moves.

    runs: `dem` (the truth), `other_seed`, and where there are any `twin` and, of a modified geometry, `original`, whose
    walls are another's and of which only the dissipation is taken; summaries: of `dem` and `other_seed`, whose
    collisions are compared with those of a roll-out that counts its own.
    """
    series = {name: simulated_series(run, scene, rollout.time_s, rollout.start_s) for name, run in runs.items()}
    series["surrogate"] = rolled_series(rollout, scene)
    truth, radius_m = series["dem"], scene.ball_radius_m
    other = measures.position_error(series["other_seed"].position_m, truth.position_m)
    saturation_m2 = measures.plateau(other)
    # A twin shares the start of the first trajectory alone.
    first = series["surrogate"].first_trajectory(), truth.first_trajectory()
    values = growth(*first, saturation_m2) | statistics(series["surrogate"], truth, radius_m)
    values |= _balls(rollout, values["mean_square_speed_ratio"])
    values["dem_power_W"] = float(truth.cumulative_J[-1].mean() / truth.time_s[-1])
    values["position_mse_centroid_m2"] = measures.plateau(measures.centroid_error(truth.position_m))
    if "original" in series:
        cumulative = series["surrogate"].cumulative_J, series["original"].cumulative_J
        values["dissipation_error_original_percent"] = measures.relative_error_percent(*cumulative)
    members_J = rollout.member_totals_J()
    if members_J is not None:
        values["ensemble_spread_percent"] = float(100 * members_J[-1].std(ddof=1) / members_J[-1].mean())
    doubt = rollout.extra.get("doubt", np.empty(0))
    if np.isfinite(doubt).any():
        values["ensemble_doubt_percent"] = float(100 * np.sqrt(np.nanmean(doubt**2)))
    references = _references(series, saturation_m2, radius_m)
    own = rolled_descriptors(rollout)
    if own:
        known = {name: simulated_descriptors(summary, rollout.counting_rule) for name, summary in summaries.items()}
        values |= compare_descriptors(own, known["dem"])
        references |= compare_descriptors(known["other_seed"], known["dem"])
    return Evaluation(values, references, series)


def evaluate_at_rest(rollout: Rolled, runs: dict[str, Trajectory], scene: Scene) -> Evaluation:
    """Measures of a roll-out in a jar that stands still; runs: `dem`, `other_seed`, and `driven`, the jar in motion."""
    names = ("dem", "other_seed")
    series = {name: simulated_series(runs[name], scene, rollout.time_s, rollout.start_s) for name in names}
    series["surrogate"] = rolled_series(rollout, scene)
    driven = runs["driven"]
    driven_W = float(driven.dissipated_J[1:].sum() / (driven.time_s[-1] - driven.time_s[0]))
    values = rest_measures(series["surrogate"], driven_W) | {"balls_left": _balls_left(rollout)}
    return Evaluation(values, rest_measures(series["other_seed"], driven_W), series)


def _references(series: dict[str, Series], saturation_m2: float, radius_m: float) -> Values:
    """What a second simulation scores: the twin in growth, another seed in statistics, there against each of the two
    runs that it shares nothing with, since one pair of seeds may happen to lie close. No twin, no word on growth."""
    truth, seed = series["dem"], series["other_seed"]
    if "twin" not in series:
        return statistics(seed, truth, radius_m)
    twin = series["twin"].first_trajectory()
    alone = truth.first_trajectory(), seed.first_trajectory()
    pairs = [statistics(seed, truth, radius_m), statistics(alone[1], twin, radius_m)]
    return growth(twin, alone[0], saturation_m2) | {
        name: float(np.mean([pair[name] for pair in pairs])) for name in pairs[0]
    }


def _balls(rollout: Rolled, square_speed: float) -> Values:
    found = {"balls_left": _balls_left(rollout)}
    if found["balls_left"]:
        found["first_left_s"] = float(rollout.crossed_s.min())
    found["stable"] = float(found["balls_left"] == 0 and square_speed < RUNAWAY)
    return found | {f"mean_{kind}_edges": number for kind, number in rollout.edges.items()}


def _balls_left(rollout: Rolled) -> float:
    return float(np.isfinite(rollout.crossed_s).sum())


def _frames_in(seconds: float, time_s: np.ndarray) -> int:
    return max(1, round(seconds / (time_s[1] - time_s[0])))
