"""How fast the walls of a mill move: in words, and against what machines reach.

A speed with a digit too many, or of another part of the machine, gives a run that is stable and wrong. So the fastest
wall of each body is compared with two bounds: beyond `usual` the user is warned, beyond `most` the speed is refused.
Both are round numbers for a kind of machine, from what makers and the literature commonly state; they were not checked
on data sheets.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import Agitation, MotionSection
from millprint.mill.bodies import Body, build_bodies
from millprint.mill.gravity import GRAVITY
from millprint.mill.motion import Motion, motion_from_law
from millprint.run.numbers import plain


@dataclass(frozen=True)
class Bound:
    """A bound on a wall's acceleration over gravity [-] or its speed [m/s], and the end of a line beyond it.

    reason: has a place {speed} for the mill's speed that reaches the bound.
    """

    value: float
    reason: str


@dataclass(frozen=True)
class Bounds:
    """The bounds of a kind of wall: on its acceleration over gravity [-] or, with `by_speed`, on its speed [m/s].

    critical: whether `usual` is on the acceleration of the centre of a ball that turns with the wall.
    least: below it nothing mills, which hints at a speed in another unit.
    """

    usual: Bound
    most: Bound
    by_speed: bool = False
    critical: bool = False
    least: Bound | None = None


USUAL = "usual speeds go up to {speed}"
_SHAKEN = Bounds(
    usual=Bound(150, f"the strongest mills that shake their vessel reach some 100 g; {USUAL}"),
    most=Bound(1000, "no mill shakes its vessel by over 1000 g: at most {speed}"),
    least=Bound(0.1, "below 0.1 g nothing mills; is the speed in Hz? Write it under speeds_hz"),
)
BOUNDS = {
    # Retsch Emax: 17 mm at 2000 rpm are 76 g. Fritsch Pulverisette 7 premium line: 95 g for the jar's axis at 1100 rpm
    # of the sun wheel, to which the jar's own rotation adds a third at its wall. SPEX 8000, mixer and vibratory mills
    # stay below.
    Agitation.SHAKEN: _SHAKEN,
    # From 1 g on, its critical speed, a drum carries a ball that does not slide all the way round. High-speed
    # centrifuges for bottles of some 50 mL end near 100,000 g; ultracentrifuges beyond take tubes without anything that
    # mills.
    Agitation.TUMBLED: Bounds(
        usual=Bound(1, "from the critical speed on, {speed}, a ball that does not slide goes round with the wall"),
        most=Bound(100_000, "no vessel of a mill turns at over 100,000 g: at most {speed}"),
        critical=True,
    ),
    # Tips of stirrers: 3 to 5 m/s in attritors, up to 25 m/s in stirred media mills, some 15 m/s in high-energy rotor
    # ball mills. Counter-rotating pin mills, without balls, are the fastest mills of all, near 250 m/s.
    Agitation.STIRRED: Bounds(
        usual=Bound(25, f"stirrers of ball mills reach some 25 m/s at their tips; {USUAL}"),
        most=Bound(250, "no mill's stirrer is faster than 250 m/s at its tip: at most {speed}"),
        by_speed=True,
    ),
    # A wall that never moves reaches no bound.
    Agitation.STILL: _SHAKEN,
}

# Samples of a turn of the fastest harmonic, which miss its peak by 0.02 %; their largest number, a prime, so that they
# meet other phases in every turn of a faster one; and the step of differences.
SAMPLES, SAMPLES_MAX, DIFFERENCE = 180, 3607, 1e-4
# Points that are moved at a time, 24 bytes each.
POINTS_TOGETHER = 50_000


@dataclass(frozen=True)
class Pace:
    """How a body's fastest wall moves at one turn of the mill a second: speed [m/s] and acceleration [m/s2]."""

    body: str
    bounds: Bounds
    speed: float
    acceleration: float

    def speed_at(self, bound: Bound, ball_m: float = 0.0) -> float:
        """The mill's speed [Hz] at which the body reaches a bound of its kind; infinite for one that stands still.

        ball_m: diameter of the balls, of whose centres the critical speed is.
        """
        if self.speed == 0:
            return math.inf
        if self.bounds.by_speed:
            return bound.value / self.speed
        reached = self.acceleration
        if bound is self.bounds.usual and self.bounds.critical:
            # A body turns at speed / radius, and radius = speed^2 / acceleration.
            reached *= max(0.0, 1 - ball_m / 2 * self.acceleration / self.speed**2)
        return math.sqrt(bound.value * GRAVITY / reached) if reached else math.inf

    def at_speed(self, speed_hz: float) -> str:
        """What the body's wall does at a speed of the mill [Hz]."""
        gravities = self.acceleration * speed_hz**2 / GRAVITY
        return (
            f"the wall of {self.body} would have an acceleration of {plain(gravities)} g "
            f"and move at {plain(self.speed * speed_hz)} m/s"
        )


