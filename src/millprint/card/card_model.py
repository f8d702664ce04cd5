"""The milling card as a model: every field of card.json, from which its schema is written.

A card of another program needs the fields without a default. Units are SI, or at the end of a name.
"""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator

from millprint.config.contact_set import law_fields
from millprint.estimate.estimates import Estimate
from millprint.fingerprint.mill_sheet import shown_speed
from millprint.observables.definitions import DESCRIPTOR_SETS, ON_CARD, SHARE, Observable

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


FORMAT = "millprint milling card"
SCHEMA_VERSION = 3


class Machine(Record):
    """The mill."""

    name: str
    """short name"""
    title: str
    """name as in a paper"""
    source: str = ""
    """where its numbers come from"""
    motion: str = ""
    """kind of motion"""
    amplitude_mm: Positive | None = None
    """half of the longest travel of a point of the wall along one axis [mm]"""
    speed_rpm: Positive
    """set speed of the mill, such as the speed of the sun wheel [rpm]"""
    speed_unit: Literal["rpm", "hz"] = "rpm"
    """unit of the set speed in texts"""

    @property
    def speed(self) -> str:
        """The set speed in words: 400 rpm, 25 Hz."""
        return shown_speed(self.speed_unit, self.speed_rpm / 60)


class Jar(Record):
    """The jar."""

    volume_ml: Positive
    """nominal inner volume, to which the fill ratio refers [mL]"""
    shape: str = ""
    """kind of shape"""
    wall: str = ""
    """what the walls of jar and inserts are: exact surfaces, and flat walls, which may be facets of round ones"""
    material: str = ""
    """material"""
    cooling: str = ""
    """cooling: still_air, moving_air or water"""


class BallGroup(Record):
    """The balls of one size."""

    diameter_mm: Positive
    """diameter [mm]"""
    number: Annotated[int, Field(ge=1)]
    """number of balls"""


class Balls(Record):
    """The charge of balls."""

    sizes: Annotated[list[BallGroup], Field(min_length=1)]
    """the balls of each size"""
    mass_g: Positive
    """mass of all balls [g]"""
    density_kg_m3: Positive
    """density of the balls [kg/m3]"""
    fill_ratio: Annotated[float, Field(gt=0, lt=1)]
    """ball volume over the jar's nominal volume [-]"""
    material: str = ""
    """material"""

    @property
    def number(self) -> int:
        """The number of all balls."""
        return sum(group.number for group in self.sizes)


class Powder(Record):
    """What is milled."""

    name: str
    """name"""
    mass_g: Positive
    """mass of all powder in the jar [g]"""
    ball_to_powder_ratio: Positive
    """mass of the balls over mass of the powder [-]"""


class Programme(Record):
    """Milling and pauses."""

    duration_h: Positive
    """from the start to the end, pauses included [h]"""
    milling_h: Positive
    """time for which the mill runs [h]"""
    cycle_min: Positive | None = None
    """milling and pause together [min]; empty for milling without pauses"""
    pause_min: Amount = 0.0
    """pause at the end of each cycle [min]"""
    reversal: bool = False
    """whether the mill turns the other way after each pause"""


class OverSpeed(Record):
    """A coefficient over the speed along the normal at which two bodies meet."""

    coefficient: str
    """its key in the contact set"""
    speeds_m_s: list[Positive]
    """rising speeds [m/s]"""
    values: list[Amount]
    """the coefficient at each, linear in the logarithm of the speed between them [-]"""


class _OfFriction(Record):
    """Where the contact parameters come from, and the coefficients of every law."""

    name: str
    """short name"""
    source: str
    """where the numbers come from"""
    static_friction: Amount
    """static friction of ball on ball [-]"""
    rolling_friction: Amount
    """rolling friction of ball on ball [-]"""
    wall_static_friction: Amount | None = None
    """static friction at a wall, if it differs [-]"""
    wall_rolling_friction: Amount | None = None
    """rolling friction at a wall, if it differs [-]"""
    kind: str = "hertz"
    """contact law, which says which of the coefficients below there are"""
    over_speed: list[OverSpeed] = []
    """coefficients that depend on the speed of the hit, for which there is the value at 0.5 m/s"""
    cohesion: dict[str, float] = {}
    """how bodies stick to each other, by the keys of the contact set, such as ball_wall_J_m2 [J/m2]"""


