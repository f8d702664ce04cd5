"""What the intervals of a prediction come from, and the files of factors by contact parameters and by shape."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from millprint.config.charge import ONE_SIZE
from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.section import Positive
from millprint.estimate.estimates import ENDS
from millprint.observables.definitions import COUNTED, CURVES
from millprint.run.files import read_json


class Origin(NamedTuple):
    """What an interval comes from: a short name, and a line that explains it."""

    title: str
    meaning: str


# What the intervals of a prediction are by; `millprint.fingerprint.processes` defines the first two.
ORIGINS = {
    "scatter": Origin(
        "a new simulation",
        "one more simulation of the condition, of the recorded time, falls in here; nothing else included",
    ),
    "mean": Origin("the mean", "the mean of very many simulations of the condition is in here; nothing else included"),
    "contact": Origin(
        "contact parameters",
        "restitution, frictions and stiffness anywhere in their distributions, mill and balls as they are",
    ),
    "shape": Origin("shape of the jar", "jars that agree about as well with the values that the jar was fitted to"),
}
# Those that are analysed afterwards: each is a part of a fingerprint's file.
FURTHER = {name: ORIGINS[name] for name in ("contact", "shape")}

# The quantities of CURVES that every file of factors must have.
POWERS = ("Pn", "Pt", "ratio", "P")


class _Part(BaseModel):
    """A part of a file of factors; keys that are not named here are ignored."""

    model_config = ConfigDict(extra="ignore", frozen=True, allow_inf_nan=False)


class Ends(_Part):
    """Factors of one quantity, one for each fill ratio."""

    lower: list[Positive]
    upper: list[Positive]


class Sampled(_Part):
    """The condition that factors were sampled at, and the values there that they refer to."""

    speed_hz: Positive
    ball_diameter_m: Positive
    density_kg_m3: Positive
    amplitude_m: Positive
    charge: str = ONE_SIZE
    values: dict[str, list[Positive]]
    """of every quantity of CURVES at each fill ratio [-]"""


class Factors(_Part):
    """How far the scaled quantities may be from a prediction, for one origin of FURTHER.

    The factors multiply the values of `sampled` or, without these, the prediction of a fingerprint. Between two fill
    ratios, the logarithm of a factor is interpolated linearly over the logarithm of the fill ratio; outside the first
    and the last nothing is known.
    """

    mill: str
    contact: str
    fill_ratios: Annotated[list[Annotated[float, Field(gt=0, lt=1)]], Field(min_length=1)]
    """rising [-]"""
    factors: dict[str, Ends]
    """of POWERS and further quantities of CURVES [-]; a quantity that is left out is not known"""
    counting_rule: str | None = None
    """rule by which collisions were counted; None: the file does not say"""
    probability: Annotated[float, Field(gt=0, lt=1)]
    """of the interval [-]"""
    samples: Annotated[int, Field(ge=1)] | None = None
    """simulations, or simulated jars, that the factors are from"""
    sampled: Sampled | None = None
    """where the factors were sampled, and the values that they refer to; none if they refer to the prediction"""
    parameters: dict[str, dict[str, Any]] = {}
    """what was varied, by name, with its distribution and source"""

    @model_validator(mode="after")
    def _every_quantity_at_every_fill_ratio(self) -> "Factors":
        if list(self.fill_ratios) != sorted(set(self.fill_ratios)):
            raise ValueError(f"fill_ratios = {self.fill_ratios}: must rise")
        for name in POWERS:
            if name not in self.factors:
                raise ValueError(f"factors.{name}: this key is missing")
        for name, ends in self.factors.items():
            if name not in CURVES:
                raise ValueError(f"factors.{name}: is none of {', '.join(CURVES)}")
            for end in ENDS:
                if len(getattr(ends, end)) != len(self.fill_ratios):
                    raise ValueError(f"factors.{name}.{end}: must have a number for each of fill_ratios")
            if self.sampled and len(self.sampled.values.get(name, [])) != len(self.fill_ratios):
                raise ValueError(f"sampled.values.{name}: must have a number for each of fill_ratios")
            if any(low > high for low, high in zip(ends.lower, ends.upper, strict=True)):
                raise ValueError(f"factors.{name}: lower must not exceed upper")
        return self

    @property
    def fill_range(self) -> tuple[float, float]:
        """The smallest and the largest fill ratio where the factors are known."""
        return self.fill_ratios[0], self.fill_ratios[-1]

    def onto(self, predicted: Mapping[str, np.ndarray]) -> Self:
        """The factors on predictions (m,) of the condition of `sampled` at each fill ratio, in place of its values.

        The ends at that condition stay where they were sampled. Where a prediction is outside, the interval is widened
        to include it, because its parameters are possible ones.
        """
        if self.sampled is None:
            return self
        moved = {}
        for name, ends in self.factors.items():
            ratio = np.array(self.sampled.values[name]) / predicted[name]
            lower, upper = (np.array(getattr(ends, end)) * ratio for end in ENDS)
            moved[name] = Ends(lower=np.minimum(lower, 1.0).tolist(), upper=np.maximum(upper, 1.0).tolist())
        return self.model_copy(update={"factors": moved, "sampled": None})

    def at(self, fill_ratios: np.ndarray) -> dict[str, np.ndarray]:
        """Factors (2, m), lower and upper, of each of CURVES at fill ratios (m,); NaN where they are not known."""
        fills = np.asarray(fill_ratios, dtype=float)
        low, high = self.fill_range
        known = (low * (1 - 1e-9) <= fills) & (fills <= high * (1 + 1e-9))
        found = {}
        for name in CURVES:
            if name not in self.factors:
                found[name] = np.full((2, fills.size), np.nan)
                continue
            ends = [np.log(getattr(self.factors[name], end)) for end in ENDS]
            logs = [np.interp(np.log(fills), np.log(self.fill_ratios), own) for own in ends]
            found[name] = np.where(known, np.exp(logs), np.nan)
        return found


class ContactFactors(Factors):
    """The file `contact.json` of a mill."""

    format: Literal["millprint contact uncertainty 1"]


class ShapeFactors(Factors):
    """The file `shape.json` of a mill whose jar was fitted."""

    format: Literal["millprint shape uncertainty 1"]


FILES: dict[str, type[Factors]] = {"contact": ContactFactors, "shape": ShapeFactors}


def checked_factors(content: object, origin: str, about: dict, source: str) -> Factors:
    """The factors of an origin of FURTHER, of the mill and contact set that a fingerprint is `about`.

    The factors of COUNTED are left out if they are for another counting rule. Raises ConfigError, in one line, for
    another format, mill or contact set, and for a missing part.
    """
    try:
        factors = check_model(content, FILES[origin], source)
    except ConfigError as error:
        raise ConfigError(str(error).splitlines()[0]) from None
    for key in ("mill", "contact"):
        given = getattr(factors, key)
        if given != about[key]:
            raise ConfigError(f"{source}: {key} = {given!r}: the fingerprint is of {about[key]!r}")
    if factors.counting_rule in (None, about["counting_rule"]):
        return factors
    kept = {name: ends for name, ends in factors.factors.items() if name not in COUNTED}
    return factors.model_copy(update={"factors": kept})


def read_factors(path: str, origin: str, about: dict) -> Factors:
    """Read the factors of an origin of FURTHER from its file; raises ConfigError as `checked_factors`."""
    try:
        content = read_json(path)
    except FileNotFoundError:
        raise ConfigError(f"{path}: no such file; the target `uncertainty` writes it") from None
    except ValueError as error:
        raise ConfigError(str(error)) from None
    return checked_factors(content, origin, about, str(path))
