"""Settings of the partition stage."""

from pydantic import Field

from millprint.config.section import Fraction, Name, NonNegative, Positive, Section


class PriorConfig(Section):
    """Earlier work that the best case is compared with."""

    source: str = Field(description="where the numbers come from")
    yield_percent: Positive = Field(le=100, description="yield [%]")
    time_h: Positive = Field(description="milling time [h]")
    bpr: Positive = Field(description="ball-to-powder mass ratio [-]")
    speed_hz: Positive = Field(description="mill speed [Hz]")


class PartitionConfig(Section):
    """Settings of the partition stage."""

    contact: Name = Field(description="contact set whose master curves are used")
    ball_diameter_mm: Positive = Field(description="ball diameter of the cases [mm]")
    reference_speed_rpm: Positive = Field(description="speed of the reference and of the constant-speed cases [rpm]")
    fill_ratios: list[Fraction] = Field(default=[], description="further fill ratios of equal speed and of equal power")
    borate_molar_mass_g_mol: Positive = Field(default=137.86, description="molar mass of NaBO2.4H2O [g/mol]")
    borohydride_molar_mass_g_mol: Positive = Field(default=37.83, description="molar mass of NaBH4 [g/mol]")
    enthalpy_kJ_mol: Positive = Field(default=1226.0, description="size of the reaction enthalpy [kJ per mol NaBH4]")
    gibbs_kJ_mol: Positive = Field(default=1510.0, description="size of the Gibbs energy at 298 K [kJ per mol NaBH4]")
    lower_heating_value_kJ_mol: Positive = Field(default=2908.0, description="that of the H2 [kJ per mol NaBH4]")
    plug_efficiency: Fraction = Field(
        default=0.5, description="assumed power of the balls over the plug's, Eq. 4.8 [-]"
    )
    electricity_price_EUR_kWh: NonNegative = Field(default=0.2, description="assumed price, Eq. 4.9 [EUR/kWh]")
    interval: Fraction = Field(default=0.95, description="probability of the confidence intervals [-]")
    prior: PriorConfig = Field(description="earlier work of Table 4.3")
