"""Impacts a second of a recording and of a simulation, over their loudness.

What energy a loudness stands for is not known, unless one ball was dropped from a known height. Without it, the energy
is sought at which the simulation has the measured rate, at several loudnesses: amplitude ~ energy^b. A ball's speed
gives amplitude ~ speed, b = 1/2; Hertz's contact and the loss of restitution with speed widen that to PLAUSIBLE.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.fingerprint.readers import PAIRS, Contacts
from millprint.mill.gravity import GRAVITY
from millprint.own_machine.estimates import CANNOT, Estimate, mean_of, verdict_on, weighted_quantiles
from millprint.own_machine.settings import ListenSettings
from millprint.own_machine.sound import Ear, Heard, impacts_in
from millprint.statistics.quantiles import LEVEL

# Exponents b that a wall, a microphone and a contact may have.
PLAUSIBLE = (0.35, 0.7)
# How far the loudness of a drop may be from that of a collision of its energy: place, angle, closed lid [dB].
DROP_DB = 2.0
# Next to the floor, the loudnesses that these shares of the impacts exceed are compared, if enough impacts do.
SHARES, FEWEST_IMPACTS = (0.8, 0.6, 0.45, 0.3, 0.2, 0.1), 30
# Blocks of a recording.
FEWEST_BLOCKS, BLOCK_S = 10, 1.0
DRAWS = 400
# Share of the time that dead times may take.
MOST_OVERLAP = 0.3
# Collisions of less than 1e-15 J make no sound.
SILENCE_DB = -150.0
SPACINGS = (0.1, 0.5, 0.9)
ENDS = ((1 - LEVEL) / 2, (1 + LEVEL) / 2)


@dataclass(frozen=True)
class Series:
    """Impacts in order of time: time [s], size (dB, or J of predicted ones) and block, in blocks of equal length."""

    time_s: np.ndarray
    size: np.ndarray
    block: np.ndarray
    blocks: int
    block_s: float

    @classmethod
    def of(cls, time_s: np.ndarray, size: np.ndarray, blocks: int, block_s: float) -> "Series":
        """The series of times that count from its start."""
        return cls(time_s, size, np.minimum((time_s / block_s).astype(int), blocks - 1), blocks, block_s)

    def over(self, size: float) -> np.ndarray:
        """Impacts a second (blocks,) of at least this size."""
        return np.bincount(self.block[self.size >= size], minlength=self.blocks) / self.block_s

    def rising(self, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sizes, falling, and the impacts a second of at least each size; weight: how often each block counts."""
        order = np.argsort(-self.size)
        return self.size[order], np.cumsum(weight[self.block[order]]) / weight.sum() / self.block_s

    def spacings(self, size: float, weight: np.ndarray) -> np.ndarray:
        """Quantiles SPACINGS of the time between impacts of at least a size [s]."""
        kept = self.size >= size
        often = weight[self.block[kept][:-1]]
        if not often.any():
            return np.full(len(SPACINGS), np.nan)
        return weighted_quantiles(np.diff(self.time_s[kept]), often, SPACINGS)


def joined(runs: Sequence[Series]) -> Series:
    """The series of several runs one after the other, with blocks of one length."""
    blocks = np.cumsum([0, *(run.blocks for run in runs)])
    starts = blocks * runs[0].block_s
    return Series(
        np.concatenate([run.time_s + start for run, start in zip(runs, starts, strict=False)]),
        np.concatenate([run.size for run in runs]),
        np.concatenate([run.block + first for run, first in zip(runs, blocks, strict=False)]),
        int(blocks[-1]),
        runs[0].block_s,
    )


def recorded(heard: Heard, duration_s: float) -> Series:
    """The impacts of a recording, in blocks of about BLOCK_S."""
    blocks = max(int(duration_s / BLOCK_S), FEWEST_BLOCKS)
    return Series.of(heard.time_s, heard.loudness_dB, blocks, duration_s / blocks)


