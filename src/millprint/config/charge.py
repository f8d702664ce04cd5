"""Charges of balls: of several sizes, and how many balls a jar holds, as people say it."""

import math
import re
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.section import (
    NAME_PATTERN,
    PLAIN_VALUE,
    Diameter,
    Fraction,
    Name,
    Positive,
    PositiveSpeed,
    Section,
    first_repeated,
)
from millprint.config.wording import number_words

if TYPE_CHECKING:
    import numpy as np

# Shares written with three decimals add up to 1 within this.
SHARES_TOLERANCE = 2e-3


class BallMixture(Section):
    """Balls of several sizes in one charge, given by their numbers or by their shares of the ball volume.

    Where tables and scales need one diameter for the charge, they use the diameter of the ball of mean volume.
    """

    name: Name
    """name of the charge, in the names of its cases"""
    sizes_mm: Annotated[tuple[Annotated[Positive, Field(le=1000)], ...], Field(max_length=12)]
    """ball diameters [mm]"""
    numbers: tuple[Positive, ...] | None = None
    """balls of each size; only their ratio counts, since the fill ratio gives the whole charge [-]"""
    shares: tuple[Positive, ...] | None = None
    """share of each size in the ball volume, in place of numbers; they add up to 1 [-]"""

    @model_validator(mode="after")
    def _name_is_of_no_single_size(self) -> "BallMixture":
        # Cases of balls of one size are named after it: d10 is 10 mm.
        if re.match(r"d\d", self.name):
            raise ValueError(f"name = {self.name!r}: that is how balls of one size are named; give a word")
        return self

    @model_validator(mode="after")
    def _one_value_for_each_size(self) -> "BallMixture":
        if len(self.sizes_mm) < 2:
            raise ValueError(
                f"sizes_mm = {list(self.sizes_mm)}: must hold two sizes or more; one size is a plain number"
            )
        if (self.numbers is None) == (self.shares is None):
            raise ValueError("numbers, shares: give either the numbers of balls or their shares of the volume")
        key, values = ("numbers", self.numbers) if self.numbers is not None else ("shares", self.shares)
        if len(values or ()) != len(self.sizes_mm):
            raise ValueError(
                f"{key} = {list(values or ())}: must hold one value for each of {len(self.sizes_mm)} sizes"
            )
        if len(set(self.sizes_mm)) < len(self.sizes_mm):
            raise ValueError(f"sizes_mm = {list(self.sizes_mm)}: a size appears twice")
        if self.shares is not None and abs(sum(self.shares) - 1) > SHARES_TOLERANCE:
            raise ValueError(f"shares = {list(self.shares)}: add up to {sum(self.shares):.4g}; must add up to 1")
        return self

    @property
    def fractions(self) -> list[float]:
        """The share of each size in the number of balls [-]."""
        relative = self.numbers or [s / d**3 for s, d in zip(self.shares or (), self.sizes_mm, strict=True)]
        return [number / sum(relative) for number in relative]

    @property
    def mean_diameter_mm(self) -> float:
        """Diameter of the ball of mean volume, (sum n d^3 / sum n)^(1/3) [mm].

        With it the number of balls, their mass and every scaled quantity keep their meaning.
        """
        return sum(n * d**3 for n, d in zip(self.fractions, self.sizes_mm, strict=True)) ** (1 / 3)

    def columns(self, factor: float = 1.0) -> dict[str, str]:
        """The charge in a row of a table: its name, and its sizes [mm], each multiplied by a factor."""
        return {"charge": self.name, "sizes_mm": ", ".join(f"{factor * size:.4g}" for size in self.sizes_mm)}

    def in_words(self, balls: int) -> str:
        """How many of `balls` have each size: "bond: 43 of 36.83 mm, 67 of 29.72 mm"."""
        counts = zip(self.counts(balls), self.sizes_mm, strict=True)
        return f"{self.name}: {', '.join(f'{count} of {size:g} mm' for count, size in counts)}"

    def counts(self, balls: int) -> list[int]:
        """How many of `balls` have each size, by the largest remainders."""
        exact = [balls * fraction for fraction in self.fractions]
        counts = [int(number) for number in exact]
        by_remainder = sorted(range(len(exact)), key=lambda k: counts[k] - exact[k])
        for k in by_remainder[: balls - sum(counts)]:
            counts[k] += 1
        return counts


