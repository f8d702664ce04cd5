"""Settings of the partition stage."""

from typing import ClassVar

from pydantic import Field

from millprint.config.section import Fraction, Name, NonNegative, Positive, Section


class PriorConfig(Section):
    """Earlier work that the best case is compared with."""

    source: str
    """where the numbers come from"""
    yield_percent: Positive = Field(le=100)
    """yield [%]"""
    time_h: Positive
    """milling time [h]"""
    bpr: Positive
    """ball-to-powder mass ratio [-]"""
    speed_hz: Positive
    """mill speed [Hz]"""


class PartitionConfig(Section):
    """Settings of the partition stage."""

    contact: Name
    """contact set whose master curves are used"""
    ball_diameter_mm: Positive
    """ball diameter of the cases [mm]"""
    reference_speed_rpm: Positive
    """speed of the reference and of the constant-speed cases [rpm]"""
    fill_ratios: list[Fraction] = []
    """further fill ratios of equal speed and of equal power"""
    borate_molar_mass_g_mol: ClassVar[float] = 137.86
    """molar mass of NaBO2.4H2O [g/mol]"""
    borohydride_molar_mass_g_mol: ClassVar[float] = 37.83
    """molar mass of NaBH4 [g/mol]"""
    enthalpy_kJ_mol: ClassVar[float] = 1226.0
    """size of the reaction enthalpy [kJ per mol NaBH4]"""
    gibbs_kJ_mol: ClassVar[float] = 1510.0
    """size of the Gibbs energy at 298 K [kJ per mol NaBH4]"""
    lower_heating_value_kJ_mol: ClassVar[float] = 2908.0
    """lower heating value of the H2 [kJ per mol NaBH4]"""
    plug_efficiency: Fraction = 0.5
    """assumed power of the balls over the plug's, Eq. 4.8 [-]"""
    electricity_price_EUR_kWh: NonNegative = 0.2
    """assumed price, Eq. 4.9 [EUR/kWh]"""
    interval: Fraction = 0.95
    """probability of the confidence intervals [-]"""
    prior: PriorConfig
    """earlier work of Table 4.3"""