def predicted(contacts: Contacts, frequency_hz: float, ear: Ear, settings: ListenSettings) -> Series:
    """The collisions of a run as they are heard, a block for each turn of the mill.

    The power of a sound is taken to go with the normal energy that a collision dissipates, b = 1/2. Collisions ring and
    echo as in the recording; powers of sounds at one time add up. The size of an impact is the energy that sounds then.
    """
    rows = contacts.ordered("surface")
    of_pair = (rows["second"].to_numpy() < 0) | (settings.pair != PAIRS[1])
    time_s, energy = rows["start_s"].to_numpy() - contacts.begin_s, rows["normal_J"].to_numpy()
    chosen = of_pair & (time_s >= 0) & (energy > 0)
    heard = through_ear(time_s[chosen], energy[chosen], contacts.window_s, ear, settings)
    turns = max(int(contacts.window_s * frequency_hz * (1 + 1e-9)), 1)
    kept = heard.time_s < turns / frequency_hz
    return Series.of(heard.time_s[kept], 10 ** (heard.loudness_dB[kept] / 10), turns, 1 / frequency_hz)


def through_ear(time_s: np.ndarray, energy_J: np.ndarray, window_s: float, ear: Ear, settings: ListenSettings) -> Heard:
    """Which collisions are heard apart; the loudness of a single one of 1 J is 0 dB."""
    # A peak needs a value before it.
    train = np.zeros(int(window_s * ear.track_hz) + 3)
    np.add.at(train, (time_s * ear.track_hz).astype(int) + 1, energy_J)
    power = np.maximum(np.convolve(train, ear.response)[: len(train)], np.finfo(float).tiny)
    heard = impacts_in(10 * np.log10(power), ear.track_hz, np.full(len(train), SILENCE_DB), settings)
    return Heard(heard.time_s - 1 / ear.track_hz, heard.loudness_dB)


def levels_of(measured: Series, floor_dB: float) -> np.ndarray:
    """The loudnesses that are compared: the floor, and those that SHARES of the impacts exceed [dB]."""
    shares = [share for share in SHARES if share * len(measured.size) >= FEWEST_IMPACTS]
    return np.array([floor_dB, *np.quantile(measured.size, [1 - share for share in shares])])


@dataclass(frozen=True)
class Comparison:
    """What a recording tells about a simulation."""

    levels: pd.DataFrame
    """a row for each loudness: impacts a second, and the energy over which the simulation has as many"""
    exponent: Estimate
    """b of amplitude ~ energy^b over the loudnesses above the floor; NaN for fewer than two"""
    spacing_ms: pd.DataFrame
    """quantiles of the time between impacts over the floor, measured and, at the same rate, predicted [ms]"""
    all_hz: Estimate
    """predicted impacts a second of any energy that could be told apart"""


def compare(measured: Series, simulated: Series, floor_dB: float, seed: int = 0) -> Comparison:
    """The rates over each loudness, matched energies and spacings; intervals by a bootstrap of both sets of blocks."""
    levels = levels_of(measured, floor_dB)
    counts = np.array([measured.over(level) for level in levels])
    rng = np.random.default_rng(seed)
    own, others = (_weights(series.blocks, rng) for series in (measured, simulated))
    matched = np.array(
        [
            _matched(np.average(counts, axis=1, weights=one), *simulated.rising(other))
            for one, other in zip(own, others, strict=True)
        ]
    )
    lower, upper = np.quantile(matched[1:], ENDS, axis=0)
    table = pd.DataFrame([mean_of(row) for row in counts]).set_axis(["impacts_hz", "lower_hz", "upper_hz"], axis=1)
    table.insert(0, "over_floor_dB", levels - floor_dB)
    table = table.assign(energy_J=matched[0], energy_lower_J=lower, energy_upper_J=upper)
    heard = 1e3 * np.array([measured.spacings(floor_dB, one) for one in own])
    spacing = pd.DataFrame(
        {
            "share": SPACINGS,
            "measured_ms": heard[0],
            **dict(zip(("lower_ms", "upper_ms"), np.nanquantile(heard[1:], ENDS, axis=0), strict=True)),
            "predicted_ms": 1e3 * simulated.spacings(matched[0, 0], others[0]),
        }
    )
    return Comparison(table, _exponent(levels, matched), spacing, mean_of(simulated.over(0.0)))


