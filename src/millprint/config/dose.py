"""The section `dose`: quantities from finished simulations: energy spectra of collisions, wear of the balls, heat.

Every number of the heat balance is a range with its source. To add a kind of cooling, write a key of
`SurroundingsSection` with its default, and add its name to `Cooling`.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from millprint.config.fingerprint import FurtherRules
from millprint.config.section import Name, NonNegative, Positive, ProjectFile, Section

Cooling = Literal["still_air", "moving_air", "water"]
BodyName = Literal["balls", "powder", "jar"]
# A range that spans more than this is uniform in the logarithm.
WIDE_RANGE = 10.0
MOST_CYCLES = 2000
ABSOLUTE_ZERO_DEGC = -273.15


class RangeSection(Section):
    """A number of which only a range is known."""

    low: float
    """smallest value, in the unit of the key"""
    high: float
    """largest value, in the unit of the key; the same as low for a number that is known"""
    source: Annotated[str, Field(min_length=1)]
    """where the numbers come from"""

    @model_validator(mode="after")
    def _low_first(self) -> "RangeSection":
        if self.low > self.high:
            raise ValueError(f"low = {self.low:g}: must not be above high = {self.high:g}")
        return self

    @property
    def logarithmic(self) -> bool:
        """Whether the range is uniform in the logarithm, as it spans a factor of ten."""
        return self.low > 0 and self.high >= WIDE_RANGE * self.low


def known(low: float, high: float, source: str) -> RangeSection:
    """A range with its source, for defaults."""
    return RangeSection(low=low, high=high, source=source)


@dataclass(frozen=True)
class Bounds:
    """What a parameter of the balance can be: its title, its unit, and bounds (the lower one excluded if `above`)."""

    title: str
    unit: str
    lowest: float
    highest: float
    above: bool = True

    def check(self, key: str, given: RangeSection) -> None:
        """Raise ValueError, in one line, for a range beyond the bounds."""
        for end in ("low", "high"):
            value = getattr(given, end)
            if not self.lowest <= value <= self.highest or (self.above and value == self.lowest):
                sign = "above" if self.above else "from"
                raise ValueError(
                    f"{key}.{end} = {value:g}: must be {sign} {self.lowest:g} and at most {self.highest:g} "
                    f"[{self.unit}]"
                )


COEFFICIENT = Bounds("heat transfer to the surroundings", "W/m2K", 0.0, 1e6)
TEMPERATURE = Bounds("surroundings", "degC", ABSOLUTE_ZERO_DEGC, 500.0)
# Every parameter of the balance, except the parameters of the surroundings.
PARAMETERS = {
    "ball_to_powder_ratio": Bounds("mass of the balls over that of the powder", "-", 0.0, 1e6),
    "ball_heat_capacity_J_kgK": Bounds("specific heat of the balls", "J/kgK", 0.0, 1e5),
    "powder_heat_capacity_J_kgK": Bounds("specific heat of the powder", "J/kgK", 0.0, 1e5),
    "jar_heat_capacity_J_kgK": Bounds("specific heat of the jar", "J/kgK", 0.0, 1e5),
    "jar_density_kg_m3": Bounds("density of the jar", "kg/m3", 0.0, 1e5),
    "wall_thickness_mm": Bounds("thickness of the jar's wall", "mm", 0.0, 1e3),
    "ball_wall_W_m2K": Bounds("heat transfer, balls to jar, on the inside of the jar", "W/m2K", 0.0, 1e6),
    "ball_powder_W_m2K": Bounds("heat transfer, balls to powder, on the surface of the balls", "W/m2K", 0.0, 1e6),
    "powder_wall_W_m2K": Bounds("heat transfer, powder to jar, on the inside of the jar", "W/m2K", 0.0, 1e6),
    "heat_share": Bounds("share of the dissipation that becomes heat", "-", 0.0, 1.0),
    "powder_share_normal": Bounds("share of compression that heats the powder", "-", 0.0, 1.0, above=False),
    "powder_share_shear": Bounds("share of sliding and rolling that heats the powder", "-", 0.0, 1.0, above=False),
    "wall_share": Bounds("of the rest at the wall, share of the jar", "-", 0.0, 1.0, above=False),
}

LAYER = "a layer of powder of 0.05 to 0.5 mm that conducts 0.1 W/mK (loose inorganic powder in gas), assumed"
STEEL = "steels, from stainless to bearing steel: handbook values"


class HeatParametersSection(Section):
    """The parameters of the balance. The defaults are wide: for a steel jar that nobody has measured.

    Constants are those that hardly anybody can measure.
    """

    ball_to_powder_ratio: RangeSection = known(10, 50, "levels of the thesis, Table 2.3")
    """mass of the balls over that of the powder, unless powder_mass_g is given [-]"""
    ball_heat_capacity_J_kgK: RangeSection = known(450, 510, STEEL)
    """specific heat of the balls [J/kgK]"""
    powder_heat_capacity_J_kgK: RangeSection = known(
        500, 1600, "from metal powders to hydrides and salts: handbook values"
    )
    """specific heat of the powder [J/kgK]"""
    jar_heat_capacity_J_kgK: RangeSection = known(450, 510, STEEL)
    """specific heat of the jar [J/kgK]"""
    jar_density_kg_m3: RangeSection = known(7700, 8000, STEEL)
    """density of the jar, where its mass is not given [kg/m3]"""
    wall_thickness_mm: RangeSection = known(
        6, 12, "steel jars of laboratory mills, assumed; 9.5 mm is that of a 65 mL vial of 2.25 by 3 inch outside"
    )
    """thickness of the jar's wall and lid, where its mass or its surface is not given [mm]"""
    # Heat transfer from balls to jar, over the inside of the jar [W/m2K]
    ball_wall_W_m2K: ClassVar[RangeSection] = known(
        20, 500, "Schluender's limit for a sphere of 10 mm on a wall in air is some 100; balls cover part of the wall "
        "(lower end), impacts and powder carry more (upper end): assumed",
    )  # fmt: skip
    # Heat transfer from balls to powder, over the surface of the balls [W/m2K]
    ball_powder_W_m2K: ClassVar[RangeSection] = known(200, 2000, LAYER)
    # Heat transfer from powder to jar, over the inside of the jar [W/m2K]
    powder_wall_W_m2K: ClassVar[RangeSection] = known(
        20, 2000, LAYER + "; at the lower end a tenth of the wall is covered"
    )
    # Share of the dissipation that becomes heat; the rest stays in defects, surfaces and bonds [-]
    heat_share: ClassVar[RangeSection] = known(
        0.8, 1.0, "Taylor and Quinney, Proc. R. Soc. A 143 (1934) 307: 85 to 95 % of plastic work in metals; widened"
    )
    # Share of the normal dissipation of a contact that heats the powder in it [-]
    powder_share_normal: ClassVar[RangeSection] = known(0.1, 0.9, "not known, assumed")
    # Share of the tangential and rolling dissipation of a contact that heats the powder in it [-]
    powder_share_shear: ClassVar[RangeSection] = known(0.1, 0.9, "not known, assumed")
    # Share of the jar in the ball-on-wall dissipation that does not heat powder; the balls take the rest [-]
    wall_share: ClassVar[RangeSection] = known(
        0.3, 0.7, "half where ball and wall are of one material (equal half spaces, Carslaw and Jaeger); widened"
    )

    @model_validator(mode="after")
    def _possible(self) -> "HeatParametersSection":
        for name, given in self.items():
            PARAMETERS[name].check(name, given)
        return self

    def items(self) -> Iterator[tuple[str, RangeSection]]:
        """Name and range of each parameter."""
        return ((name, getattr(self, name)) for name in PARAMETERS)