def paces(mill: MillConfig, bodies: Sequence[Body]) -> list[Pace]:
    """How the bodies of a mill move at one turn a second.

    bodies: those of the mill at any speed; their motions are made here, so that a case's own amplitude counts.
    """
    own = [insert.motion for insert in mill.inserts]
    laws = [mill.motion, *(law or mill.motion for law in own)]
    bounds = [BOUNDS[mill.motion.record.vessel]]
    bounds += [BOUNDS[law.record.insert] if law else bounds[0] for law in own]
    return [_pace(body, law, bound) for body, law, bound in zip(bodies, laws, bounds, strict=True)]


def _pace(body: Body, law: MotionSection, bounds: Bounds) -> Pace:
    motion = motion_from_law(law, 1.0)
    fastest = _harmonic(motion)
    samples, step = min(SAMPLES_MAX, SAMPLES * fastest), DIFFERENCE / fastest
    # A turn after the start, because the mill is at rest before it.
    times = 0.5 + np.arange(samples) / samples
    turned, placed = zip(
        *((motion.rotation(t), motion.position(t)) for t in (times - step, times, times + step)), strict=True
    )
    rates = [(value[2] - value[0]) / (2 * step) for value in (turned, placed)]
    curves = [(value[0] - 2 * value[1] + value[2]) / step**2 for value in (turned, placed)]
    return Pace(body.name, bounds, *(_largest(body.vessel.vertices, *pair) for pair in (rates, curves)))


def _largest(points: np.ndarray, turning: np.ndarray, moving: np.ndarray) -> float:
    """The largest |turning x + moving| of points x (n, 3), for changes of the pose (t, 3, 3) and (t, 3) over time.

    As many times together as need little memory, because a vessel from a file has many points.
    """
    largest, together = 0.0, max(1, POINTS_TOGETHER // len(points))
    for first in range(0, len(turning), together):
        times = slice(first, first + together)
        moved = points @ turning[times].transpose(0, 2, 1) + moving[times, None]
        largest = max(largest, float(np.linalg.norm(moved, axis=2).max()))
    return largest


def _harmonic(motion: Motion) -> int:
    """The fastest turn or oscillation of a body over a turn of the mill, 1 at least; a curve has one for 8 pieces."""
    angular = [abs(motion.rate), *motion.harmonics[:, 0], *motion.swing[:, 0]]
    turns = max(angular) / (2 * math.pi)
    return max(1, math.ceil(turns - 1e-9), len(motion.pieces) // 8)


def mill_in_words(mill: MillConfig) -> str:
    """What the walls of a mill do: "the jar moves on a horizontal circle of 17 mm radius without turning"."""
    parts = [f"the jar {mill.motion.in_words()}"]
    # Bodies that move alike are named once.
    own: dict[str, list[str]] = {}
    for insert in mill.inserts:
        if insert.motion is not None:
            own.setdefault(insert.motion.in_words(), []).append(insert.name.replace("_", " "))
    for words, names in own.items():
        parts.append(f"inside it, {names[0]} {words}" if len(names) == 1 else
                     f"inside it, each of {len(names)} bodies ({', '.join(names)}) {words}")  # fmt: skip
    return "; ".join(parts)


def wall_acceleration(mill: MillConfig) -> float:
    """The largest acceleration of a point of the walls at one turn of the mill a second [m/s2].

    It grows with the square of the speed. Of a jar on a circle of radius A it is A (2 pi / s)^2; of a planetary mill it
    has a part of the sun wheel and one of the jar's own turning.
    """
    return max(pace.acceleration for pace in paces(mill, build_bodies(mill)))
