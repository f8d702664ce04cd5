"""What every part of a milling card is made of: a record, and a number with its intervals."""

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Share = Annotated[float, Field(ge=0, le=1)]
Amount = Annotated[float, Field(ge=0)]
Positive = Annotated[float, Field(gt=0)]


class Record(BaseModel):
    """A part of a card; unknown keys and numbers that are not finite are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


class Ends(Record):
    """The two ends of an interval."""

    lower: float
    """lower end, in the unit of the value"""
    upper: float
    """upper end, in the unit of the value"""


class Quantity(Record):
    """A number with its unit and its intervals, which are given separately and not added up."""

    value: float
    """the value, in `unit`"""
    unit: str
    """unit; "-" for a plain number"""
    scatter: Ends | None = None
    """band of a new simulation: contains one more, of the recorded time, with `fingerprint.probability`"""
    mean: Ends | None = None
    """band of the mean: contains the mean of very many simulations with `fingerprint.probability`"""
    contact: Ends | None = None
    """interval by contact parameters: restitution, frictions and stiffness that nobody has measured"""
    shape: Ends | None = None
    """interval by the shape of the jar, where it was fitted"""
