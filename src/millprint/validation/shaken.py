"""Shaken boxes: the law of collect and collide, and balls in a box on a drive or on a spring."""

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from millprint.config.contact_set import ContactConfig
from millprint.config.geometry import BoxGeometry
from millprint.dem.few_balls import FewBalls
from millprint.dem.laws.registry import step_scale
from millprint.dem.ledger import check_closure
from millprint.dem.packing import pack
from millprint.dem.timestep import aligned_step, skin_of
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion
from millprint.mill.vessel import Vessel, shape_vessel

# At smaller amplitudes over the free gap, the pile never leaves the wall in time: no collect and collide.
LAW_END = 1 / math.pi
# Rounded tables give the end with four digits.
ROUNDING = 1e-3
# Time in which a pile comes to rest [s].
POURED_S = 1.0
LOSSES = ["normal_damping_J", "tangential_damping_J", "sliding_J", "rolling_J"]


def meeting_phase(gap_over_amplitude: float) -> float:
    """The phase tau between two walls [rad], tau - sin(tau) = G / A; nan for a gap of more than pi amplitudes.

    The pile leaves a wall with the speed A w when that wall stops pushing, at tau = 0, and meets the other at tau.
    """
    # Slow to import, and every set-up imports this module.
    from scipy.optimize import brentq

    if gap_over_amplitude > math.pi * (1 + ROUNDING):
        return math.nan
    gap = min(gap_over_amplitude, math.pi)
    return float(brentq(lambda tau: tau - math.sin(tau) - gap, 0, math.pi, xtol=1e-14))


def law_of_loss(amplitude_over_gap: float) -> float:
    """Energy that an inelastic pile of mass m loses a period over 4 m (A w)^2: (1 - cos tau)^2 / 4 [-].

    1 at the end of the law, A = G / pi, and nan below it.
    """
    return (1 - math.cos(meeting_phase(1 / amplitude_over_gap))) ** 2 / 4


def law_of_swing(amplitudes_over_gap: np.ndarray, mass_ratio: float) -> np.ndarray:
    """Periods (n,) that a box on a spring needs from the first amplitude over the gap down to each other (n,).

    A balance of energy over many periods: the energy of the box, M (A w)^2 / 2, falls by `law_of_loss` in each.
    mass_ratio: M over the mass of the balls. Amplitudes fall; the law has no regime below LAW_END.
    """
    middle = (amplitudes_over_gap[1:] + amplitudes_over_gap[:-1]) / 2
    fall = 4 / mass_ratio * middle * np.array([law_of_loss(each) for each in middle])
    return np.concatenate([[0.0], np.cumsum(-np.diff(amplitudes_over_gap) / fall)])


@dataclass(frozen=True)
class Pile:
    """Balls in a box with its floor at z = 0: centres (n, 3) [m]; radius, side of the box [m]."""

    centres: np.ndarray
    radius: float
    side: float

    @property
    def thickness(self) -> float:
        """Twice the height of the centre of mass above the floor [m]."""
        return 2 * float(self.centres[:, 2].mean())


def step_of(contact: ContactConfig, radius: float, fraction: float) -> float:
    """A step of this fraction of the contact law's time [s]; radius [m]."""
    return fraction * step_scale(contact, radius)


def pour(contact: ContactConfig, radius: float, side: float, balls: int, seed: int, fraction: float) -> Pile:
    """A pile of that many balls in a box of that side, packed by gravity; radius, side [m].

    Raises SimulationError if the balls do not fit.
    """
    # Room for twice the volume of loosely packed balls.
    height = 2 * balls * (2 * radius) ** 3 / side**2 + 4 * radius
    start = spread(radius, side, height, balls, seed)
    step = step_of(contact, radius, fraction)
    world = FewBalls(
        _box(side, height), contact, start.centres, radius=radius, step=step, skin=skin_of(radius, fraction),
        gravity=GRAVITY,
    )  # fmt: skip
    world.run(POURED_S, rows=0)
    return Pile(world.balls.position.copy(), radius, side)


