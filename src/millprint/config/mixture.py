"""Charges of balls of several sizes: an element of `ball_diameters_mm` that is not a number."""

import re
from typing import Annotated, Any

from pydantic import BeforeValidator, Discriminator, Field, Tag, model_validator

from millprint.config.errors import ConfigError
from millprint.config.section import NAME_PATTERN, PLAIN_VALUE, Diameter, Name, Positive, Section, first_repeated

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
        raise ValueError(f"{balls!r}: must be a ball diameter [mm], or the name of a charge of several sizes") from None
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
