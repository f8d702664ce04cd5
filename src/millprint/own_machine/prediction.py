"""What `warm` and `watt` share: the prediction of a finished card, the verdict, and the user's table.

Power in the charge from a wattmeter: with loose balls, less that with the same balls fixed.

Fixed balls have the same mass, so that motor, bearings and air take the same power; only loose balls dissipate. Of
the additional electric power, the share `efficiency` reaches the balls.

Power from the warming of a jar: the heat balance of `millprint.dose.heat_balance`, turned round.

The balance is linear in the power P, so that a reading is T(t) = T0 + P u(t), where u is the warming by 1 W. What
nobody knows of the jar (heat transfer inside and outside, where heat is released, heat capacities) is sampled from the
ranges of `dose.heat`. Each sample has its own best P, and weighs exp(-S / 2 s^2 k): S, sum of squared residuals; s^2,
variance of the best sample's; k, how many neighbouring residuals tell the same. The interval is that of the weighted P.
"""

import datetime
from argparse import Namespace
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from millprint.card.card_files import charge_in_words
from millprint.card.card_model import MillingCard
from millprint.card.read import read_card
from millprint.config.errors import ConfigError
from millprint.dose.heat_balance import Balance, solve
from millprint.estimate.estimates import LEVEL, WIDEST, Estimate, Interval, difference_of
from millprint.estimate.judge import OPEN, Verdict, judge
from millprint.fingerprint.bands import ORIGINS
from millprint.own_machine.readings import append_measured
from millprint.own_machine.settings import WattSettings
from millprint.run.files import read_json
from millprint.validation.waiting import POWER, fixed_before

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Blocks of a series, each long against the time in which its values forget each other; 10 to 30 are usual (Schmeiser,
# Operations Research 30 (1982) 556).
BLOCKS = 10


def block_means(time_s: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Means (BLOCKS,) of a series over parts of equal time; a part without a reading raises ValueError."""
    edges = np.linspace(time_s[0], time_s[-1], BLOCKS + 1)
    place = np.searchsorted(edges[1:-1], time_s, side="right")
    counts = np.bincount(place, minlength=BLOCKS)
    if not counts.all():
        raise ValueError(f"a tenth of the time without a reading, from {edges[counts.argmin()]:g} s on")
    return np.bincount(place, weights=values, minlength=BLOCKS) / counts


def power_of_charge(loose: np.ndarray, fixed: np.ndarray, settings: WattSettings) -> tuple[Estimate, Estimate]:
    """Difference of the electric power, and power in the balls of one jar [W]; its interval holds both ranges.

    loose, fixed: means of blocks of the electric power [W] (n,).
    """
    electric = difference_of(loose, fixed, "W")
    low, high = settings.efficiency_low, settings.efficiency_high
    ends = [end * share for end in electric.ends("repeats") for share in (low, high)]
    charge = Estimate(electric.value * (low + high) / 2, "W", repeats=Interval(min(ends), max(ends)), how="measured")
    return electric, charge * (1 / settings.jars)


# Samples that must count, so that their quantiles mean something.
FEWEST_SAMPLES = 50
# Residuals of more than this many resolutions of the thermometer are not noise.
LARGEST_RESIDUAL = 3.0


@dataclass(frozen=True)
class Warming:
    """What a table of temperatures says."""

    power_W: Estimate
    """power in balls and powder while the mill ran"""
    model_degC: np.ndarray
    """temperatures of the best sample at the times of the table (m,)"""
    begin_K_min: float
    """its warming at the start [K/min]"""
    residual_K: float
    """root mean square of the readings about it"""
    resolution_K: float

    @property
    def described(self) -> bool:
        """Whether the balance describes the readings."""
        return self.residual_K <= LARGEST_RESIDUAL * self.resolution_K


def unit_response(balance: Balance, time_s: np.ndarray, start_s: float, stop_s: float, body: int) -> np.ndarray:
    """Warming (m, n) of a body at the times by the balance's sources from start to stop; 0 before the start [K].

    balance: with surroundings of 0 degC.
    """
    running, end = min(stop_s, time_s[-1]) - start_s, time_s[-1] - start_s
    phases = [(0.0, running, True), *([(running, end, False)] if end > running else [])]
    later = time_s[time_s > start_s] - start_s
    course = solve(balance, phases, np.append(0.0, later))
    found = np.zeros((len(time_s), len(balance)))
    found[len(time_s) - len(later) :] = course.temperature_degC[1:, :, body]
    return found


def fit_power(response_K: np.ndarray, time_s: np.ndarray, temperature_degC: np.ndarray, resolution_K: float) -> Warming:
    """The power that warmed a body, from readings (m,); response_K: `unit_response` of 1 W (m, n)."""
    centred = response_K - response_K.mean(axis=0)
    squares = (centred**2).sum(axis=0)
    over = temperature_degC - temperature_degC.mean()
    power = over @ centred / squares
    residual = over[:, None] - power * centred
    misfit = (residual**2).sum(axis=0)
    best = int(misfit.argmin())
    variance = max(misfit[best] / (len(over) - 3), resolution_K**2 / 12)
    alike = _alike(residual[:, best])
    weights = _weights((misfit - misfit[best]) / (2 * variance * alike))
    noise = np.random.default_rng(0).standard_normal(len(power)) * np.sqrt(variance * alike / squares)
    lower, median, upper = weighted_quantiles(power + noise, weights, [(1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2])
    model = temperature_degC.mean() + power[best] * centred[:, best]
    warms = np.flatnonzero(response_K[:, best] > 0)[:2]
    begin = np.diff(model[warms])[0] / np.diff(time_s[warms])[0] * 60
    power_W = Estimate(float(median), "W", repeats=Interval(float(lower), float(upper)), how="measured")
    return Warming(power_W, model, float(begin), float(np.sqrt(variance)), resolution_K)


def _alike(residual: np.ndarray) -> float:
    """How many neighbouring residuals tell the same: (1 + r) / (1 - r), with the correlation r of neighbours."""
    total = (residual**2).sum()
    r = (residual[1:] * residual[:-1]).sum() / total if total else 0.0
    return float(np.clip((1 + r) / (1 - r), 1.0, len(residual) / 4))


def _weights(exponent: np.ndarray) -> np.ndarray:
    """exp(-exponent) (n,), flattened until FEWEST_SAMPLES count, which widens the interval."""
    while True:
        weights = np.exp(-exponent)
        if weights.sum() ** 2 >= min(FEWEST_SAMPLES, len(weights)) * (weights**2).sum():
            return weights
        exponent = exponent / 1.5


def weighted_quantiles(values: np.ndarray, weights: np.ndarray, shares: Sequence[float]) -> np.ndarray:
    """Quantiles of weighted values (n,): the smallest value below which at least the share of the weight lies."""
    order = np.argsort(values)
    below = np.cumsum(weights[order]) / weights.sum()
    return values[order][np.searchsorted(below, np.asarray(shares) * (1 - 1e-12)).clip(0, len(values) - 1)]


HOW = "`millprint card card.yaml --out FOLDER` simulates a condition"


@dataclass(frozen=True)
class Condition:
    """A card with its simulations: folders with run.h5 and summary.json."""

    card: MillingCard
    runs: list[Path]

    @property
    def summaries(self) -> list[dict]:
        """The summary of each run."""
        return [read_json(run / "summary.json") for run in self.runs]

    @property
    def words(self) -> str:
        """Mill, speed and balls in a few words."""
        return f"{self.card.machine.name}, {self.card.machine.speed}, {charge_in_words(self.card.balls)}"

    def row(self, quantity: str, unit: str, measured: Estimate, note: str) -> dict[str, str]:
        """A row of the table of own measurements, without an id that is surely its own."""
        hull = measured.hull()
        half = max(hull.upper - measured.value, measured.value - hull.lower)
        return {
            "id": f"{self.card.name}_{quantity.replace(' ', '_')}",
            "mill": self.card.machine.name,
            "description": self.words,
            "quantity": quantity,
            "value": f"{measured.value:.4g}",
            "unit": unit,
            "uncertainty": f"{half:.3g}",
            "uncertainty_unit": unit,
            "note": f"{note}; card of mill {self.card.digests.get('mill', '')[:12]}",
        }


def read_condition(folder: str | Path) -> Condition:
    """The card in a folder of `millprint card`. Raises ConfigError, in one line, if card or runs are not there."""
    place = Path(folder)
    if not (place / "card.json").is_file():
        raise ConfigError(f"{folder}: no card.json in it, so nothing is predicted yet; {HOW}")
    runs = sorted(path.parent for path in place.glob("runs/seed_*/run.h5"))
    if not runs:
        raise ConfigError(f"{folder}: no runs/seed_*/run.h5 in it, the simulations of the card; {HOW}")
    return Condition(read_card(place / "card.json"), runs)


def predicted_power(condition: Condition) -> Estimate:
    """The predicted power of the walls, which a meter sees, with the intervals that judge a long measurement."""
    return replace(condition.card.fingerprint.descriptors.wall_power_W, scatter=None, how="predicted")


def origins_of(predicted: Estimate) -> str:
    """What the intervals of a prediction hold, in words."""
    known = ", ".join(ORIGINS[name].title for name in predicted.intervals)
    words = f"by {known}" if known else "without an interval"
    return words if predicted.contact else f"{words}; contact parameters not analysed"


def say_power(condition: Condition, measured: Estimate, date: str | None, doubt: str = "") -> str:
    """Print a measured power and the predicted one; returns the verdict with the prediction.

    date: day of the measurement, now if None: what was fixed later does not judge it. doubt: why the measurement
    decides nothing.
    """

    def judged(prediction: Estimate) -> Verdict:
        return Verdict(OPEN, doubt) if doubt else judge(prediction, measured, widest=WIDEST)

    predicted = predicted_power(condition)
    verdict = judged(predicted)
    print(f"measured power: {measured}\npredicted power: {predicted} ({origins_of(predicted)})\nverdict: {verdict}")
    if said := condition.card.fingerprint.against:
        print(said)
    note = f"predicted {predicted}: {verdict}"
    if (row := _fixed_power(condition, date)) is None:
        return note
    fixed = Estimate(row["value"], "W", mean=Interval(row["lower"], row["upper"]), how="predicted")
    verdict = judged(fixed)
    print(f"fixed for release {row['release']} on {row['date']} UTC: {fixed}: {verdict}")
    return f"{note}; fixed on {row['date']}, digest {row['digest']}: {fixed}: {verdict}"


def _fixed_power(condition: Condition, date: str | None) -> dict | None:
    """The power that was fixed before for balls of one size in an included mill; None if there is none."""
    card = condition.card
    if len(card.balls.sizes) > 1:
        return None
    diameter_mm = card.balls.sizes[0].diameter_mm
    date = date or datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M")
    return fixed_before(date, card.machine.name, diameter_mm, card.balls.fill_ratio, card.machine.speed_rpm, POWER)


def keep(options: Namespace, row: dict[str, str], figure: "Figure | None") -> None:
    """Add the row to the user's table and write the figure, where they were asked for."""
    if options.table:
        print(f"{options.table}: row {append_measured(options.table, row)}")
    if figure and options.figure:
        # Slow to import, and only a figure needs it.
        from millprint.figures.style import both_of, save

        svg, png = both_of(options.figure)
        save(figure, svg, png)
        print(png)