def _weights(blocks: int, rng: np.random.Generator) -> np.ndarray:
    """How often each block counts (1 + DRAWS, blocks): once, then in each draw of a bootstrap."""
    drawn = rng.multinomial(blocks, np.full(blocks, 1 / blocks), size=DRAWS)
    return np.vstack([np.ones(blocks, dtype=int), drawn])


def _matched(rates_hz: np.ndarray, size: np.ndarray, rising_hz: np.ndarray) -> np.ndarray:
    """The energies over which a simulation has these rates, as of `Series.rising`; its smallest where it has fewer."""
    return np.exp(np.interp(rates_hz, rising_hz, np.log(size)))


def _exponent(levels_dB: np.ndarray, energy_J: np.ndarray) -> Estimate:
    """b of all loudnesses, from the slope of the energy over the loudness, whose error is smaller.

    energy_J: matched (1 + draws, levels).
    """
    if len(levels_dB) < 3:
        return Estimate(np.nan, np.nan, np.nan)
    # Nearly all impacts may be over the floor, so that it matches no energy.
    levels_dB, energy_J = levels_dB[1:], energy_J[:, 1:]
    over = (levels_dB - levels_dB.mean()) / 20 * np.log(10)
    exponents = (over**2).sum() / np.maximum(np.log(energy_J) @ over, 1e-9)
    return Estimate(float(exponents[0]), *map(float, np.quantile(exponents[1:], ENDS)))


@dataclass(frozen=True)
class Drop:
    """One ball dropped onto the wall: its loudness over the floor of the recording, and the energy that it lost."""

    over_floor_dB: float
    energy_J: float


def energy_of_drop(mass_kg: float, height_m: float, restitution: float) -> float:
    """Energy that a ball loses at its first bounce after a fall from rest, (1 - e^2) m g h [J]."""
    return (1 - restitution**2) * mass_kg * GRAVITY * height_m


def place_of(comparison: Comparison, drop: Drop | None) -> int:
    """The compared loudness that a verdict is on: that nearest to a drop's, or the floor."""
    levels = comparison.levels["over_floor_dB"].to_numpy()
    return int(np.abs(levels - drop.over_floor_dB).argmin()) if drop else 0


def rate_at(comparison: Comparison, place: int) -> Estimate:
    """The measured impacts a second over a compared loudness."""
    return Estimate(*comparison.levels.loc[place, ["impacts_hz", "lower_hz", "upper_hz"]])


def rate_over_drop(comparison: Comparison, simulated: Series, drop: Drop) -> Estimate:
    """The predicted impacts a second over the energy of the loudness of `place_of`.

    The interval holds all PLAUSIBLE exponents and a drop that is louder or quieter by DROP_DB.
    """
    away_dB = comparison.levels["over_floor_dB"][place_of(comparison, drop)] - drop.over_floor_dB
    tried = [(0.5, 0.0), *((b, more) for b in PLAUSIBLE for more in (-DROP_DB, DROP_DB))]
    rates = [mean_of(simulated.over(drop.energy_J * 10 ** ((away_dB + more) / 20 / b))) for b, more in tried]
    return Estimate(rates[0].value, max(min(rate.lower for rate in rates), 0.0), max(rate.upper for rate in rates))


def verdict_of(comparison: Comparison, simulated: Series, settings: ListenSettings, drop: Drop | None = None) -> str:
    """The verdict of the recording on the prediction; with the energy of a drop, on its number."""
    rate, exponent = rate_at(comparison, place_of(comparison, drop)), comparison.exponent
    if rate.value * 1e-3 * settings.dead_ms > MOST_OVERLAP:
        return f"{CANNOT}: impacts follow each other too closely to be told apart"
    if drop:
        return verdict_on(rate, rate_over_drop(comparison, simulated, drop))
    if rate.lower > comparison.all_hz.upper:
        return verdict_on(rate, comparison.all_hz)
    if exponent.lower > PLAUSIBLE[1] or exponent.upper < PLAUSIBLE[0]:
        return f"the loudness is spread otherwise than predicted: amplitude ~ energy^{exponent}"
    row = comparison.levels.loc[0]
    ends = f"{row['energy_J']:.2g} J ({row['energy_lower_J']:.2g} to {row['energy_upper_J']:.2g} J)"
    return f"{CANNOT} from only the rate: it agrees if impacts of over {ends} are heard"
