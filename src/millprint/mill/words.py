"""The motion of a mill's walls in words, for a reader who does not know the machine."""

from millprint.config.mill import MillConfig
from millprint.mill.bodies import CHECK_RPM, build_bodies
from millprint.mill.speed_limits import paces


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
    return max(pace.acceleration for pace in paces(mill, build_bodies(mill, CHECK_RPM)))
