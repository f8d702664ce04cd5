"""The milling card as a model: every field of card.json, from which its schema and workflow/card.md are written.

A card of another program needs the fields without a default. Units are SI, or at the end of a name.
"""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, create_model

from millprint.card.outcome_model import Amount, Dose, Heat, Positive, Record, Spectrum, Wear
from millprint.config.contact_laws import law_fields
from millprint.estimate.estimates import Estimate
from millprint.observables.definitions import DESCRIPTOR_SETS, ON_CARD, SHARE, Observable

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
    """what turns and seeds say against the bands and what to do: no impacts, few turns, repeats, seeds differ"""


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
