"""Conversion yield from the hydrogen collected over water (thesis Sec. 2.2.4)."""

import numpy as np
from scipy.constants import gas_constant

from millprint.config.wet_lab import ChemistryConfig
from millprint.doe.species import molar_mass

# Wagner and Pruss, J. Phys. Chem. Ref. Data 31, 387 (2002), Eq. 2.5: the vapour pressure of water.
CRITICAL_TEMPERATURE = 647.096
CRITICAL_PRESSURE = 22.064e6
COEFFICIENTS = np.array([-7.85951783, 1.84408259, -11.7866497, 22.6807411, -15.9618719, 1.80122502])
EXPONENTS = np.array([1.0, 1.5, 3.0, 3.5, 4.0, 7.5])


def vapour_pressure(temperature: np.ndarray | float) -> np.ndarray:
    """Saturation pressure of water at `temperature` [K], from freezing to the critical point [Pa].

    Raises ValueError outside 273.15 to 647.096 K.
    """
    temperature = np.asarray(temperature, dtype=float)
    if not np.all((temperature >= 273.15) & (temperature <= CRITICAL_TEMPERATURE)):
        raise ValueError(f"temperature = {temperature} K: between 273.15 and {CRITICAL_TEMPERATURE} K is wanted")
    rest = 1 - temperature / CRITICAL_TEMPERATURE
    exponent = CRITICAL_TEMPERATURE / temperature * np.sum(COEFFICIENTS * rest[..., None] ** EXPONENTS, axis=-1)
    return CRITICAL_PRESSURE * np.exp(exponent)


def dry_pressure(temperature: np.ndarray | float, pressure: np.ndarray | float, saturated: bool = True) -> np.ndarray:
    """The pressure of the gas alone: P - P_water(T) where it is saturated with water, else P [Pa].

    temperature [K], total pressure [Pa]. Raises ValueError where the vapour alone would exceed the pressure.
    """
    vapour = vapour_pressure(temperature) if saturated else 0.0
    dry = np.asarray(pressure, dtype=float) - vapour
    if np.any(dry <= 0):
        raise ValueError(
            f"{pressure} Pa at {temperature} K: a pressure above the vapour pressure of water ({vapour} Pa) is wanted"
        )
    return dry


def hydrogen_amount(
    volume: np.ndarray | float,
    temperature: np.ndarray | float,
    pressure: np.ndarray | float,
    saturated: bool = True,
) -> np.ndarray:
    """Hydrogen in gas collected over water: n = (P - P_water(T)) V / (R T) [mol].

    volume [m3] and the total pressure [Pa] of the gas at `temperature` [K]; of dry gas if not `saturated`. Raises
    ValueError where the vapour alone would exceed the pressure, or for a negative volume.
    """
    if np.any(np.asarray(volume) < 0):
        raise ValueError(f"volume = {volume} m3: a positive volume is wanted")
    return dry_pressure(temperature, pressure, saturated) * volume / (gas_constant * np.asarray(temperature))


def full_amount(limiting_mass: np.ndarray | float, chemistry: ChemistryConfig) -> np.ndarray:
    """Gas from `limiting_mass` [kg] of the limiting reactant's powder, all converted [mol]."""
    pure = np.asarray(limiting_mass) * chemistry.limiting_purity
    return chemistry.gas_per_mole * pure / molar_mass(chemistry.limiting)


def gas_yield(
    volume: np.ndarray | float,
    temperature: np.ndarray | float,
    pressure: np.ndarray | float,
    limiting_mass: np.ndarray | float,
    chemistry: ChemistryConfig,
    saturated: bool = True,
) -> np.ndarray:
    """Conversion yield: gas collected over the gas of a full conversion, 4 mol for each mol of NaBO2.4H2O [-].

    volume [m3], temperature [K] and total pressure [Pa] of the gas; limiting_mass [kg].
    """
    return hydrogen_amount(volume, temperature, pressure, saturated) / full_amount(limiting_mass, chemistry)


def gas_volume(
    conversion: np.ndarray | float,
    temperature: np.ndarray | float,
    pressure: np.ndarray | float,
    limiting_mass: np.ndarray | float,
    chemistry: ChemistryConfig,
    saturated: bool = True,
) -> np.ndarray:
    """Volume of gas collected at a yield `conversion` [-], the inverse of `gas_yield` [m3]."""
    return conversion / gas_yield(1.0, temperature, pressure, limiting_mass, chemistry, saturated)


def yield_error(
    errors: dict[str, np.ndarray | float],
    volume: np.ndarray | float,
    temperature: np.ndarray | float,
    pressure: np.ndarray | float,
    limiting_mass: np.ndarray | float,
    chemistry: ChemistryConfig,
    saturated: bool = True,
) -> np.ndarray:
    """Standard deviation of a gas yield Y from independent errors of what was read, to first order [-].

    u2 = (dY/dV u_V)2 + Y2 [(u_m / m)2 + (u_P / P_dry)2 + u_T2 (1 / T + P_water'(T) / P_dry)2]. `errors` holds standard
    deviations of volume [m3], temperature [K], pressure [Pa] and limiting_mass [kg]; what is missing counts as exact.
    """
    dry = dry_pressure(temperature, pressure, saturated)
    temperature = np.asarray(temperature, dtype=float)
    step = 1e-3
    slope = (vapour_pressure(temperature + step) - vapour_pressure(temperature)) / step if saturated else 0.0
    for_a_volume = gas_yield(1.0, temperature, pressure, limiting_mass, chemistry, saturated)
    relative = (
        (errors.get("limiting_mass", 0.0) / np.asarray(limiting_mass)) ** 2
        + (errors.get("pressure", 0.0) / dry) ** 2
        + (errors.get("temperature", 0.0) * (1 / temperature + slope / dry)) ** 2
    )
    return for_a_volume * np.sqrt(np.asarray(errors.get("volume", 0.0)) ** 2 + np.asarray(volume) ** 2 * relative)