_OfLaws: Any = create_model("_OfLaws", __base__=_OfFriction, **law_fields(plain=True))


class ContactSet(_OfLaws):
    """The contact parameters of the simulation, and where they come from."""


def _field(own: Observable) -> tuple[Any, Any]:
    """The field of an observable. One that a card of another program need not have is empty without it."""
    is_needed = own.adds_up or own is SHARE or own.matched in DESCRIPTOR_SETS
    meaning = Field(... if is_needed else None, description=f"{own.meaning} [{own.unit}]")
    return (Estimate if is_needed else Estimate | None), meaning


_fields: dict[str, Any] = {name: _field(own) for name, own in ON_CARD.items()}
_OnCard: Any = create_model("_OnCard", __base__=Record, **_fields)


class Descriptors(_OnCard):
    """The observables: energies and frequencies of collisions, and power of all balls with its parts."""

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            """An observable by its name."""

    @property
    def known(self) -> dict[str, Estimate]:
        """The observables that are given, by name."""
        return {name: own for name, own in vars(self).items() if own is not None}


class CardFingerprint(Record):
    """The mechanical fingerprint of the experiment."""

    counting_rule: str
    """name of the rule that defines one collision"""
    collisions_by: Literal["surface", "facet"]
    """the part of a wall that counts as a partner: a surface, or a facet of it"""
    collision_gap_turns: Amount
    """contacts of a pair that follow each other within this gap are one collision [turns of the mill]"""
    probability: Annotated[float, Field(gt=0, lt=1)]
    """of the bands of a new simulation and of the mean [-]"""
    descriptors: Descriptors
    seeds: list[int] = []
    """seeds of the starting positions, a simulation each"""
    window_s: Amount = 0.0
    """recorded time of all simulations [s]"""
    revolutions: Amount = 0.0
    """turns of the mill in that time [-]"""
    closure: Amount | None = None
    """largest error of an energy balance over the work of the walls [-]"""
    missing: dict[str, str] = {}
    """why an interval is not known, by its name"""
    motion: list[str] = []
    """what turns and seeds say against the bands and what to do: no impacts, few turns, repeats, seeds differ; the
    power of each motion where several last"""

    @property
    def against(self) -> str:
        """`motion` without what to do, as a sentence that stands with the numbers; empty for nothing."""
        parts = (each.split(": ") for each in self.motion)
        said = [f"{word} ({further[0]})" if further else word for word, *further in parts]
        return f"Turns and seeds of the simulations say against these numbers: {'; '.join(said)}." if said else ""


class Software(Record):
    """What computed the card."""

    name: str
    """name"""
    version: str
    """version"""
    commit: str = ""
    """commit of its working tree"""
    packages: dict[str, str] = {}
    """versions of packages that results depend on"""


class MillingCard(Record):
    """What one experiment in a mill was, in numbers."""

    format: Literal["millprint milling card"]
    """what the file is"""
    schema_version: Literal[3]
    """version of this schema"""
    name: str
    """short name of the experiment"""
    title: str
    """title of the card"""
    authors: str = ""
    """who did the experiment"""
    reference: str = ""
    """where it is published"""
    atmosphere: str = ""
    """gas in the jar"""
    note: str = ""
    """anything else that a reader must know"""
    machine: Machine
    jar: Jar
    balls: Balls
    powder: Powder | None = None
    programme: Programme | None = None
    contact_set: ContactSet
    fingerprint: CardFingerprint
    spectra: list[Spectrum] = []
    """energies of single collisions by channel and pair"""
    dose: Dose | None = None
    heat: Heat | None = None
    wear: Wear | None = None
    not_known: dict[str, str] = {}
    """why a section is left out, by its name"""
    methods: str = ""
    """methods paragraph for a paper"""
    software: Software
    digests: dict[str, str] = {}
    """SHA-256 of what the card was made from: mill, contact set, experiment, and the source of the simulation"""