class CoolingSection(Section):
    """The surroundings that take up the heat of a jar."""

    coefficient_W_m2K: RangeSection
    """heat transfer from the outside of the jar, radiation included [W/m2K]"""
    temperature_degC: RangeSection
    """temperature of the surroundings, and of everything at the start [degC]"""

    @model_validator(mode="after")
    def _possible(self) -> "CoolingSection":
        COEFFICIENT.check("coefficient_W_m2K", self.coefficient_W_m2K)
        TEMPERATURE.check("temperature_degC", self.temperature_degC)
        return self


ROOM = known(20, 30, "a room, and the warmer inside of a mill: assumed")


class SurroundingsSection(Section):
    """The kinds of cooling."""

    still_air: CoolingSection = CoolingSection(
        coefficient_W_m2K=known(8, 15, "natural convection of 3 to 8, and some 5 to 6 by radiation: textbook values"),
        temperature_degC=ROOM,
    )
    """air at rest"""
    moving_air: CoolingSection = CoolingSection(
        coefficient_W_m2K=known(20, 100, "forced convection of air at some 2 to 15 m/s over a body of 5 to 10 cm"),
        temperature_degC=ROOM,
    )
    """a fan, or a jar that moves through the air at metres per second; while the mill stands, air at rest"""
    water: CoolingSection = CoolingSection(
        coefficient_W_m2K=known(
            200, 1500, "water in channels next to the jar (some 1000 to 5000) in series with a joint to the holder "
            "(some 300 to 3000): assumed; makers give none",
        ),
        temperature_degC=known(10, 25, "tap water to a closed circuit: assumed"),
    )  # fmt: skip
    """water around the jar, as in the Emax"""


