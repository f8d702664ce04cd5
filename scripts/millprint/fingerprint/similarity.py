"""A mill enlarged by geometric similarity, and the ways to run it: which number each keeps (Eqs 3.28, 3.29)."""

from dataclasses import dataclass

from millprint.config.mill import InsertConfig, MillConfig
from millprint.config.section import Section


@dataclass(frozen=True)
class Way:
    """A way to run the large mill: its speed over the small one's is L^power; whether its balls grow with it."""

    name: str
    keeps: str
    power: float
    balls_grow: bool = False


WAYS = (
    Way("similar", "everything scaled, balls enlarged", -0.5, balls_grow=True),
    Way("energy", "energy of a collision, balls as they are", -1.0),
    Way("power", "power of a ball, balls as they are", -2 / 3),
    Way("acceleration", "acceleration of the wall, balls as they are", -0.5),
    Way("frequency", "collisions of a ball, balls as they are", 0.0),
)
# The way that the large run takes: the fingerprint of a collision is what chemistry sees.
RUN_WAY = "energy"


def enlarged(mill: MillConfig, volume_l: float, name: str) -> tuple[MillConfig, float]:
    """The mill with `volume_l` [L] in place of its volume, all lengths of shape and motion scaled, and the factor L."""
    factor = (volume_l * 1e3 / mill.volume_ml) ** (1 / 3)
    large = mill.model_copy(
        update={
            "name": name,
            "title": f"{mill.title}, enlarged to {volume_l:g} L",
            "volume_ml": volume_l * 1e3,
            "geometry": _larger(mill.geometry, factor),
            "motion": _larger(mill.motion, factor),
            "inserts": [_larger_insert(insert, factor) for insert in mill.inserts],
            "sweep": None,
        }
    )
    return large, factor


def _larger_insert(insert: InsertConfig, factor: float) -> InsertConfig:
    motion = insert.motion and _larger(insert.motion, factor)
    return insert.model_copy(update={"geometry": _larger(insert.geometry, factor), "motion": motion})


def _larger(part: Section, factor: float) -> Section:
    """A geometry or a motion with every length multiplied; one from a file by its `scale`."""
    if hasattr(part, "scale"):
        return part.model_copy(update={"scale": part.scale * factor})
    return type(part).model_validate(_lengths(part.model_dump(), factor))


def _lengths(value: object, factor: float, is_length: bool = False) -> object:
    if isinstance(value, dict):
        return {key: _lengths(item, factor, key.endswith("_mm")) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_lengths(item, factor, is_length) for item in value]
    return value * factor if is_length and isinstance(value, int | float) else value
