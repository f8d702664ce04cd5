"""Contact sets (config/contacts/*.yaml): the coefficients of thesis Table 3.2."""

from pydantic import Field

from millprint.config.section import Name, NamedSection


class ContactConfig(NamedSection):
    """One contact set, the same for ball-ball and ball-wall contacts."""

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
    density_kg_m3: float = Field(ge=1, le=1e5)
    """density of the balls [kg/m3]"""
    young_modulus_gpa: float = Field(ge=1e-6, le=1e5)
    """Young's modulus of balls and walls [GPa]"""
    poisson_ratio: float = Field(gt=-1, lt=0.5)
    """Poisson's ratio of balls and walls [-]"""
