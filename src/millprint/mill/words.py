"""The motion of a mill's walls in words, for a reader who does not know the machine."""

from collections.abc import Callable
from typing import Any

from millprint.config.mill import MillConfig
from millprint.config.motion_kinds import MotionSection
from millprint.mill.bodies import CHECK_RPM, build_bodies
from millprint.mill.speed_limits import paces

# For a motion by its kind: what a body does, after its name.
WORDS: dict[str, Callable[[Any], str]] = {
    "circle": lambda law: f"moves on a horizontal circle of {law.amplitude_mm:g} mm radius without turning",
    "lissajous": lambda law: "is shaken along a sum of harmonic motions without turning",
    "figure_of_eight": lambda law: (
        f"is shaken on a figure of eight, {2 * law.along_mm:g} mm long and {2 * law.across_mm:g} mm wide"
    ),
    "rotation": lambda law: f"turns about a fixed axis{'' if abs(law.ratio) == 1 else f', {law.ratio:g} times a turn'}",
    "planetary": lambda law: (
        f"is carried round by a sun wheel, its axis {law.sun_radius_mm:g} mm from the wheel's, and turns about this "
        f"axis at {law.ratio:g} times the wheel's speed, relative to the wheel"
    ),
    "swing": lambda law: (
        f"swings to and fro by {law.amplitude_deg:g} degrees to each side"
        + (" with a further motion on top" if law.terms else "")
    ),
    "points": lambda law: "follows a curve that is given as a table of points",
    "rest": lambda law: "stands still",
}


def motion_in_words(law: MotionSection) -> str:
    """What a body with this motion does, as the end of a sentence. Raises ValueError for a kind without words."""
    if law.kind not in WORDS:
        raise ValueError(f"kind = {law.kind!r}: no words for this motion; known: {', '.join(WORDS)}")
    return WORDS[law.kind](law)


def mill_in_words(mill: MillConfig) -> str:
    """What the walls of a mill do: "the jar moves on a horizontal circle of 17 mm radius without turning"."""
    parts = [f"the jar {motion_in_words(mill.motion)}"]
    # Bodies that move alike are named once.
    own: dict[str, list[str]] = {}
    for insert in mill.inserts:
        if insert.motion is not None:
            own.setdefault(motion_in_words(insert.motion), []).append(insert.name.replace("_", " "))
    for words, names in own.items():
        parts.append(f"inside it, {names[0]} {words}" if len(names) == 1 else
                     f"inside it, each of {len(names)} bodies ({', '.join(names)}) {words}")  # fmt: skip
    return "; ".join(parts)


def wall_acceleration(mill: MillConfig) -> float:
    """The largest acceleration of a point of the walls at one turn of the mill a second [m/s2].

    It grows with the square of the speed. Of a jar on a circle of radius A it is A (2 pi / s)^2; of a planetary mill it
    has a part of the sun wheel and one of the jar's own turning.
    """
    return max(pace.acceleration for pace in paces(mill, build_bodies(mill, CHECK_RPM)))