class JarSection(Section):
    """What is known of the jar of a mill."""

    cooling: Cooling = "moving_air"
    """what cools it"""
    mass_kg: Positive | None = None
    """mass of jar and lid [kg]; from the inside of the jar and wall_thickness_mm if left out"""
    surface_cm2: Positive | None = None
    """outer surface that loses heat [cm2]; from the inside of the jar and wall_thickness_mm if left out"""


class ProgrammeSection(Section):
    """Milling and pauses. The direction of motion does not matter: a reversal affects heat only by its standing time.

    A cycle is milling with its pause after it.
    """

    duration_h: Annotated[float, Field(gt=0, le=1000)] = 5.0
    """from the start to the end, pauses included [h]"""
    cycle_min: Annotated[float, Field(gt=0, le=60_000)] = 30.0
    """milling and its pause together [min]"""
    pause_min: NonNegative = 0.0
    """pause at the end of each cycle, with the standing time of a reversal [min]; 0: milling without pauses"""

    @model_validator(mode="after")
    def _pause_in_cycle(self) -> "ProgrammeSection":
        if self.pause_min >= self.cycle_min:
            raise ValueError(
                f"pause_min = {self.pause_min:g}: must be shorter than cycle_min = {self.cycle_min:g}, since a cycle "
                "is milling and its pause together"
            )
        if self.duration_h * 60 / self.cycle_min > MOST_CYCLES:
            raise ValueError(f"cycle_min = {self.cycle_min:g}: more than {MOST_CYCLES} cycles in duration_h")
        return self

    @property
    def milling_min(self) -> float:
        """Milling without a pause in a cycle [min]."""
        return self.cycle_min - self.pause_min


class LimitSection(Section):
    """The temperature to stay below."""

    temperature_degC: float = 50.0
    """limit [degC]; the thesis set its Emax to stay below 50 degC (chapter 2)"""
    body: BodyName = "powder"
    """what must stay below it"""


