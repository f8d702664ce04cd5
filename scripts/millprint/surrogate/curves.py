"""Tables behind the figures of a roll-out: errors and dissipation over time, and distributions."""

import numpy as np
import pandas as pd

from millprint.surrogate import measures
from millprint.surrogate.evaluation import INCREMENT_S
from millprint.surrogate.series import Series

SERIES = ("surrogate", "dem", "other_seed")


def error_table(series: dict[str, Series], test: str) -> pd.DataFrame:
    """Position errors over time, averaged over the batch: of the roll-out, the twin, another seed, the centre of mass.

    A twin is that of the batch's first trajectory alone.
    """
    truth = series["dem"]
    columns = {
        f"{name}_m2": measures.position_error(series[name].position_m, truth.position_m).mean(axis=1)
        for name in ("surrogate", "other_seed")
    }
    if "twin" in series:
        pair = (series[name].first_trajectory().position_m for name in ("twin", "dem"))
        columns["twin_m2"] = measures.position_error(*pair)[:, 0]
    columns["centroid_m2"] = measures.centroid_error(truth.position_m).mean(axis=1)
    return pd.DataFrame({"test": test, "time_s": truth.time_s, **columns})


def dissipation_table(series: dict[str, Series], members_J: np.ndarray | None, test: str) -> pd.DataFrame:
    """Cumulative dissipation over time, averaged over the batch, of every series.

    members_J (frames, members): that of each member of an ensemble, where there is one; `spread_J` is its deviation.
    """
    columns = {f"{name}_J": part.cumulative_J.mean(axis=1) for name, part in series.items()}
    if members_J is not None:
        columns["spread_J"] = members_J.std(axis=1, ddof=1)
    return pd.DataFrame({"test": test, "time_s": series["dem"].time_s, **columns})


def distribution_table(series: dict[str, Series], radius_m: float, test: str, bins: int = 50) -> pd.DataFrame:
    """Probability densities of speed [m/s], wall distance [m], contacts of a ball [-] and increments over 5 ms [J].

    Of the surrogate, the simulation and another seed, between `low` and `high` of each bin.
    """
    times = series["dem"].time_s
    step = max(1, round(INCREMENT_S / (times[1] - times[0])))
    quantities = {
        "speed_m_s": lambda part: part.speed(),
        "wall_distance_m": lambda part: part.wall_distance_m,
        "contacts": lambda part: part.contacts(radius_m),
        "increment_5ms_J": lambda part: measures.increments(part.cumulative_J, step),
    }
    tables = [
        _densities({name: sample(series[name]) for name in SERIES}, quantity, bins)
        for quantity, sample in quantities.items()
    ]
    return pd.concat(tables, ignore_index=True).assign(test=test)


def _densities(samples: dict[str, np.ndarray], quantity: str, bins: int) -> pd.DataFrame:
    samples = {name: values[np.isfinite(values)] for name, values in samples.items()}
    simulated = np.concatenate([samples["dem"], samples["other_seed"]])
    if quantity == "contacts":
        edges = np.arange(simulated.max() + 3) - 0.5
    else:
        low, high = min(0.0, simulated.min()), np.quantile(simulated, 0.999) * 1.3
        # Of balls at rest there is nothing to spread.
        edges = np.linspace(low, max(high, low + np.finfo(float).eps), bins + 1)
    # Values off the scale stay in the total, so that a density of a run-away roll-out is small and not rescaled.
    counts = {name: np.histogram(values, edges)[0] / max(1, len(values)) for name, values in samples.items()}
    places = {"quantity": quantity, "low": edges[:-1], "high": edges[1:]}
    return pd.DataFrame(places | {name: share / np.diff(edges) for name, share in counts.items()})
