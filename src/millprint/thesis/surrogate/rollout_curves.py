"""Tables for the figures of a roll-out: errors and dissipation over time, and distributions."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from millprint.thesis.surrogate import measures
from millprint.thesis.surrogate.rollout import RollOut
from millprint.thesis.surrogate.rollout_evaluation import increments_J

DRAWN = ("surrogate", "dem", "other_seed")


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


def distribution_table(rollouts: dict[str, RollOut], radius_m: float, test: str, bins: int = 50) -> pd.DataFrame:
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
        _densities({name: sample(rollouts[name]) for name in DRAWN}, quantity, bins)
        for quantity, sample in samples.items()
    ]
    return pd.concat(tables, ignore_index=True).assign(test=test)


def _densities(samples: dict[str, np.ndarray], quantity: str, bins: int) -> pd.DataFrame:
    samples = {name: values[np.isfinite(values)] for name, values in samples.items()}
    simulated = np.concatenate([samples["dem"], samples["other_seed"]])
    if quantity == "contacts":
        edges = np.arange(simulated.max() + 3) - 0.5
    else:
        low, high = min(0.0, simulated.min()), np.quantile(simulated, 0.999) * 1.3
        # Balls at rest have no spread.
        edges = np.linspace(low, max(high, low + np.finfo(float).eps), bins + 1)
    # Values off the scale stay in the total, so that a density of a run-away roll-out is small and not rescaled.
    counts = {name: np.histogram(values, edges)[0] / max(1, len(values)) for name, values in samples.items()}
    places = {"quantity": quantity, "low": edges[:-1], "high": edges[1:]}
    return pd.DataFrame(places | {name: share / np.diff(edges) for name, share in counts.items()})
