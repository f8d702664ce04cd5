"""Contact sets (config/contacts/*.yaml): the coefficients of thesis Table 3.2."""

from dataclasses import dataclass
from typing import Any

from pydantic import Field, model_validator

from millprint.config.cohesion import CohesionConfig
from millprint.config.errors import ConfigError
from millprint.config.over_speed import (
    NOMINAL_SPEED_M_S,
    FrictionOverSpeed,
    RestitutionOverSpeed,
    SpeedTable,
    at_speed,
    rescaled,
    table_of,
)
from millprint.config.section import Name, NamedSection


@dataclass(frozen=True)
class LawKeys:
    """A contact law in a contact set: its keys, the first one its stiffness, and its words in texts."""

    keys: tuple[str, ...]
    title: str
    stiffness: str
    unit: str


# By `kind`; millprint.dem.laws.registry has what each computes.
CONTACT_LAWS = {
    "hertz": LawKeys(("young_modulus_gpa", "poisson_ratio"), "Hertz-Mindlin contact", "Young's modulus", "GPa"),
    "linear": LawKeys(
        ("normal_stiffness_n_m", "tangential_stiffness_ratio"),
        "linear spring-dashpot contact",
        "normal stiffness",
        "N/m",
    ),
}
ALL_LAW_KEYS = tuple(key for law in CONTACT_LAWS.values() for key in law.keys)
# Coefficients that a set may give separately for walls.
PAIR_COEFFICIENTS = ("restitution", "static_friction", "rolling_friction")
# Coefficients that may depend on the speed of the hit.
OVER_SPEED = ("restitution", "static_friction", "wall_restitution", "wall_static_friction")
# Next to the name of a set where the powder is not known that it was measured with.
ASSUMED = "an assumption unless measured with this powder"


class ContactConfig(NamedSection):
    """One contact set, of balls with balls and, unless other values are given for it, of balls with walls."""

    name: Name
    """name of the set, equal to the name of the file"""
    source: str
    """source of the numbers"""
    restitution: RestitutionOverSpeed
    """coefficient of restitution e [-], thesis Eq. 3.19; or over the speed of the hit, as a table or a form"""
    static_friction: FrictionOverSpeed
    """static friction coefficient mu [-]; or a table over the speed of the hit"""
    rolling_friction: float = Field(ge=0, le=100)
    """rolling friction coefficient mu_r [-], thesis Eq. 3.16"""
    wall_restitution: RestitutionOverSpeed | None = None
    """restitution of a ball at a wall [-]; if left out, as between two balls"""
    wall_static_friction: FrictionOverSpeed | None = None
    """static friction of a ball at a wall [-]; if left out, as between two balls"""
    wall_rolling_friction: float | None = Field(default=None, ge=0, le=100)
    """rolling friction of a ball at a wall [-]; if left out, as between two balls"""
    density_kg_m3: float = Field(ge=1, le=1e5)
    """density of the balls [kg/m3]"""
    kind: str = Field(default="hertz", json_schema_extra={"enum": [*CONTACT_LAWS]})
    """contact law, which takes some of the keys below: `hertz` the moduli, `linear` the stiffnesses"""
    young_modulus_gpa: float | None = Field(default=None, ge=1e-6, le=1e5)
    """Young's modulus of balls and walls [GPa]"""
    poisson_ratio: float | None = Field(default=None, gt=-1, lt=0.5)
    """Poisson's ratio of balls and walls [-]"""
    normal_stiffness_n_m: float | None = Field(default=None, ge=1e-3, le=1e12)
    """normal stiffness k_n of every contact [N/m]"""
    tangential_stiffness_ratio: float | None = Field(default=None, gt=0, le=10)
    """tangential over normal stiffness, k_t / k_n [-]; 2/7 gives both the same period"""

    cohesion: CohesionConfig | None = None
    """how bodies stick to each other; not at all if left out"""

    @model_validator(mode="after")
    def _keys_of_its_law(self) -> "ContactConfig":
        if self.kind not in CONTACT_LAWS:
            raise ValueError(f"kind = {self.kind!r}: no such contact law; known: {', '.join(CONTACT_LAWS)}")
        own = CONTACT_LAWS[self.kind].keys
        for key in ALL_LAW_KEYS:
            given = getattr(self, key) is not None
            if key in own and not given:
                raise ValueError(f"{key}: this key is missing; kind: {self.kind} needs it")
            if given and key not in own:
                raise ValueError(f"{key}: not a key of kind: {self.kind}, which takes {', '.join(own)}")
        return self

    def of_law(self, key: str) -> float:
        """The value of a key that only some laws have. Raises ConfigError for a set whose law does not have it."""
        value = getattr(self, key)
        if value is None:
            raise ConfigError(f"contact set {self.name}: kind: {self.kind} has no {key}, which is needed here")
        return float(value)

    def at_speed(self, speed_m_s: float) -> "ContactConfig":
        """The set with the coefficients that it has at a speed of the hit [m/s]; of ball on ball and of walls."""
        given = {name: getattr(self, name) for name in OVER_SPEED}
        return self.model_copy(
            update={name: at_speed(value, speed_m_s) for name, value in given.items() if value is not None}
        )

    def value_of(self, coefficient: str, speed_m_s: float = NOMINAL_SPEED_M_S) -> float:
        """A coefficient of ball on ball at a speed of the hit [m/s], the nominal one where nothing names a speed."""
        return at_speed(getattr(self, coefficient), speed_m_s)

    def rescaled(self, values: dict[str, float]) -> dict[str, Any]:
        """Values of keys, each that depends on the speed as the set's own table in proportion (over_speed.rescaled)."""
        own = {name: getattr(self, name) for name in OVER_SPEED if name in values}
        # A wall without a value of its own is as a ball.
        given = {
            name: getattr(self, name.removeprefix("wall_")) if value is None else value for name, value in own.items()
        }
        return {**values, **{name: rescaled(value, values[name]) for name, value in given.items()}}

    @property
    def speed_tables(self) -> dict[str, SpeedTable]:
        """The tables of the coefficients that depend on the speed of the hit, by their keys."""
        tables = {name: table_of(value) for name in OVER_SPEED if (value := getattr(self, name)) is not None}
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
