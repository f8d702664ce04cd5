"""Conversion yield from the hydrogen collected over water (thesis Sec. 2.2.4)."""

import numpy as np
from scipy.constants import gas_constant

from millprint.doe.species import BORATE, HYDROGEN_PER_BOROHYDRIDE, molar_mass

# Wagner and Pruss, J. Phys. Chem. Ref. Data 31, 387 (2002), Eq. 2.5: the vapour pressure of water.
CRITICAL_TEMPERATURE = 647.096
CRITICAL_PRESSURE = 22.064e6
COEFFICIENTS = np.array([-7.85951783, 1.84408259, -11.7866497, 22.6807411, -15.9618719, 1.80122502])
EXPONENTS = np.array([1.0, 1.5, 3.0, 3.5, 4.0, 7.5])


def vapour_pressure(temperature: float) -> float:
    """Saturation pressure of water at `temperature` [K], from freezing to the critical point [Pa].

    Raises ValueError outside 273.15 to 647.096 K.
    """
    if not 273.15 <= temperature <= CRITICAL_TEMPERATURE:
        raise ValueError(f"temperature = {temperature} K: between 273.15 and {CRITICAL_TEMPERATURE} K is wanted")
    rest = 1 - temperature / CRITICAL_TEMPERATURE
    exponent = CRITICAL_TEMPERATURE / temperature * np.sum(COEFFICIENTS * rest**EXPONENTS)
    return float(CRITICAL_PRESSURE * np.exp(exponent))


def hydrogen_amount(volume: float, temperature: float, pressure: float) -> float:
    """Hydrogen in gas collected over water: n = (P - P_water(T)) V / (R T) [mol].

    volume [m3] and the total pressure [Pa] of the gas saturated with water at `temperature` [K]. Raises ValueError
    where the vapour alone would exceed the pressure, or for a negative volume.
    """
    dry = pressure - vapour_pressure(temperature)
    if dry <= 0 or np.any(np.asarray(volume) < 0):
        raise ValueError(
            f"volume = {volume} m3 at {pressure} Pa and {temperature} K: a positive volume and a pressure above the "
            f"vapour pressure of water ({vapour_pressure(temperature):.0f} Pa) are wanted"
        )
    return dry * volume / (gas_constant * temperature)


def gas_yield(volume: float, temperature: float, pressure: float, borate_mass: float) -> float:
    """Conversion yield: hydrogen collected over 4 mol for each mol of NaBO2.4H2O that was charged [-].

    volume [m3], temperature [K] and total pressure [Pa] of the gas over water; borate_mass [kg].
    """
    full = HYDROGEN_PER_BOROHYDRIDE * borate_mass / molar_mass(BORATE)
    return hydrogen_amount(volume, temperature, pressure) / full


def gas_volume(conversion: float, temperature: float, pressure: float, borate_mass: float) -> float:
    """Volume of moist gas collected at a yield `conversion` [-], the inverse of `gas_yield` [m3]."""
    return conversion / gas_yield(1.0, temperature, pressure, borate_mass)
