"""Settings of the partition stage."""

from typing import ClassVar, NamedTuple

from millprint.config.section import Fraction, NonNegative, Section


class Prior(NamedTuple):
    """Earlier work: yield [%], milling time [h], ball-to-powder mass ratio [-], speed of the mill [Hz]."""

    yield_percent: float
    time_h: float
    bpr: float
    speed_hz: float


class PartitionConfig(Section):
    """Settings of the partition stage."""

    # Contact set whose master curves are used.
    contact: ClassVar[str] = "calibrated"
    # Ball diameter of the cases [mm].
    ball_diameter_mm: ClassVar[float] = 10.0
    # Speed of the reference and of the constant-speed cases [rpm].
    reference_speed_rpm: ClassVar[float] = 600.0
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
    # Probability of the confidence intervals [-].
    interval: ClassVar[float] = 0.95
    # Chen et al. 2017, with which Table 4.3 compares the best case.
    prior: ClassVar[Prior] = Prior(yield_percent=88.0, time_h=20.0, bpr=50.0, speed_hz=20.0)
