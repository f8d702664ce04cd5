"""How many balls a jar holds, as people say it: the one place that makes a fill ratio of a number, a mass or a bed."""

import math
import re
from typing import TYPE_CHECKING, Annotated, TypeVar

from pydantic import Field, model_validator

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.section import Fraction, Positive, PositiveSpeed, Section

if TYPE_CHECKING:
    import numpy as np

# A number, or an array of them.
Quantity = TypeVar("Quantity", float, "np.ndarray")
Number = Annotated[int, Field(ge=1, le=10_000_000)]
MEASURES = ("fill_ratio", "number", "mass_g", "bulk_filling")
# Share of a poured bed of equal balls that is ball; measured beds have 0.58 to 0.63 [-].
PACKING_FRACTION = 0.6


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
            raise ValueError(f"{measure} = {given:g}: such balls have {fill:.3g} of the jar's volume")
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
