"""The friction pair of an oscillating ball, fitted to its track, and the experiments."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy import stats
from scipy.interpolate import CubicSpline
from scipy.optimize import differential_evolution, least_squares, minimize_scalar

from millprint.config.calibration import FRICTION_PAIR, MEASURED, SIMULATED, ExperimentConfig, SwingConfig
from millprint.config.contact_set import ContactConfig
from millprint.config.mill import MillConfig
from millprint.estimate.quantiles import f_quantile
from millprint.run.job import progress
from millprint.thesis.drop import PLACES, Swing, make_swing, read_track, simulate_track

STEP = 0.004  # of finite differences, in the logarithm
CLOSE = 1e-4  # change of a logarithm at which the search ends
NO_BETTER = 0.01  # a pair is better if S falls by this fraction of the variance of the error
NEAR = 0.15  # half width of the range, in the logarithm, that is searched again around the best pair
ROUNDS_MAX = 3  # largest number of restarts at a better pair
PROFILE_REACH = 2.0  # profiles reach this many half widths of the interval, from the curvature, to either side
NARROWEST = 0.01  # smallest half width, in the logarithm, since the curvature of a rough S is unreliable
LONGER = 3  # a profile is extended by up to this factor until it has left the interval

# Pairs that the search simulates side by side: members of its population, a power of 2.
TOGETHER = 16

Simulate = Callable[[Sequence[tuple[float, float]], float], list[CubicSpline]]
Tick = Callable[[int], object]


@dataclass
class Fit:
    """The best pair, its intervals and its profiles."""

    pair: np.ndarray  # (2,) static and rolling friction [-]
    release_s: float  # time of the track at which the ball was released
    rms_mm: float
    effective_places: float  # number of positions with independent errors
    simulations: int
    summary: pd.DataFrame  # a row for each parameter
    profile: pd.DataFrame  # parameter, value, other, excess


@dataclass
class Misfit:
    """Differences between a measured track and simulated ones."""

    track: pd.DataFrame
    simulate: Simulate
    release_uncertainty_s: float
    tick: Tick = lambda count: None
    known: dict = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.columns = [index for index, place in enumerate(PLACES) if place in self.track]
        self.times = self.track["time_s"].to_numpy()
        self.measured = self.track[[PLACES[index] for index in self.columns]].to_numpy()

    def __call__(self, logarithms: np.ndarray) -> np.ndarray:
        """Simulated less measured places (m,) [mm], column by column, with the release at its best time."""
        return self._simulated(logarithms)[0]

    def release_at(self, logarithms: np.ndarray) -> float:
        """The time of the track at which the ball was let go, for a pair [s]."""
        return self._simulated(logarithms)[1]

    def best(self) -> np.ndarray:
        """The best simulated pair (2,), in logarithms."""
        return np.array(min(self.known, key=lambda key: float((self.known[key][0] ** 2).sum())))

    def pairs_within(self, squares: float) -> np.ndarray:
        """The simulated pairs (k, 2), in logarithms, with no more than a sum of squares [mm2]."""
        return np.array([key for key, (difference, _) in self.known.items() if (difference**2).sum() <= squares])

    def learn(self, places: Iterable[np.ndarray]) -> None:
        """Simulate the pairs that are not known yet, in logarithms, side by side."""
        keys = [tuple(map(float, place)) for place in places]
        new = [key for key in dict.fromkeys(keys) if key not in self.known]
        if new:
            paths = self.simulate([tuple(np.exp(key)) for key in new], self.times[-1] + self.release_uncertainty_s)
            self.known |= {key: self._best_release(path) for key, path in zip(new, paths, strict=True)}
            self.tick(len(new))

    def _simulated(self, logarithms: np.ndarray) -> tuple[np.ndarray, float]:
        self.learn([logarithms])
        return self.known[tuple(map(float, logarithms))]

    def _best_release(self, path: CubicSpline) -> tuple[np.ndarray, float]:
        widest = self.release_uncertainty_s

        def difference(release: float) -> np.ndarray:
            # Before its release, the ball is at rest.
            places = path(np.maximum(self.times - release, 0.0))[:, self.columns]
            return (places - self.measured).T.ravel()

        if widest == 0:
            return difference(0.0), 0.0
        found = minimize_scalar(
            lambda release: float((difference(release) ** 2).sum()),
            bounds=(-widest, widest),
            method="bounded",
            options={"xatol": 1e-3 * widest},
        )
        return difference(found.x), float(found.x)

    def squares(self, logarithms: np.ndarray) -> float:
        """The sum of squares S [mm2]."""
        return float((self(logarithms) ** 2).sum())

    @property
    def parameters(self) -> int:
        """Unknowns p: the pair, and the time of the release unless it is known."""
        return 2 + (self.release_uncertainty_s > 0)

    def independent(self, difference: np.ndarray) -> float:
        """Number of places with independent errors, at least one more than there are unknowns."""
        lines = difference.reshape(len(self.columns), -1)
        correlation = max(0.0, *(float(stats.pearsonr(line[:-1], line[1:])[0]) for line in lines if np.ptp(line) > 0))
        return max(self.parameters + 1.0, difference.size * (1 - correlation) / (1 + correlation))


class _Error(NamedTuple):
    """The errors, estimated from the misfit of the best pair."""

    places: float  # with independent errors
    variance: float  # by which S is divided for the F test [mm2]
    threshold: float  # F at the probability of the interval

    @classmethod
    def of(cls, misfit: Misfit, best: np.ndarray, probability: float) -> "_Error":
        difference = misfit(best)
        places = misfit.independent(difference)
        degrees_of_freedom = places - misfit.parameters
        # Errors that go together count less: S belongs to as many places as are independent.
        variance = float((difference**2).sum()) / degrees_of_freedom
        return cls(places, variance, float(f_quantile(probability, 1, degrees_of_freedom)))


def fit_friction(
    track: pd.DataFrame, simulate: Simulate, settings: SwingConfig, probability: float, tick: Tick = lambda count: None
) -> Fit:
    """Fit (static, rolling) friction to a track: time_s and across_mm, height_mm or both.

    simulate: what gives the tracks [mm] of pairs over a time [s] (Swing.positions); tick: called with the number of
    simulations that are done.
    Raises SimulationError.
    """
    misfit = Misfit(track, simulate, settings.release_uncertainty_s, tick)
    bounds = np.log([settings.static_friction, settings.rolling_friction]).T
    best = _search(misfit, bounds, settings.search_simulations)
    for _ in range(ROUNDS_MAX):
        best = _descend(misfit, best, bounds)
        error = _Error.of(misfit, best, probability)
        profiles = _profiles(misfit, best, bounds, error, settings.profile_points)
        better = misfit.best()
        if misfit.squares(best) - misfit.squares(better) < NO_BETTER * error.variance:
            break
        best = better
    return Fit(
        pair=np.exp(best),
        release_s=misfit.release_at(best),
        rms_mm=float(np.sqrt((misfit(best) ** 2).mean())),
        effective_places=error.places,
        simulations=len(misfit.known),
        **_tables(profiles, best, misfit, error),
    )


def _tables(profiles: list[pd.DataFrame], best: np.ndarray, misfit: Misfit, error: _Error) -> dict[str, pd.DataFrame]:
    """The estimates with their intervals, and the profiles with the excess for the F test."""
    squares = misfit.squares(best)
    tables = [table.assign(excess=(table["squares_mm2"] - squares) / error.variance) for table in profiles]
    falls = np.concatenate([_falls(table["excess"].to_numpy()) for table in tables])
    threshold = error.threshold + (float(np.median(falls)) if falls.size else 0.0)
    accepted = misfit.pairs_within(squares + threshold * error.variance)
    rows = []
    for index, (name, table) in enumerate(zip(FRICTION_PAIR, tables, strict=True)):
        interval = _interval(table, threshold, accepted[:, index])
        rows.append({"parameter": name, "estimate": np.exp(best[index]), **interval, "is_steady": not falls.size})
        tables[index] = table.assign(parameter=name, threshold=threshold)
    return {"summary": pd.DataFrame(rows), "profile": pd.concat(tables, ignore_index=True)}


def _falls(excess: np.ndarray) -> np.ndarray:
    """How much a profile falls outwards from its lowest point, at each point where it does."""
    lowest = int(excess.argmin())
    steps = np.concatenate([np.diff(excess[lowest::-1]), np.diff(excess[lowest:])])
    return -steps[steps < 0]


def _search(misfit: Misfit, bounds: np.ndarray, simulations: int) -> np.ndarray:
    """The best pair (2,) of a search through the whole range and of another one around what that has found."""

    def squares(places: np.ndarray) -> np.ndarray:
        misfit.learn(places.T)
        return np.array([misfit.squares(place) for place in places.T])

    for _ in range(2):
        # A search that asks for many pairs at a time. It stops after a number of simulations, not where they are alike.
        differential_evolution(
            squares,
            list(bounds.T),
            popsize=TOGETHER // 2,
            init="sobol",
            maxiter=simulations // (2 * TOGETHER) - 1,
            tol=0,
            polish=False,
            updating="deferred",
            vectorized=True,
            rng=0,
        )
        bounds = np.clip(misfit.best() + np.array([[-NEAR], [NEAR]]), bounds[0], bounds[1])
    return misfit.best()


def _descend(misfit: Misfit, start: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """The pair of least squares that can be reached from `start`, in logarithms."""

    def jacobian(place: np.ndarray) -> np.ndarray:
        return _slopes(misfit, place, bounds)

    return least_squares(misfit, start, jac=jacobian, bounds=tuple(bounds), xtol=CLOSE, ftol=1e-7, max_nfev=40).x


def _slopes(misfit: Misfit, place: np.ndarray, bounds: np.ndarray, free: tuple[int, ...] = (0, 1)) -> np.ndarray:
    """Central differences (m, free) of the misfit by the logarithms of the free coefficients; one-sided at a bound."""
    ends = np.tile(place, (len(free), 2, 1))
    for row, index in enumerate(free):
        ends[row, :, index] = np.clip(place[index] + np.array([-STEP, STEP]), *bounds[:, index])
    misfit.learn([place, *ends.reshape(-1, len(place))])
    columns = [
        (misfit(above) - misfit(below)) / (above[index] - below[index])
        for index, (below, above) in zip(free, ends, strict=True)
    ]
    return np.array(columns).T


def _profiles(misfit: Misfit, best: np.ndarray, bounds: np.ndarray, error: _Error, points: int) -> list[pd.DataFrame]:
    """The least S with each coefficient held in turn, on both sides of the estimate: value, other, squares_mm2."""
    rise = error.threshold * error.variance
    slopes = _slopes(misfit, best, bounds)
    # How far each logarithm may go, by the curvature of S only, before the profile has risen by as much.
    half = np.maximum(np.sqrt(rise * np.diag(np.linalg.pinv(slopes.T @ slopes))), NARROWEST)
    tables = []
    for index in (0, 1):
        places = [best]
        for sign in (-1, 1):
            place = best
            for count in range(1, LONGER * points + 1):
                held = best[index] + sign * count / points * PROFILE_REACH * half[index]
                place = _with_other_free(misfit, place, bounds, index, float(np.clip(held, *bounds[:, index])))
                places.append(place)
                beyond = misfit.squares(place) - misfit.squares(best) > rise
                if not bounds[0, index] < held < bounds[1, index] or (count >= points and beyond):
                    break
        places.sort(key=itemgetter(index))
        rows = [(np.exp(place[index]), np.exp(place[1 - index]), misfit.squares(place)) for place in places]
        tables.append(pd.DataFrame(rows, columns=["value", "other", "squares_mm2"]))
    return tables


def _with_other_free(misfit: Misfit, start: np.ndarray, bounds: np.ndarray, index: int, held: float) -> np.ndarray:
    """The best pair, in logarithms, with the coefficient `index` held."""
    other = 1 - index

    def whole(free: np.ndarray) -> np.ndarray:
        place = np.empty(2)
        place[index], place[other] = held, free[0]
        return place

    found = least_squares(
        lambda free: misfit(whole(free)),
        start[[other]],
        jac=lambda free: _slopes(misfit, whole(free), bounds, (other,)),
        bounds=tuple(bounds[:, [other]]),
        xtol=CLOSE,
        ftol=1e-6,
        max_nfev=15,
    )
    return whole(found.x)


def _interval(profile: pd.DataFrame, threshold: float, accepted: np.ndarray) -> dict:
    """Where the profile leaves the interval on either side, or the outermost pair that belongs to it.

    accepted: (k,) logarithms of pairs that pass the test. lower, upper; lower_open, upper_open where the profile never
    leaves.
    """
    places, excess = np.log(profile["value"].to_numpy()), profile["excess"].to_numpy()
    found = {}
    for side, sign in (("lower", -1), ("upper", 1)):
        order = np.argsort(sign * places)
        ways, rises = places[order], excess[order]
        inside = np.flatnonzero(rises <= threshold)[-1]
        is_open = inside == len(ways) - 1
        edge = ways[inside]
        if not is_open:
            share = (threshold - rises[inside]) / (rises[inside + 1] - rises[inside])
            edge += share * (ways[inside + 1] - ways[inside])
        found[side] = float(np.exp(sign * max(sign * edge, *(sign * accepted))))
        found[f"{side}_open"] = bool(is_open)
    return found


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
    intervals [-]. Tables: track (as fitted), fit (a row a coefficient), profile, and paths (of the fitted and of varied
    pairs). Raises ConfigError and SimulationError.
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
        "given": [np.nan if measured else contact.value_of(name) for name in FRICTION_PAIR],
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
    for index, (pair, positions) in enumerate(zip(pairs, swing.positions(pairs, duration), strict=True)):
        places = positions(times)
        path = {"path": VARIED if index else FITTED, **dict(zip(FRICTION_PAIR, pair, strict=True))}
        path |= {"time_s": times + release, **dict(zip(PLACES, places.T, strict=True))}
        tables.append(pd.DataFrame(path))
    return pd.concat(tables, ignore_index=True)