class FlashSection(Section):
    """Properties of balls and wall for the estimate of flash temperatures. They are those of the real material.

    The simulation has a softer Young's modulus; forces and durations of contact are scaled to the real one.
    """

    young_modulus_gpa: Positive = 205.0
    """Young's modulus of steel [GPa], thesis Sec. 3.2.3"""
    hardness_gpa: Positive = 7.0
    """hardness of the balls, the largest mean pressure in a contact [GPa]; hardened steel, handbook values"""
    density_kg_m3: Positive = 7800.0
    """density of balls and wall [kg/m3]; steel"""
    heat_capacity_J_kgK: Positive = 480.0
    """specific heat of balls and wall [J/kgK]; steel"""
    conductivity_W_mK: RangeSection = known(15, 46, "from stainless to bearing steel: handbook values")
    """thermal conductivity of balls and wall [W/mK]"""

    @model_validator(mode="after")
    def _conducts(self) -> "FlashSection":
        Bounds("thermal conductivity", "W/mK", 0.0, 1e4).check("conductivity_W_mK", self.conductivity_W_mK)
        return self


class HeatConfig(Section):
    """Temperatures of balls, powder and jar from the dissipation of finished simulations: target `heat`."""

    mills: list[Name] = []
    """mills whose heat balance is part of the whole run, in addition to the run's mill: files in config/mills"""
    samples: Annotated[int, Field(ge=8, le=100_000)] = 200
    """samples of the parameters, a Latin hypercube over their ranges"""
    # Probability of every band [-].
    probability: ClassVar[float] = 0.9
    programme: ProgrammeSection = ProgrammeSection()
    limit: LimitSection = LimitSection()
    powder_mass_g: Positive | None = None
    """powder in the jar [g]; from ball_to_powder_ratio if left out"""
    jars: dict[Name, JarSection] = {
        "emax": JarSection(cooling="water"),
        "attritor": JarSection(cooling="water"),
        "drum": JarSection(cooling="still_air"),
    }
    """the jars of mills by name; a mill that is not named has the defaults"""
    surroundings: SurroundingsSection = SurroundingsSection()
    parameters: HeatParametersSection = HeatParametersSection()
    flash: FlashSection = FlashSection()

    @model_validator(mode="after")
    def _limit_above_surroundings(self) -> "HeatConfig":
        kinds = {"moving_air", *(jar.cooling for jar in self.jars.values())}
        for kind in sorted(kinds):
            warmest = getattr(self.surroundings, kind).temperature_degC.high
            if self.limit.temperature_degC <= warmest:
                raise ValueError(
                    f"limit.temperature_degC = {self.limit.temperature_degC:g}: must be above the surroundings, "
                    f"surroundings.{kind}.temperature_degC.high = {warmest:g}"
                )
        return self

    def jar_of(self, mill: str) -> JarSection:
        """What is known of the jar of a mill."""
        return self.jars.get(mill, JarSection())


class SpectraConfig(FurtherRules):
    """Energy spectra. Every mill and condition has the same bins, with an open bin at either end."""


class ChargeConfig(Section):
    """How much powder is milled, and how long."""

    bpr: Annotated[float, Field(gt=0, le=1e4)]
    """ball-to-powder ratio [-]"""
    time_h: Annotated[float, Field(gt=0, le=1e4)]
    """milling time [h]"""


class WearConfig(Section):
    """Wear of the balls by Archard's law on the sliding work of the simulations."""

    materials: ProjectFile = "config/data/wear_materials.tsv"
    """table of materials: density, hardness with its range, share of iron"""
    material: str = "stainless_steel"
    """what the balls and the jar of data.wear are made of"""
    charges: list[ChargeConfig] = Field(
        default=[ChargeConfig(bpr=50, time_h=20), ChargeConfig(bpr=30, time_h=12.5)], min_length=1
    )
    """powder and time for which the wear is predicted, at every simulated condition"""


class DoseConfig(Section):
    """What the powder has been through (results/dose); target `dose`."""

    spectra: SpectraConfig = SpectraConfig()
    wear: WearConfig = WearConfig()
    heat: HeatConfig = HeatConfig()
