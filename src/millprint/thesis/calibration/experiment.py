"""An oscillation experiment: from the track to the tables of the fit."""

import numpy as np
import pandas as pd

from millprint.config.calibration import ExperimentConfig, SwingConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.run.progress import progress
from millprint.thesis.calibration.friction_fit import Fit, fit_friction
from millprint.thesis.calibration.names import FRICTION_PAIR, MEASURED, SIMULATED
from millprint.thesis.calibration.oscillation import (
    PLACES,
    Swing,
    describe_swings,
    make_swing,
    read_track,
    simulate_track,
)

FITTED, VARIED = "fit", "varied"
PATH_STEP_S = 2e-3


def fit_experiment(
    experiment: ExperimentConfig,
    mills: dict[str, MillConfig],
    contact: ContactConfig,
    rayleigh_fraction_max: float,
    settings: SwingConfig,
    interval: float,
) -> dict[str, pd.DataFrame]:
    """Fit the friction pair of one experiment; mills: by the keys `mill` and `track_mill` of the experiment.

    rayleigh_fraction_max: longest step, over the Rayleigh time of the ball [-]; interval: probability of the confidence
    intervals [-]. Tables: track (as fitted), fit (a row a coefficient), profile, paths (of the fitted and of varied
    pairs) and swings (what those look like in numbers). Raises ConfigError and SimulationError.
    """
    diameter, contact = experiment.ball_diameter_mm * 1e-3, contact.at_wall
    swing = make_swing(mills["mill"], contact, rayleigh_fraction_max, diameter, settings)
    if experiment.track:
        track = read_track(experiment.track)
    else:
        released = make_swing(mills["track_mill"], contact, rayleigh_fraction_max, diameter, settings)
        track = simulate_track(released, settings)
    with progress(None, f"fitting {experiment.name}", " simulations") as bar:
        fit = fit_friction(track, swing.positions, settings, interval, bar.update)
    pairs = [tuple(fit.pair), *settings.varied]
    duration = float(track["time_s"].iloc[-1])
    return {
        "track": track,
        "fit": _fit_table(experiment, mills, contact, fit, len(track)),
        "profile": fit.profile,
        "paths": _paths(swing, pairs, duration, fit.release_s),
        "swings": describe_swings(swing, pairs, duration),
    }


def _fit_table(
    experiment: ExperimentConfig, mills: dict[str, MillConfig], contact: ContactConfig, fit: Fit, frames: int
) -> pd.DataFrame:
    """A row a coefficient, with what the track was and how well it is met; `given` is empty for a measured track."""
    measured = bool(experiment.track)
    known = {
        "experiment": experiment.name,
        "source": MEASURED if measured else SIMULATED,
        "contact": contact.name,
        "mill": mills["mill"].name,
        "track_mill": "" if measured else mills["track_mill"].name,
        "parameter": FRICTION_PAIR,
        "given": [np.nan if measured else getattr(contact, name) for name in FRICTION_PAIR],
    }
    table = pd.DataFrame(known).merge(fit.summary, on="parameter")
    return table.assign(
        deviation_percent=100 * (table["estimate"] / table["given"] - 1),
        rms_mm=fit.rms_mm,
        release_s=fit.release_s,
        frames=frames,
        independent_places=fit.effective_places,
        simulations=fit.simulations,
    )


def _paths(swing: Swing, pairs: list[tuple[float, float]], duration: float, release: float) -> pd.DataFrame:
    """Simulated paths, the first being the fit: path, static_friction, rolling_friction, time_s and the places."""
    times = np.arange(0, duration, PATH_STEP_S)
    tables = []
    for index, pair in enumerate(pairs):
        places = swing.positions(pair, duration)(times)
        path = {"path": VARIED if index else FITTED, **dict(zip(FRICTION_PAIR, pair, strict=True))}
        path |= {"time_s": times + release, **dict(zip(PLACES, places.T, strict=True))}
        tables.append(pd.DataFrame(path))
    return pd.concat(tables, ignore_index=True)
