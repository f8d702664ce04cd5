"""Settings of the wet laboratory: the reaction, the charge of the jar, the gas over water, the spent solution."""

from typing import Annotated

from pydantic import Field

from millprint.config.section import Count, Positive, Section

Purity = Annotated[float, Field(gt=0, le=1)]


class ChemistryConfig(Section):
    """The reaction: a limiting reactant, a reductant, and the gas that the product gives (thesis Eq. 3.27).

    Both formulas are checked by `millprint.doe.chemistry.check_formulas`, which knows the elements.
    """

    limiting: str = Field(description="formula of the limiting reactant, such as NaBO2.4H2O")
    reductant: str = Field(description="formula of the other reactant, such as MgH2")
    stoichiometric_ratio: Positive = Field(description="mol of reductant that a mol of limiting reactant takes up [-]")
    gas_per_mole: Positive = Field(
        description="mol of gas collected for a mol of limiting reactant that is all converted [-]"
    )
    limiting_purity: Purity = Field(default=1.0, description="mass share of the limiting reactant in its powder [-]")
    reductant_purity: Purity = Field(default=1.0, description="mass share of the reductant in its powder [-]")


class HalfLifeConfig(Section):
    """Conditions of the spent solution (thesis Eq. 2.7)."""

    ph: float = Field(ge=7, le=14, description="pH of the solution [-]")
    temperature_k: float = Field(ge=273, le=373, description="temperature of the solution [K]")


class PowderConfig(Section):
    """The charge of the jar in the screening runs."""

    balls: Count = Field(description="number of balls in the jar [-]")
    ball_mass_g: Positive = Field(description="mass of all of them together [g]")


class GasConfig(Section):
    """Conditions of the hydrogen collected over water; within the bounds the vapour never reaches the pressure."""

    temperature_k: float = Field(
        default=298.15, ge=273.15, le=353.15, description="temperature of the gas and the water [K]"
    )
    pressure_pa: float = Field(default=101325.0, ge=5e4, le=2e5, description="total pressure of the gas [Pa]")
    saturated: bool = Field(default=True, description="whether the gas holds water vapour, which is then taken off")
    yield_max_percent: float = Field(
        default=105.0, ge=100, description="computed yield above which a reading of the gas is refused [%]"
    )


class WetLabConfig(Section):
    """What the wet-lab command needs of the section `doe`."""

    chemistry: ChemistryConfig
    gas: GasConfig = GasConfig()
