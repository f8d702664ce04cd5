"""A coefficient of a contact set that depends on the speed of the hit: a table, or a named form of the restitution.

The speed is that along the normal with which two bodies meet. It is chosen once, when a contact begins. Between the
speeds of a table the value is linear in the logarithm of the speed; outside of them it is that of the nearest one.

Forms of the restitution, each through one value that is known:

- viscoelastic: 1 - e grows with v^(1/5) at first (Ramirez, Poeschel, Brilliantov and Schwager, Phys. Rev. E 60, 1999,
  4465). The Pade approximant is that of Mueller and Poeschel (Phys. Rev. E 84, 2011, 021302, Eq. 21).
- plastic: e is 1 up to the speed at which the material yields, and falls with v^(-1/4) far above it (Johnson, Contact
  Mechanics, 1985, Sec. 11.5). The closed form is that of Thornton (J. Appl. Mech. 64, 1997, 383, Eq. 31).
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from millprint.config.section import PLAIN_VALUE, Fraction, Section

# The speed of the one number that stands for a coefficient over speed where only one can be told [m/s]: that of the
# hit of a ball that falls from 13 mm, about as in a drop test.
NOMINAL_SPEED_M_S = 0.5
# Speeds of the table of a form [m/s], 20 a decade; slower and faster hits have the values at its ends.
FORM_SPEEDS = [10 ** (-4 + number / 20) for number in range(121)]
# Logarithms of the places between which a form has its known value, and how often they are halved.
FORM_PLACES, HALVED = (-18.0, 18.0), 60

HitSpeed = Annotated[float, Field(gt=0, le=1000)]
Restitution = Annotated[float, Field(gt=0, le=1)]
Friction = Annotated[float, Field(ge=0, le=100)]


def value_at(speed_m_s: float, speeds_m_s: Sequence[float], values: Sequence[float]) -> float:
    """The value of a table at a speed [m/s]."""
    place = bisect_right(speeds_m_s, speed_m_s)
    if place in (0, len(speeds_m_s)):
        return float(values[min(place, len(values) - 1)])
    below, above = speeds_m_s[place - 1 : place + 1]
    share = math.log(speed_m_s / below) / math.log(above / below)
    return float(values[place - 1] + share * (values[place] - values[place - 1]))


class SpeedTable(Section):
    """Values of a coefficient at rising speeds of the hit."""

    largest: ClassVar[float] = 100.0
    speeds_m_s: Annotated[tuple[HitSpeed, ...], Field(min_length=2, max_length=200)]
    """speeds along the normal at which two bodies meet, rising [m/s]"""
    values: tuple[float, ...]
    """the coefficient at each of the speeds [-]"""

    @model_validator(mode="after")
    def _a_value_for_each_rising_speed(self) -> "SpeedTable":
        speeds = list(self.speeds_m_s)
        for before, after in pairwise(speeds):
            if not after > before:
                raise ValueError(f"speeds_m_s = {speeds}: must rise; {after:g} follows {before:g}")
        if len(self.values) != len(speeds):
            raise ValueError(f"values = {list(self.values)}: must hold one value for each of {len(speeds)} speeds")
        return self

    def at(self, speed_m_s: float) -> float:
        """The coefficient at a speed [m/s]."""
        return value_at(speed_m_s, self.speeds_m_s, self.values)

    def scaled(self, factor: float) -> "SpeedTable":
        """The table with every value multiplied by a factor, and cut off at the largest value that there is."""
        return self.model_copy(update={"values": tuple(min(factor * value, self.largest) for value in self.values)})


class RestitutionTable(SpeedTable):
    """Restitution at rising speeds of the hit, such as from drops of several heights."""

    largest: ClassVar[float] = 1.0
    values: tuple[Restitution, ...]


class FrictionTable(SpeedTable):
    """Static friction at rising speeds of the hit."""

    values: tuple[Friction, ...]


def viscoelastic(place: float) -> float:
    """Restitution of viscoelastic spheres; place: speed over that at which the first term of 1 - e is 1.15 [-].

    Within 1 % of the equation of motion where e is over 0.45, and within 2 % over 0.35.
    """
    x = place**0.1
    return (1 + 0.501086 * x) / (1 + 0.501086 * x + 1.15345 * x**2 + 0.577977 * x**3 + 0.532178 * x**4)


def plastic(place: float) -> float:
    """Restitution of elastic and perfectly plastic spheres; place: speed over that at which they yield [-]."""
    y = 1 / max(place, 1.0)
    part = y / (y + 2 * math.sqrt(1.2 - 0.2 * y**2))
    return math.sqrt(1.2 * math.sqrt(3.0) * (1 - y**2 / 6)) * part**0.25


FORMS: dict[str, Callable[[float], float]] = {"viscoelastic": viscoelastic, "plastic": plastic}


class RestitutionForm(Section):
    """Restitution by a law of its fall with the speed, through one value that is known."""

    form: Literal["viscoelastic", "plastic"]
    """`viscoelastic` (Ramirez et al. 1999; Mueller and Poeschel 2011) or `plastic` (Johnson 1985; Thornton 1997)"""
    value: Fraction
    """restitution at `at_speed_m_s` [-]"""
    at_speed_m_s: HitSpeed = NOMINAL_SPEED_M_S
    """speed at which it is known [m/s]"""

    @model_validator(mode="before")
    @classmethod
    def _not_a_table_too(cls, content: Any) -> Any:
        if isinstance(content, dict) and (twice := [key for key in SpeedTable.model_fields if key in content]):
            raise ValueError(f"{', '.join(twice)}: not together with form; give a form and its value, or a table")
        return content

    @cached_property
    def table(self) -> RestitutionTable:
        """The form as a table."""
        curve, (low, high) = FORMS[self.form], FORM_PLACES
        for _ in range(HALVED):
            middle = (low + high) / 2
            low, high = (middle, high) if curve(10**middle) > self.value else (low, middle)
        known = 10**high
        # The speed at which a plastic hit begins to yield is a kink.
        kink = min(max(self.at_speed_m_s / known, FORM_SPEEDS[0]), FORM_SPEEDS[-1])
        speeds = sorted({*FORM_SPEEDS, kink})
        values = [min(max(curve(speed / self.at_speed_m_s * known), 1e-3), 1.0) for speed in speeds]
        return RestitutionTable(speeds_m_s=tuple(speeds), values=tuple(values))


def _kind_of_restitution(given: Any) -> str:
    if isinstance(given, dict):
        return (RestitutionForm if "form" in given else RestitutionTable).__name__
    return type(given).__name__ if isinstance(given, Section) else PLAIN_VALUE


def _kind_of_friction(given: Any) -> str:
    return FrictionTable.__name__ if isinstance(given, dict | FrictionTable) else PLAIN_VALUE


# The input means one of the kinds; a fault is reported only for that kind.
RestitutionOverSpeed = Annotated[
    Annotated[Restitution, Tag(PLAIN_VALUE)]
    | Annotated[RestitutionTable, Tag(RestitutionTable.__name__)]
    | Annotated[RestitutionForm, Tag(RestitutionForm.__name__)],
    Discriminator(_kind_of_restitution),
]
FrictionOverSpeed = Annotated[
    Annotated[Friction, Tag(PLAIN_VALUE)] | Annotated[FrictionTable, Tag(FrictionTable.__name__)],
    Discriminator(_kind_of_friction),
]


def table_of(given: "float | SpeedTable | RestitutionForm") -> SpeedTable | None:
    """The table of a coefficient; None for one that is the same at every speed."""
    if isinstance(given, RestitutionForm):
        return given.table
    return given if isinstance(given, SpeedTable) else None


def at_speed(given: "float | SpeedTable | RestitutionForm", speed_m_s: float) -> float:
    """A coefficient at a speed [m/s]."""
    table = table_of(given)
    return float(given) if table is None else table.at(speed_m_s)  # type: ignore[arg-type]


def rescaled(given: "float | SpeedTable | RestitutionForm", value: float) -> "float | SpeedTable":
    """A coefficient that has a value at the nominal speed: a table in proportion, and a number as that value."""
    table = table_of(given)
    nominal = at_speed(given, NOMINAL_SPEED_M_S)
    return value if table is None or nominal == 0 else table.scaled(value / nominal)
