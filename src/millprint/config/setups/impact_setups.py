"""Set-ups of a single impact of a sphere on a plate."""

from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.section import Name, Positive
from millprint.config.setups.base import Interval, SetupConfig

Angle = Annotated[float, Field(gt=0, lt=90)]


class ImpactConfig(SetupConfig):
    """A sphere hits a plate at rest; nothing else acts on it."""

    radius_mm: Positive
    """radius of the sphere [mm]"""
    steps_per_impact: Annotated[int, Field(ge=100, le=1_000_000)] = 4000
    """steps in the duration of the elastic normal impact (Hertz) [-]"""
    restitution: Interval | None = None
    """interval of the coefficient of restitution; known exactly if left out [-]"""
    static_friction: Interval | None = None
    """interval of the friction coefficient; known exactly if left out [-]"""

    @model_validator(mode="after")
    def _intervals_rise(self) -> "ImpactConfig":
        for key, most in (("restitution", 1.0), ("static_friction", 100.0)):
            interval = getattr(self, key)
            if interval and not 0 < interval[0] <= interval[1] <= most:
                raise ValueError(f"{key} = {list(interval)}: two numbers above 0 and up to {most:g}, the smaller first")
        return self


class AluminaImpactConfig(ImpactConfig):
    """Set-up 3: a sphere of aluminium oxide on glass, at one speed and many angles (Kharaz, Gorham and Salman 2001)."""

    places = ("angles_deg",)

    contact: Name = "alumina_on_glass"
    radius_mm: Positive = 2.5
    restitution: Interval | None = (0.97, 0.99)
    static_friction: Interval | None = (0.087, 0.097)
    speed_m_s: Positive = 3.9
    """speed of the sphere before the impact [m/s]"""
    angles_deg: list[Angle] = Field(default=[float(a) for a in (*range(1, 15), *range(15, 90, 5), 88)], min_length=1)
    """angles of incidence from the normal, in addition to the measured ones [deg]"""


class ElasticImpactConfig(ImpactConfig):
    """Set-up 9: an elastic sphere on a plate of its own material, at one normal speed (Chung and Ooi 2011, test 5)."""

    places = ("slopes",)

    contact: Name = "steel_elastic"
    radius_mm: Positive = 0.01
    normal_speed_m_s: Positive = 5.0
    """normal speed of the sphere before the impact [m/s]"""
    slopes: list[Positive] = Field(default=[0.1, 0.5, 1.0, 1.5, 2.0, 2.5, *map(float, range(3, 15))], min_length=1)
    """tangential over mu times normal speed at the contact point, in addition to the measured ones [-]"""
