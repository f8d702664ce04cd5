"""A mill enlarged by geometric similarity: the ways to run it, its walls and motion, and the large run.

The Snakefile imports this, so no heavy imports here.
"""

from dataclasses import dataclass

from millprint.config.mill import InsertConfig, MillConfig
from millprint.config.mill_sweep import MillsConfig
from millprint.config.mixture import chosen_balls
from millprint.config.section import Section
from millprint.config.sweep import Case, balls_of

# Revolutions of the large run, of which the second half counts [-], and time for its balls to come to rest [s].
LARGE_TURNS, LARGE_SETTLE_S = 1.0, 0.1


@dataclass(frozen=True)
class Way:
    """A way to run the large mill, at L^power times the small mill's speed; balls_grow: whether balls are enlarged."""

    name: str
    keeps: str
    power: float
    balls_grow: bool = False


# The way of the large run: chemistry depends on the energy of a collision.
RUN_WAY = Way("energy", "energy of a collision, balls as they are", -1.0)
WAYS = (
    Way("similar", "everything scaled, balls enlarged", -0.5, balls_grow=True),
    RUN_WAY,
    Way("power", "power of a ball, balls as they are", -2 / 3),
    Way("acceleration", "acceleration of the wall, balls as they are", -0.5),
    Way("frequency", "collisions of a ball in a second, balls as they are", 0.0),
)


def large_case(small: MillConfig, large: MillConfig, factor: float, settings: MillsConfig) -> Case:
    """The large run of a scale-up: balls as they are, at the speed that keeps the energy of a collision.

    factor: length of the large mill over that of the small one [-]. Raises ValueError for settings without a scale-up,
    ConfigError for a charge that is not in the sweep of the small mill.
    """
    plan = settings.scale_up
    if plan is None:
        raise ValueError("mills.scale_up: is left out, so that there is no large run")
    speed_hz = plan.speed_rpm * factor**RUN_WAY.power / 60
    turn_s = 1 / speed_hz
    sizes = small.sweep.balls if small.sweep else []
    balls = chosen_balls(plan.ball_diameter_mm, sizes, "mills.scale_up.ball_diameter_mm")
    return Case(
        mill=large.name, contact=settings.contact_set, **balls_of(balls),
        fill_ratio=plan.fill_ratio, speed_hz=speed_hz, seed=0, rayleigh_fraction=settings.rayleigh_fraction,
        settle_s=LARGE_SETTLE_S,
        discard_s=LARGE_TURNS / 2 * turn_s, window_s=LARGE_TURNS / 2 * turn_s, threads=plan.cores,
    )  # fmt: skip


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
