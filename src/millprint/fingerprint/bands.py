"""A predicted value with its intervals, each named by its origin."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from millprint.config.errors import ConfigError
from millprint.config.load import check_model
from millprint.config.mixture import ONE_SIZE
from millprint.config.section import Positive
from millprint.fingerprint.condition import COUNTED, CURVES, WEIGHTED
from millprint.run.files import read_json


class Origin(NamedTuple):
    """What an interval comes from: a short name, and a line that explains it."""

    title: str
    meaning: str


# The two bands by the scatter of the simulation; `millprint.fingerprint.processes` defines them.
SCATTER = Origin(
    "a new simulation",
    "one more simulation of the condition, of the recorded time, falls in here; nothing else included",
)
MEAN = Origin("the mean", "the mean of very many simulations of the condition is in here; nothing else included")
# Each is a field of Band, a part of a fingerprint's file, and columns `NAME_by_ORIGIN_lower` and `_upper` of tables.
FURTHER = {
    "contact": Origin(
        "contact parameters",
        "restitution, frictions and stiffness anywhere in their distributions, mill and balls as they are",
    ),
    "shape": Origin("shape of the jar", "jars that agree about as well with the values that the jar was fitted to"),
}
ENDS = ("lower", "upper")
# An interval whose ends are farther apart than this factor says nothing: they count as not known.
WIDEST = 10.0
NOT_KNOWN = "not known"


def known_ends(logs: np.ndarray) -> np.ndarray:
    """Logarithms (2, ...) of the lower and the upper end over the value, NaN where the interval says nothing."""
    return np.where(logs[1] - logs[0] <= np.log(WIDEST), logs, np.nan)


def factor_of(half: np.ndarray | float) -> np.ndarray:
    """The factor from a value to the ends of its interval, from half the width in logarithms; NaN if not known."""
    half = np.asarray(half, dtype=float)
    return np.exp(known_ends(np.stack([-half, half]))[1])


@dataclass(frozen=True)
class Interval:
    """The two ends of an interval."""

    lower: float
    upper: float


@dataclass(frozen=True)
class Band:
    """A value and its intervals, which are given separately and not added up.

    lower, upper: of a new simulation; mean: of the mean of very many simulations. The others are None if not known.
    """

    value: float
    lower: float
    upper: float
    mean: Interval | None = None
    contact: Interval | None = None
    shape: Interval | None = None

    @property
    def scatter(self) -> Interval:
        """The band of a new simulation: lower and upper."""
        return Interval(self.lower, self.upper)

    def by(self, origin: str) -> Interval | None:
        """The interval of an origin of FURTHER; None where it is not known. Raises KeyError for another name."""
        FURTHER[origin]
        return getattr(self, origin)

    def through(self, rising: Callable[[float], float]) -> "Band":
        """The band of a rising function of the value, from the function at the ends."""

        def mapped(interval: Interval | None) -> Interval | None:
            return interval and Interval(rising(interval.lower), rising(interval.upper))

        further = {origin: mapped(self.by(origin)) for origin in FURTHER}
        return Band(rising(self.value), rising(self.lower), rising(self.upper), mapped(self.mean), **further)

    def __mul__(self, factor: float) -> "Band":
        """The band of the value times a positive number."""
        return self.through(lambda end: end * factor)

    def columns(self, name: str) -> dict[str, float]:
        """The columns of a table for the value, as NAME, and for the band of a new simulation."""
        return {name: self.value, **dict(zip(new_columns(name), (self.lower, self.upper), strict=True))}


def share_of(ratio: Band) -> Band:
    """Tangential over all dissipation, Et / (En + Et) [-]; it rises with Et / En, from which it is computed."""
    return ratio.through(lambda end: end / (1.0 + end))


def ratio_of(one: Band, other: Band) -> Band:
    """one / other [-] of two independent quantities with normal logarithms and intervals of the same probability.

    Variances of logarithms add up, and so do the squares of the distances from the value to an end:
    log(r_upper / r)^2 = log(one_upper / one)^2 + log(other / other_lower)^2, and the other way round for the lower end.
    The interval of the mean, or of a further origin, is None where one of the two quantities lacks it.
    """
    value = one.value / other.value

    def ends(own: Interval, others: Interval) -> Interval:
        below = np.hypot(np.log(one.value / own.lower), np.log(others.upper / other.value))
        above = np.hypot(np.log(own.upper / one.value), np.log(other.value / others.lower))
        return Interval(float(value * np.exp(-below)), float(value * np.exp(above)))

    known = {origin: (one.by(origin), other.by(origin)) for origin in FURTHER}
    further = {origin: ends(own, others) for origin, (own, others) in known.items() if own and others}
    scatter = ends(one.scatter, other.scatter)
    mean = ends(one.mean, other.mean) if one.mean and other.mean else None
    return Band(value, scatter.lower, scatter.upper, mean, **further)


def new_columns(name: str) -> list[str]:
    """The columns of a table for the band of a new simulation of a quantity."""
    return [f"{name}_{end}" for end in ENDS]


def mean_columns(name: str) -> list[str]:
    """The columns of a table for the band of the mean of a quantity."""
    return [f"{name}_mean_{end}" for end in ENDS]


def interval_columns(name: str, origin: str) -> list[str]:
    """The columns of a table for the interval of a quantity by an origin of FURTHER."""
    return [f"{name}_by_{origin}_{end}" for end in ENDS]


# The quantities of CURVES that every file of factors must have.
POWERS = tuple(name for name in CURVES if name not in (*COUNTED, *WEIGHTED))


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
