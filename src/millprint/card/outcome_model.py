"""What the balls and the powder of a milling card go through: energy spectra, dose, heat and wear."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from millprint.estimate.estimates import Estimate

Share = Annotated[float, Field(ge=0, le=1)]
Amount = Annotated[float, Field(ge=0)]
Positive = Annotated[float, Field(gt=0)]


class Record(BaseModel):
    """A part of a card; unknown keys and numbers that are not finite are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


class Bins(Record):
    """A spectrum: a value for each bin of the energy of a collision."""

    energy_low_J: list[float | None]
    """lower edges [J]; none for the open bin at the lower end"""
    energy_high_J: list[float | None]
    """upper edges [J]; none for the open bin at the upper end"""
    collisions_hz: list[float]
    """collisions a second of all balls in each bin [1/s]"""
    power_W: list[float]
    """power of all balls in each bin [W]"""

    @model_validator(mode="after")
    def _one_value_for_each_bin(self) -> "Bins":
        if len({len(values) for values in vars(self).values()}) > 1:
            raise ValueError("lists must have one length: a value for each bin")
        return self


class Spectrum(Record):
    """Energies of single collisions of one channel, between balls or with walls."""

    channel: Literal["normal", "tangential"]
    """which energy"""
    pair: Literal["ball_ball", "ball_wall"]
    """between balls, or of balls with walls"""
    collisions_hz: Amount
    """collisions a second of all balls [1/s]"""
    power_W: float
    """power of all balls [W]"""
    power_share: float
    """its share in the power of the channel [-]"""
    mean_J: float | None = None
    """mean energy of a collision [J]"""
    median_J: float | None = None
    """median energy of a collision [J]"""
    half_power_J: float | None = None
    """energy of a collision above which half of the power falls [J]"""
    bins: Bins | None = None


class Dose(Record):
    """What a gram of powder has been through, as if every collision caught powder."""

    normal_kJ_g: Estimate
    """normal energy [kJ/g]"""
    tangential_kJ_g: Estimate
    """tangential energy [kJ/g]"""
    rolling_kJ_g: Estimate
    """energy of rolling [kJ/g]"""
    total_kJ_g: Estimate
    """all three, what the walls supply [kJ/g]"""
    hits_per_g: Estimate
    """collisions [1/g]"""
    rate_W_g: Estimate
    """power over the mass of powder while the mill runs [W/g]"""


class Temperature(Record):
    """A temperature with its band [degC]."""

    lower: float
    """lower end of the band [degC]"""
    median: float
    """median [degC]"""
    upper: float
    """upper end of the band [degC]"""


class Hours(Record):
    """A time with its band [h]; none where it is never reached."""

    lower: Amount | None
    """lower end of the band [h]"""
    median: Amount | None
    """median [h]"""
    upper: Amount | None
    """upper end of the band [h]"""


class BodyHeat(Record):
    """How warm a body gets."""

    steady_degC: Temperature
    """after long milling without pauses"""
    peak_degC: Temperature | None = None
    """largest in the programme"""


class Course(Record):
    """Temperatures over the programme: a value for each time."""

    time_h: list[float]
    """times [h]"""
    balls_degC: list[Temperature]
    """of the balls"""
    powder_degC: list[Temperature]
    """of the powder"""
    jar_degC: list[Temperature]
    """of the jar"""


class Heat(Record):
    """A heat balance of balls, powder and jar. The bands hold what is not known of jar, cooling and powder."""

    probability: Annotated[float, Field(gt=0, lt=1)]
    """of the bands [-]"""
    power_W: Amount
    """dissipation by compression, sliding and rolling [W]"""
    balls: BodyHeat
    powder: BodyHeat
    jar: BodyHeat
    limit_body: str
    """what must stay below `limit_degC`"""
    limit_degC: float
    """the limit [degC]"""
    time_to_limit_h: Hours
    """milling without pauses until the limit"""
    course: Course | None = None


class WearLoss(Record):
    """A number with one interval."""

    value: Amount
    """the value, in the unit at the end of its name"""
    lower: Amount
    """lower end of the interval"""
    upper: Amount
    """upper end of the interval"""


class Wear(Record):
    """Wear of the balls by Archard's law."""

    material: str
    """material of the balls"""
    probability: Annotated[float, Field(gt=0, lt=1)] | None = None
    """of the intervals [-]; none where too few weighings were held back, so that the ends are those between the
    coefficients of single weighings
    """
    wear_g: WearLoss
    """mass that all balls lose [g]"""
    iron_percent: WearLoss
    """iron from the balls over the mass of powder [%]"""
    coefficient: Positive
    """Archard's wear coefficient [-]"""
    coefficient_from: str
    """where the coefficient comes from"""
    note: str = ""
    """what the interval does not hold"""
