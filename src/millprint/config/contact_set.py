"""Contact sets (config/contacts/*.yaml): coefficients of thesis Table 3.2 by contact law, also over the speed of hits.

The speed is that along the normal with which two bodies meet. It is chosen once, when a contact begins. Between the
speeds of a table the value is linear in the logarithm of the speed; outside of them it is that of the nearest one.

Forms of the restitution, each through one value that is known:

- viscoelastic: 1 - e grows with v^(1/5) at first (Ramirez, Poeschel, Brilliantov and Schwager, Phys. Rev. E 60, 1999,
  4465). The Pade approximant is that of Mueller and Poeschel (Phys. Rev. E 84, 2011, 021302, Eq. 21).
- plastic: e is 1 up to the speed at which the material yields, and falls with v^(-1/4) far above it (Johnson, Contact
  Mechanics, 1985, Sec. 11.5). The closed form is that of Thornton (J. Appl. Mech. 64, 1997, 383, Eq. 31).

To add a law, write its keys, add a record to CONTACT_LAWS, and write the rest in a file of its name in
`millprint/dem/laws`.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_type_hints

from pydantic import Discriminator, Field, Tag, create_model, model_validator

from millprint.config.errors import ConfigError
from millprint.config.section import PLAIN_VALUE, Fraction, Name, NamedSection, Section

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


class LawKeys(Section):
    """The keys of a contact set that its law takes. One whose name begins with wall_ is that of a ball at a wall."""


class DampedKeys(LawKeys):
    """The keys of a law that is damped by a restitution."""

    restitution: RestitutionOverSpeed = Field(
        description="coefficient of restitution e [-], thesis Eq. 3.19; or over the speed of the hit, a table or a form"
    )
    wall_restitution: RestitutionOverSpeed | None = Field(
        None, description="restitution of a ball at a wall [-]; if left out, as between two balls"
    )


class HertzKeys(DampedKeys):
    """Springs of two elastic bodies."""

    young_modulus_gpa: Annotated[float, Field(ge=1e-6, le=1e5)] = Field(
        description="Young's modulus of balls and walls [GPa]"
    )
    poisson_ratio: Annotated[float, Field(gt=-1, lt=0.5)] = Field(description="Poisson's ratio of balls and walls [-]")


class LinearKeys(DampedKeys):
    """Springs of constant stiffness."""

    normal_stiffness_n_m: Annotated[float, Field(ge=1e-3, le=1e12)] = Field(
        description="normal stiffness k_n of every contact [N/m]"
    )
    tangential_stiffness_ratio: Annotated[float, Field(gt=0, le=10)] = Field(
        description="tangential over normal stiffness, k_t / k_n [-]; 2/7 gives both the same period"
    )


@dataclass(frozen=True)
class LawKind:
    """A contact law in a contact set.

    title: its name in texts; told: what texts say about a set of this law, words and unit by key, its stiffness last.
    """

    keys: type[LawKeys]
    title: str
    told: Mapping[str, tuple[str, str]]

    @property
    def names(self) -> tuple[str, ...]:
        """Its keys."""
        return tuple(self.keys.model_fields)


# By `kind`.
CONTACT_LAWS = {
    "hertz": LawKind(
        HertzKeys,
        "Hertz-Mindlin contact",
        {"restitution": ("restitution", ""), "young_modulus_gpa": ("Young's modulus", "GPa")},
    ),
    "linear": LawKind(
        LinearKeys,
        "linear spring-dashpot contact",
        {"restitution": ("restitution", ""), "normal_stiffness_n_m": ("normal stiffness", "N/m")},
    ),
}


def law_fields(plain: bool = False) -> dict[str, Any]:
    """The fields of the keys of all laws, None in a set whose law does not take them, with the kinds that do.

    plain: of one number, also where a key may depend on the speed of the hit.
    """
    fields: dict[str, Any] = {}
    for law in CONTACT_LAWS.values():
        types = get_type_hints(law.keys, include_extras=True)
        for key, own in law.keys.model_fields.items():
            kinds = ", ".join(kind for kind, each in CONTACT_LAWS.items() if key in each.names)
            over_speed = types[key] in (RestitutionOverSpeed, RestitutionOverSpeed | None)
            taken = Restitution if plain and over_speed else types[key]
            fields[key] = (taken | None, Field(default=None, description=f"of {kinds}: {own.description}"))
    return fields


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