def _kind_of_size(size: Any) -> str:
    return BallMixture.__name__ if isinstance(size, dict | BallMixture) else PLAIN_VALUE


# The input means one of the two kinds; a fault is reported only for that kind.
BallSize = Annotated[
    Annotated[Diameter, Tag(PLAIN_VALUE)] | Annotated[BallMixture, Tag(BallMixture.__name__)],
    Discriminator(_kind_of_size),
]


# The charge of balls of one size.
ONE_SIZE = ""


def _number_or_name(balls: Any) -> Any:
    """A number, also one written as text, or a text that may be the name of a charge. Raises ValueError."""
    try:
        number = float(balls)
    except (TypeError, ValueError):
        if isinstance(balls, str) and re.fullmatch(NAME_PATTERN, balls):
            return balls
        meant = (
            number_words(balls, "ball_diameter_mm") if re.match(r"\s*[\d.]", str(balls)) else "must be a diameter [mm]"
        )
        raise ValueError(f"{balls!r}: {meant}; or the name of a charge of several sizes") from None
    return number


# Balls of a fingerprint: their diameter [mm], or the name of a charge of several sizes that was simulated.
BallChoice = Annotated[
    Annotated[Diameter, Tag(PLAIN_VALUE)] | Annotated[Name, Tag("name")],
    Discriminator(lambda choice: "name" if isinstance(choice, str) else PLAIN_VALUE),
    BeforeValidator(_number_or_name),
]


def chosen_balls(choice: float | str, sizes: "list[float | BallMixture]", place: str) -> "float | BallMixture":
    """The balls that a choice means: a diameter [mm] as it is, a name as the charge of that name among `sizes`.

    place: file and key of the choice. Raises ConfigError for a name that no charge has.
    """
    if not isinstance(choice, str):
        return choice
    known = {mixture.name: mixture for mixture in filter(None, map(mixture_of, sizes))}
    if choice not in known:
        has = f"must be one of {', '.join(known)}" if known else "its sweep has only balls of one size; give a number"
        raise ConfigError(f"{place} = {choice}: no charge of the mill's sweep has that name; {has}")
    return known[choice]


def balls_in_words(diameter_mm: float, charge: str = ONE_SIZE) -> str:
    """Balls for a label: "10 mm", or "bond (d30 = 23.8 mm)" for a charge of several sizes and its mean ball."""
    return f"{charge} (d30 = {diameter_mm:.3g} mm)" if charge else f"{diameter_mm:g} mm"


def check_charges(sizes: "list[float | BallMixture]") -> "list[float | BallMixture]":
    """Refuse two charges of one name, which names their cases. Raises ValueError."""
    repeated = first_repeated(mixture.name for mixture in set(filter(None, map(mixture_of, sizes))))
    if repeated:
        raise ValueError(f"two charges have the name {repeated!r}; give each a name of its own")
    return sizes


def diameter_of(size: "float | BallMixture") -> float:
    """The ball diameter that represents an element of `ball_diameters_mm` [mm]."""
    return size.mean_diameter_mm if isinstance(size, BallMixture) else size


def mixture_of(size: "float | BallMixture") -> BallMixture | None:
    """The mixture, if an element of `ball_diameters_mm` is one."""
    return size if isinstance(size, BallMixture) else None


# A number, or an array of them.
Quantity = TypeVar("Quantity", float, "np.ndarray")
Number = Annotated[int, Field(ge=1, le=10_000_000)]
MEASURES = ("fill_ratio", "number", "mass_g", "bulk_filling")
# Share of a poured bed of equal balls that is ball; measured beds have 0.58 to 0.63 [-].
PACKING_FRACTION = 0.6


def named_fill(fill_ratio: float) -> str:
    """A fill ratio in the name of a case: two charges that differ by a ball have two names."""
    return f"{fill_ratio:.6g}".ljust(4, "0")


def fill_from(
    measure: str,
    value: Quantity,
    volume_ml: float,
    diameter_mm: Quantity,
    density_kg_m3: Quantity,
    packing_fraction: float = PACKING_FRACTION,
) -> Quantity:
    """The fill ratio of a measure of MEASURES, of numbers or arrays [-]."""
    if measure == "number":
        return value * math.pi / 6 * (1e-1 * diameter_mm) ** 3 / volume_ml
    if measure == "mass_g":
        return 1e3 * value / density_kg_m3 / volume_ml
    return value * packing_fraction if measure == "bulk_filling" else value


