"""Contact sets (config/contacts/*.yaml): the coefficients of thesis Table 3.2."""

from pydantic import Field

from millprint.config.section import Name, NamedSection

# Coefficients that a set may give separately for walls.
PAIR_COEFFICIENTS = ("restitution", "static_friction", "rolling_friction")
# Next to the name of a set where it is not said of which powder it was measured.
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
    young_modulus_gpa: float = Field(ge=1e-6, le=1e5)
    """Young's modulus of balls and walls [GPa]"""
    poisson_ratio: float = Field(gt=-1, lt=0.5)
    """Poisson's ratio of balls and walls [-]"""

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
