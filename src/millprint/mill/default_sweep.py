"""The sweep of a mill that has none, from the size of its vessel and the way its walls agitate the balls."""

import math

import numpy as np

from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.config.mill_sweep import MillSweepConfig
from millprint.config.motion_kinds import Agitation
from millprint.mill.bodies import Body, build_bodies, travel_m
from millprint.mill.gravity import GRAVITY

# Commercial ball sizes [mm], and the largest share of the vessel's narrowest inside that a ball may take.
BALL_SIZES_MM = (0.5, 1, 1.5, 2, 3, 4, 5, 6, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 80, 100)
WIDEST = 1 / 5
# Largest number of balls in a case, so that a sweep takes minutes.
BALLS_MAX = 600
# Shares of the critical speed of a drum; accelerations of a shaken wall over gravity; speeds of a stirrer's tip [m/s].
CRITICAL, SHAKEN, TIP = (0.6, 0.8), (6.0, 12.0), (0.5, 0.9)
DIGITS = 2


def _rounded(value: float) -> float:
    """A value rounded to two digits, as people choose them."""
    return float(f"{value:.{DIGITS}g}")


def _sizes_mm(vessel_bounds: np.ndarray, volume_m3: float, largest_fill: float) -> list[float]:
    """Two commercial sizes: large enough for few balls, small enough for the vessel; the larger first."""
    narrowest = float(np.ptp(vessel_bounds, axis=0).min()) * 1e3
    fewest = (largest_fill * volume_m3 / (math.pi / 6 * BALLS_MAX)) ** (1 / 3) * 1e3
    fitting = [size for size in BALL_SIZES_MM if size <= narrowest * WIDEST] or [_rounded(narrowest * WIDEST)]
    larger = next((size for size in fitting if size >= fewest), fitting[-1])
    following = [size for size in fitting if size > larger]
    return [following[0], larger] if following else [larger, _rounded(0.8 * larger)]


def _tumbled(mill: MillConfig, bodies: list[Body], diameter_m: float) -> list[float]:
    """Speeds of a drum [rpm], by its critical speed."""
    reach = travel_m(bodies)
    critical = math.sqrt(GRAVITY / max(reach - diameter_m / 2, diameter_m / 2)) / mill.motion.drive().own_turns
    return [_rounded(share * critical * 30 / math.pi) for share in CRITICAL]


def _stirred(mill: MillConfig, bodies: list[Body], diameter_m: float) -> list[float]:
    """Speeds of a mill whose vessel stands still [rpm], by the tip of its stirrer."""
    reach = travel_m(bodies)
    if reach == 0:
        raise ConfigError(f"config/mills/{mill.name}.yaml: motion: nothing in this mill moves, so no speeds suit it")
    own_turns = [insert.motion.drive().own_turns for insert in mill.inserts if insert.motion]
    return [_rounded(speed / reach / max(own_turns, default=1.0) * 30 / math.pi) for speed in TIP]


def _shaken(mill: MillConfig, bodies: list[Body], diameter_m: float) -> list[float]:
    """Speeds of a shaken vessel [rpm], by the largest acceleration of its middle."""
    # At one turn a second, by differences over the turn.
    step = 1e-4
    times = np.linspace(0.001, 1.001, 721)
    middle = bodies[0].vessel.bounds.mean(axis=0)
    motion = bodies[0].motion
    before, at, after = (motion.rotation(t) @ middle + motion.position(t) for t in (times - step, times, times + step))
    largest = float(np.linalg.norm(before - 2 * at + after, axis=1).max()) / step**2
    return [_rounded(60 * math.sqrt(share * GRAVITY / largest)) for share in SHAKEN]


# By the agitation of the vessel: its speeds; fill ratios, and those around a stirrer.
SPEEDS_OF = {Agitation.SHAKEN: _shaken, Agitation.TUMBLED: _tumbled, Agitation.STILL: _stirred}
FILLS, STIRRED_FILLS = [0.08, 0.15, 0.22, 0.3], [0.15, 0.22, 0.3, 0.38]


def default_sweep(mill: MillConfig) -> MillSweepConfig:
    """Two speeds, two ball sizes and four fill ratios for a mill that has no `sweep`.

    A drum turns at 60 and 80 % of its critical speed sqrt(g / (R - d / 2)); a stirrer's tip moves at 0.5 and 0.9 m/s;
    any other vessel is accelerated by 6 and 12 g. Balls fit five times into the narrowest direction. Raises ConfigError
    for a mill whose shape is refused or that does not move.
    """
    bodies, agitation = build_bodies(mill), mill.motion.record.vessel
    sizes = _sizes_mm(bodies[0].vessel.bounds, mill.volume_ml * 1e-6, FILLS[-1])
    speeds = SPEEDS_OF[agitation](mill, bodies, sizes[0] / 1e3)
    fills = STIRRED_FILLS if agitation is Agitation.STILL else FILLS
    return MillSweepConfig(speeds_rpm=speeds, ball_diameters_mm=sizes, fill_ratios=fills)
