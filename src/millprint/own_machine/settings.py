"""What the user gives for each measurement: the options of `warm` and `watt`."""

import datetime
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from millprint.config.dose import BodyName, Cooling
from millprint.config.section import Section


class WarmSettings(Section):
    """What is known of a jar that warms."""

    jar_kg: Annotated[float, Field(gt=0, le=100)]
    """mass of jar and lid, weighed [kg]"""
    powder_g: Annotated[float, Field(gt=0, le=100_000)] | None = None
    """powder in the jar; that of the card if left out [g]"""
    cooling: Cooling | None = None
    """what cools the jar; that of the card if left out"""
    start_s: Annotated[float, Field(ge=0, le=1e7)] | None = None
    """time of the table at which the mill starts; the first reading if left out [s]"""
    stop_s: Annotated[float, Field(ge=0, le=1e7)] | None = None
    """time at which it stops; the last reading if left out [s]"""
    body: BodyName = "jar"
    """what the thermometer touches"""
    resolution_K: Annotated[float, Field(gt=0, le=10)] = 0.1
    """resolution of the thermometer [K]"""

    @model_validator(mode="after")
    def _in_order(self) -> "WarmSettings":
        if self.start_s is not None and self.stop_s is not None and self.stop_s <= self.start_s:
            raise ValueError(f"stop_s = {self.stop_s:g}: must be after start_s = {self.start_s:g}")
        return self


class WattSettings(Section):
    """How much of the electric power reaches the balls."""

    efficiency_low: Annotated[float, Field(gt=0, le=1)]
    """lowest share of additional electric power that the motor and its belt pass on [-]"""
    efficiency_high: Annotated[float, Field(gt=0, le=1)]
    """highest [-]"""
    jars: Annotated[int, Field(ge=1, le=8)] = 1
    """jars with balls; the power is divided among them"""

    @model_validator(mode="after")
    def _in_order(self) -> "WattSettings":
        if self.efficiency_low > self.efficiency_high:
            raise ValueError(f"efficiency_low = {self.efficiency_low:g}: must not be above {self.efficiency_high:g}")
        return self


def add_options(parser: ArgumentParser) -> None:
    """The options of every measurement."""
    parser.add_argument("--table", type=Path, help="table of your own measurements; a row is added to it")
    parser.add_argument("--date", type=_day, help="day of the measurement, as 2026-11-27 (default: now)")
    parser.add_argument("--figure", type=Path, help="figure: its name without an ending; PNG and SVG are written")


def _day(text: str) -> str:
    """A day of the calendar."""
    try:
        return datetime.date.fromisoformat(text).isoformat()
    except ValueError:
        raise ArgumentTypeError(f"{text!r}: must be a day, as 2026-11-27") from None


def given(options: Namespace, *names: str) -> dict[str, object]:
    """The options of these names that were given."""
    return {name: value for name in names if (value := getattr(options, name)) is not None}