def too_much_words(measure: str, given: float, fill: float) -> str:
    """That a charge is more than a jar holds, and how much it does; fill: the charge's fill ratio."""
    most = given * PACKING_FRACTION / fill
    full = f"{most:.0f}" if measure == "number" else f"{most:.3g}"
    return f"such balls have {fill:.3g} of the jar's volume; it is full with about {full}"


class ChargeSection(Section):
    """How many balls, in one of four ways."""

    fill_ratio: Fraction | None = None
    """ball volume over the jar's nominal volume; or give `number`, `mass_g` or `bulk_filling` [-]"""
    number: Number | None = None
    """number of balls, in place of fill_ratio"""
    mass_g: Positive | None = None
    """mass of all balls, in place of fill_ratio [g]"""
    bulk_filling: Fraction | None = None
    """share of the jar that the bed of balls takes, voids included, in place of fill_ratio [-]"""
    packing_fraction: Fraction = PACKING_FRACTION
    """share of that bed that is ball; an assumption, used with bulk_filling only [-]"""

    @model_validator(mode="after")
    def _one_measure_of_the_charge(self) -> "ChargeSection":
        if sum(getattr(self, measure) is not None for measure in MEASURES) != 1:
            raise ValueError(f"give one of {', '.join(MEASURES)}")
        return self

    def fill_in(self, volume_ml: float, diameter_mm: float, density_kg_m3: float) -> float:
        """The fill ratio in a jar of this nominal volume, of balls of this mean diameter and density [-].

        Raises ValueError if the balls fill the jar or more.
        """
        measure = next(name for name in MEASURES if getattr(self, name) is not None)
        given = getattr(self, measure)
        fill = fill_from(measure, given, volume_ml, diameter_mm, density_kg_m3, self.packing_fraction)
        if fill >= 1:
            raise ValueError(f"{measure} = {given:g}: {too_much_words(measure, given, fill)}")
        return fill

    @property
    def given(self) -> dict[str, float]:
        """The measure that is given, and the packing fraction that belongs to it."""
        keys = (*MEASURES, *(["packing_fraction"] if self.bulk_filling else []))
        return {key: value for key in keys if (value := getattr(self, key)) is not None}


class SpeedSection(Section):
    """A speed of a mill, in one of two units."""

    speed_rpm: PositiveSpeed | None = None
    """speed of the mill; or give `speed_hz` [rpm]"""
    speed_hz: PositiveSpeed | None = None
    """speed of a mill that is set in Hz, in place of speed_rpm [Hz]"""

    @model_validator(mode="after")
    def _one_speed(self) -> "SpeedSection":
        if (self.speed_rpm is None) == (self.speed_hz is None):
            raise ValueError("give either speed_rpm or speed_hz")
        return self

    @property
    def rpm(self) -> float:
        """The speed as people read it [rpm]."""
        return self.speed_rpm if self.speed_rpm is not None else 60 * (self.speed_hz or 0.0)

    @property
    def hz(self) -> float:
        """The speed [Hz]."""
        return self.speed_hz or (self.speed_rpm or 0.0) / 60


def fill_of(charge: dict[str, float], volume_ml: float, diameter_mm: float, density_kg_m3: float, place: str) -> float:
    """The fill ratio of a charge that is given by keys of `ChargeSection`, as `ChargeSection.fill_in` [-].

    Raises ConfigError, in one line that begins with the `place`.
    """
    section = check_model(charge, ChargeSection, place)
    try:
        return section.fill_in(volume_ml, diameter_mm, density_kg_m3)
    except ValueError as error:
        raise ConfigError(f"{place}: {error}") from None


def charge_words(text: str) -> dict[str, str]:
    """The key of a charge that a word of a command line means: "0.2", "number=50", "mass_g=200", "bulk_filling=0.3"."""
    measure, equals, value = text.partition("=")
    return {measure: value} if equals else {MEASURES[0]: text}


def speed_words(text: str) -> dict[str, str]:
    """The key of a speed that a word of a command line means: "400" is in rpm, "25Hz" in Hz."""
    number = re.sub(r"\s*hz$", "", text, flags=re.IGNORECASE)
    return {"speed_rpm": text} if number == text else {"speed_hz": number}