def spread(radius: float, side: float, length: float, balls: int, seed: int) -> Pile:
    """Balls at rest all over a box of that side and length [m]. Raises SimulationError if they do not fit."""
    return Pile(pack(_box(side, length), 2 * radius, balls, seed, side**2 * length), radius, side)


def _box(side: float, height: float) -> Vessel:
    sides = {f"{axis}_mm": 1e3 * size for axis, size in (("x", side), ("y", side), ("z", height))}
    return shape_vessel(BoxGeometry(kind="box", **sides), "shaken box", solid=False)


class ShakenBox(FewBalls):
    """A pile in a box that moves up and down as z = a cos wt + b sin wt, at first from the lowest place.

    length: inner, from floor to lid [m]; amplitude [m]; frequency [Hz]; fraction: of the contact law's time, for a step
    of which a whole number makes a period.
    """

    def __init__(
        self, pile: Pile, contact: ContactConfig, length: float, amplitude: float, frequency_hz: float,
        fraction: float, gravity: float = 0.0,
    ) -> None:  # fmt: skip
        step, self.steps = aligned_step(step_of(contact, pile.radius, fraction), 1 / frequency_hz)
        self.frequency_hz, self.side = frequency_hz, pile.side
        wave = np.array([[2 * math.pi * frequency_hz, 0.0, 0.0, -amplitude, 0.0, 0.0, 0.0]])
        super().__init__(
            _box(pile.side, length), contact, pile.centres - [0, 0, amplitude], radius=pile.radius, step=step,
            skin=skin_of(pile.radius, fraction), gravity=gravity, motion=Motion(wave, frequency_hz),
        )  # fmt: skip
        self.mass = float(self.balls.mass[self.balls.species].sum())

    def shake(self, periods: int, closure_max: float) -> pd.DataFrame:
        """The energy ledger of whole periods, a row at the end of each. Raises SimulationError for an open balance."""
        series = self.run(periods / self.frequency_hz, self.steps, rows=0)
        assert series is not None
        check_closure(series, closure_max)
        return series

    def packed(self, periods: int) -> Pile:
        """The pile as shaking packs it: after these periods and a quarter, when the floor stops pushing it."""
        self.run((periods + 0.25) / self.frequency_hz, rows=0)
        return Pile(self.balls.position.copy(), float(self.balls.radius[0]), self.side)

    @property
    def amplitude(self) -> float:
        """The amplitude of the box [m]."""
        return float(np.hypot(*self._wave))

    @property
    def _wave(self) -> np.ndarray:
        """a and b, in the motion that the kernels read [m]."""
        return self.clock.motions.harmonics[0, 3::3]

    def momentum(self) -> float:
        """Momentum of the balls upwards [kg m/s]."""
        return float(self.balls.mass[self.balls.species] @ self.balls.velocity[:, 2])

    def swing(self, box_kg: float, periods: float, chunk: int = 4) -> pd.DataFrame:
        """Let the box swing on a spring that makes it w without balls: time [s], place [m] and amplitude [m].

        box_kg: mass M of the box. After each chunk of steps the box has lost the momentum that the balls have gained:
        its speed changes by that over M, its place does not. Between, it moves as a box without balls.
        """
        w = 2 * math.pi * self.frequency_hz
        rows = []
        before = self.momentum()
        for time in self.chunks(periods / self.frequency_hz, chunk):
            after = self.momentum()
            slower = (after - before) / (box_kg * w)
            cosine, sine = math.cos(w * time), math.sin(w * time)
            self._wave[:] += np.array([sine, -cosine]) * slower
            before = after
            rows.append((time, float(self._wave @ [cosine, sine]), self.amplitude))
        return pd.DataFrame(rows, columns=["time_s", "place_m", "amplitude_m"])


def peaks(track: pd.DataFrame) -> pd.DataFrame:
    """Where the box turns: time_s and amplitude_m of a track of `ShakenBox.swing`."""
    from scipy.signal import find_peaks

    return track.iloc[find_peaks(track["place_m"].abs())[0]]
