"""Contact sets (config/contacts/*.yaml): the coefficients of thesis Table 3.2, and how much balls and walls stick."""

import math
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, create_model, model_validator

from millprint.config.contact_laws import CONTACT_LAWS, law_fields
from millprint.config.errors import ConfigError
from millprint.config.over_speed import (
    NOMINAL_SPEED_M_S,
    FrictionOverSpeed,
    RestitutionForm,
    SpeedTable,
    at_speed,
    rescaled,
    table_of,
)
from millprint.config.section import Name, NamedSection, Section

WorkOfAdhesion = Annotated[float, Field(ge=0, le=1e6)]
Pull = Annotated[float, Field(ge=0, le=1e6)]


class CohesionConfig(Section):
    """Surfaces that stick: a constant pull while two bodies touch (Derjaguin, Muller and Toporov 1975)."""

    ball_ball_J_m2: WorkOfAdhesion | None = None
    """work of adhesion w of two balls, with a pull of 2 pi w R* [J/m2]; no pull if left out"""
    ball_wall_J_m2: WorkOfAdhesion | None = None
    """work of adhesion of a ball and a wall, with R* the ball's radius [J/m2]; no pull if left out"""
    ball_ball_N: Pull | None = None
    """pull between two balls of any size, in place of the work of adhesion [N]"""
    ball_wall_N: Pull | None = None
    """pull between a ball and a wall, in place of the work of adhesion [N]"""

    @model_validator(mode="after")
    def _one_number_for_a_pair(self) -> "CohesionConfig":
        for pair in ("ball_ball", "ball_wall"):
            if None not in (getattr(self, f"{pair}_J_m2"), getattr(self, f"{pair}_N")):
                raise ValueError(f"{pair}_J_m2, {pair}_N: give one of them, an energy per area or a force")
        return self

    def pull_N(self, pair: str, radius_m: float) -> float:
        """The pull of a `pair`, ball_ball or ball_wall, of reduced radius [m]."""
        force, energy = getattr(self, f"{pair}_N"), getattr(self, f"{pair}_J_m2")
        return float(force if force is not None else 2 * math.pi * (energy or 0.0) * radius_m)


# Next to the name of a set where the powder is not known that it was measured with.
ASSUMED = "an assumption unless measured with this powder"


class _WithLaw(NamedSection):
    """A set with the name of its law."""

    name: Name
    """name of the set, equal to the name of the file"""
    source: str
    """source of the numbers"""
    density_kg_m3: float = Field(ge=1, le=1e5)
    """density of the balls [kg/m3]"""
    kind: str = Field(default="hertz", json_schema_extra={"enum": [*CONTACT_LAWS]})
    """contact law, which takes those of the keys below that name it, and all that name none"""


_OfLaws: Any = create_model("_OfLaws", __base__=_WithLaw, **law_fields())


class ContactConfig(_OfLaws):
    """One contact set, of balls with balls and, unless other values are given for it, of balls with walls."""

    static_friction: FrictionOverSpeed
    """static friction coefficient mu [-]; or a table over the speed of the hit"""
    rolling_friction: float = Field(ge=0, le=100)
    """rolling friction coefficient mu_r [-], thesis Eq. 3.16"""
    wall_static_friction: FrictionOverSpeed | None = None
    """static friction of a ball at a wall [-]; if left out, as between two balls"""
    wall_rolling_friction: float | None = Field(default=None, ge=0, le=100)
    """rolling friction of a ball at a wall [-]; if left out, as between two balls"""
    cohesion: CohesionConfig | None = None
    """how bodies stick to each other; not at all if left out"""

    if TYPE_CHECKING:

        def __init__(self, **keys: Any) -> None:
            """A set of keys, also of those of its law."""

        def __getattr__(self, name: str) -> Any:
            """A key of a law by its name."""

    @model_validator(mode="after")
    def _keys_of_its_law(self) -> "ContactConfig":
        if self.kind not in CONTACT_LAWS:
            raise ValueError(f"kind = {self.kind!r}: no such contact law; known: {', '.join(CONTACT_LAWS)}")
        own = CONTACT_LAWS[self.kind]
        for key in law_fields():
            given = getattr(self, key) is not None
            if key in own.names and own.keys.model_fields[key].is_required() and not given:
                raise ValueError(f"{key}: this key is missing; kind: {self.kind} needs it")
            if given and key not in own.names:
                raise ValueError(f"{key}: not a key of kind: {self.kind}, which takes {', '.join(own.names)}")
        return self

    def at_speed(self, speed_m_s: float) -> "ContactConfig":
        """The set with the coefficients that it has at a speed of the hit [m/s]; of ball on ball and of walls."""
        return self.model_copy(update={name: at_speed(value, speed_m_s) for name, value in self._over_speed.items()})

    @property
    def _over_speed(self) -> dict[str, Any]:
        """The coefficients that depend on the speed of the hit, by their keys."""
        return {name: value for name, value in self if isinstance(value, SpeedTable | RestitutionForm)}

    def value_of(self, key: str, speed_m_s: float = NOMINAL_SPEED_M_S) -> float:
        """A coefficient of ball on ball at a speed of the hit [m/s], the nominal one where nothing names a speed.

        Raises ConfigError for a set whose law does not have it.
        """
        value = getattr(self, key)
        if value is None:
            raise ConfigError(f"contact set {self.name}: kind: {self.kind} has no {key}, which is needed here")
        return at_speed(value, speed_m_s)

    def rescaled(self, values: dict[str, float]) -> dict[str, Any]:
        """Values of keys, each that depends on the speed as the set's own table in proportion (over_speed.rescaled)."""
        own = {name: getattr(self, name) for name in values}
        # A wall without a value of its own is as a ball.
        own |= {
            name: getattr(self, name.removeprefix("wall_"))
            for name, value in own.items()
            if value is None and name.removeprefix("wall_") in PAIR_COEFFICIENTS
        }
        return {name: value if own[name] is None else rescaled(own[name], value) for name, value in values.items()}

    @property
    def speed_tables(self) -> dict[str, SpeedTable]:
        """The tables of the coefficients that depend on the speed of the hit, by their keys."""
        tables = {name: table_of(value) for name, value in self._over_speed.items()}
        return {name: table for name, table in tables.items() if table is not None}

    @property
    def at_wall(self) -> "ContactConfig":
        """The set with the wall's values in place of the values between two balls, and no separate wall values."""
        own = {name: getattr(self, f"wall_{name}") for name in PAIR_COEFFICIENTS}
        given = {name: value for name, value in own.items() if value is not None}
        return self.model_copy(update={**given, **dict.fromkeys((f"wall_{name}" for name in own), None)})

    @property
    def has_own_walls(self) -> bool:
        """Whether a wall has values of its own."""
        return any(getattr(self, f"wall_{name}") is not None for name in PAIR_COEFFICIENTS)

    @property
    def without_friction(self) -> "ContactConfig":
        """The set of a wall without friction."""
        return self.at_wall.model_copy(update={"static_friction": 0.0, "rolling_friction": 0.0})


# Coefficients that a set may give separately for walls.
PAIR_COEFFICIENTS = tuple(name for name in ContactConfig.model_fields if f"wall_{name}" in ContactConfig.model_fields)
