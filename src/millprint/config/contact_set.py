"""Contact sets (config/contacts/*.yaml): the coefficients of thesis Table 3.2."""

from dataclasses import dataclass

from pydantic import Field, model_validator

from millprint.config.errors import ConfigError
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
# Next to the name of a set where the powder is not known that it was measured with.
ASSUMED = "an assumption unless measured with this powder"


class ContactConfig(NamedSection):
    """One contact set, of balls with balls and, unless other values are given for it, of balls with walls."""

    name: Name
    """name of the set, equal to the name of the file"""
    source: str
    """source of the numbers"""
    restitution: float = Field(gt=0, le=1)
    """coefficient of restitution e [-], thesis Eq. 3.19"""
    static_friction: float = Field(ge=0, le=100)
    """static friction coefficient mu [-]"""
    rolling_friction: float = Field(ge=0, le=100)
    """rolling friction coefficient mu_r [-], thesis Eq. 3.16"""
    wall_restitution: float | None = Field(default=None, gt=0, le=1)
    """restitution of a ball at a wall [-]; if left out, as between two balls"""
    wall_static_friction: float | None = Field(default=None, ge=0, le=100)
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
