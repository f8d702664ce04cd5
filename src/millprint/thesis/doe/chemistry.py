"""The reaction of the wet laboratory: molar masses, reactants, half-life of the product, gas over water, yield."""

from dataclasses import dataclass

import numpy as np
from molmass import Formula, FormulaError
from scipy.constants import gas_constant

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError

# A number, an array, or a pandas column.
Quantity = np.ndarray | float

# The pressure of water vapour: Wagner and Pruss, J. Phys. Chem. Ref. Data 31, 387 (2002), Eq. 2.5.
CRITICAL_TEMPERATURE = 647.096
CRITICAL_PRESSURE = 22.064e6
VAPOUR_COEFFICIENTS = np.array([-7.85951783, 1.84408259, -11.7866497, 22.6807411, -15.9618719, 1.80122502])
VAPOUR_EXPONENTS = np.array([1.0, 1.5, 3.0, 3.5, 4.0, 7.5])


def molar_mass(formula: str) -> float:
    """Molar mass of a formula such as NaBO2.4H2O [kg/mol]; raises molmass.FormulaError for an invalid formula."""
    return 1e-3 * Formula(formula).mass


def check_formulas(reaction: ChemistryConfig, place: str) -> None:
    """Raise ConfigError, in one line, for the first reactant without a valid formula; place: file and section."""
    for key in ("limiting", "reductant"):
        text = getattr(reaction, key)
        try:
            mass, why = molar_mass(text), "it has no mass"
        except FormulaError as error:
            mass, why = 0.0, str(error).splitlines()[0]
        if not mass > 0:
            raise ConfigError(f"{place}.{key}: formula {text!r}: {why}; a valid formula is, for example, NaBO2.4H2O")


def powder_mass(ball_mass: Quantity, ball_to_powder: Quantity) -> Quantity:
    """Mass of powder for balls of total mass `ball_mass` [kg] at a mass ratio `ball_to_powder` [-]: [kg]."""
    return ball_mass / ball_to_powder


def ball_mass(balls: Quantity, diameter: Quantity, density: Quantity) -> Quantity:
    """Total mass of `balls` spheres of `diameter` [m] and `density` [kg/m3]: [kg]."""
    return balls * density * np.pi / 6 * np.asarray(diameter) ** 3


def reactant_masses(powder: Quantity, molar_ratio: Quantity, reaction: ChemistryConfig) -> tuple[Quantity, Quantity]:
    """Masses of the limiting reactant and of the reductant to weigh in, together `powder` [kg]: a pair [kg].

    molar_ratio: mol of pure reductant for a mol of pure limiting reactant. A powder with a purity below 1 holds less
    of its reactant, so more of it is weighed in.
    """
    limiting = molar_mass(reaction.limiting) / reaction.limiting_purity
    reductant = molar_ratio * molar_mass(reaction.reductant) / reaction.reductant_purity
    return powder * limiting / (limiting + reductant), powder * reductant / (limiting + reductant)


def hydrogen_released(reaction: ChemistryConfig) -> float:
    """Hydrogen that the reaction gives off in the jar at full conversion [mol per mol of the limiting reactant].

    What is left of the hydrogen of both reactants, (H_limiting + s H_reductant - g) / 2, with s the stoichiometric
    ratio and g the hydrogen that the product keeps: a mol of borohydride with g H gives g mol of gas by hydrolysis
    (`gas_per_mole`), half of it from the water. NaBO2.4H2O + 6 MgH2 -> NaBH4 + 6 MgO + 8 H2: (8 + 6 x 2 - 4) / 2 = 8.
    The 6 mol MgO are the thesis's, the rest is the balance of atoms; reactions of hydrates: Ouyang, Zhong, Li and Zhu,
    Inorganics 6, 10 (2018). The water of the hydrate gives off the same 8 mol if it oxidises MgH2 without forming
    borohydride, MgH2 + H2O -> MgO + 2 H2. So a poor yield does not mean less gas.
    """

    def atoms(formula: str) -> int:
        return sum(item.count for symbol, item in Formula(formula).composition().items() if symbol in ("H", "D"))

    held = atoms(reaction.limiting) + reaction.stoichiometric_ratio * atoms(reaction.reductant)
    return max(held - reaction.gas_per_mole, 0.0) / 2


def excess(molar_ratio: Quantity, reaction: ChemistryConfig) -> Quantity:
    """Excess of the reductant over what the reaction needs: 10 over 6 gives 0.667, printed as 66 % [-]."""
    return molar_ratio / reaction.stoichiometric_ratio - 1


def half_life(ph: Quantity, temperature: Quantity) -> Quantity:
    """Half-life of dissolved NaBH4 by Kreevoy and Jacobson (thesis Eq. 2.7) [s].

    log10(t / min) = pH - (0.034 T - 1.92), T = `temperature` [K].
    """
    return 60.0 * 10.0 ** (ph - (0.034 * temperature - 1.92))


def share_lost(time: Quantity, half_life_s: Quantity) -> Quantity:
    """Share of the NaBH4 that has decomposed after `time` [s], by first order: 1 - 2^(-t / t_half) [-]."""
    return -np.expm1(-np.log(2.0) * time / half_life_s)


def vapour_pressure(temperature: Quantity) -> np.ndarray:
    """Saturation pressure of water at `temperature` [K], from freezing to the critical point: same shape [Pa].

    ln(P / P_c) = (T_c / T) sum_i a_i (1 - T / T_c)^(n_i), Wagner and Pruss (2002), Eq. 2.5.
    Raises ValueError outside 273.15 to 647.096 K.
    """
    temperature = np.asarray(temperature, dtype=float)
    if not np.all((temperature >= 273.15) & (temperature <= CRITICAL_TEMPERATURE)):
        raise ValueError(f"temperature = {temperature} K: must be between 273.15 and {CRITICAL_TEMPERATURE} K")
    rest = 1 - temperature / CRITICAL_TEMPERATURE
    powers = np.sum(VAPOUR_COEFFICIENTS * rest[..., None] ** VAPOUR_EXPONENTS, axis=-1)
    return CRITICAL_PRESSURE * np.exp(CRITICAL_TEMPERATURE / temperature * powers)


@dataclass(frozen=True)
class GasConditions:
    """Conditions at which gas is collected: `temperature` [K] and total `pressure` [Pa], numbers or arrays.

    saturated: whether the gas holds water vapour at its saturation pressure.
    """

    temperature: Quantity
    pressure: Quantity
    saturated: bool = True

    @property
    def dry_pressure(self) -> np.ndarray:
        """Pressure of the gas without vapour: P - P_water(T), or P of dry gas [Pa]; ValueError unless above 0."""
        vapour = vapour_pressure(self.temperature) if self.saturated else 0.0
        dry = np.asarray(self.pressure, dtype=float) - vapour
        if np.any(dry <= 0):
            raise ValueError(
                f"{self.pressure} Pa at {self.temperature} K: must be above the vapour pressure of water ({vapour} Pa)"
            )
        return dry


def gas_amount(volume: Quantity, conditions: GasConditions) -> np.ndarray:
    """Hydrogen in a `volume` [m3] of collected gas: n = P_dry V / (R T) [mol].

    Volume and conditions broadcast. Raises ValueError for a negative volume, and as `GasConditions.dry_pressure`.
    """
    if np.any(np.asarray(volume) < 0):
        raise ValueError(f"volume = {volume} m3: must be a positive volume or 0")
    return conditions.dry_pressure * volume / (gas_constant * np.asarray(conditions.temperature))


def full_amount(limiting_mass: Quantity, reaction: ChemistryConfig) -> np.ndarray:
    """Gas from a full conversion of `limiting_mass` [kg] of the limiting reactant's powder [mol]."""
    pure = np.asarray(limiting_mass) * reaction.limiting_purity
    return reaction.gas_per_mole * pure / molar_mass(reaction.limiting)


def gas_yield(
    volume: Quantity, conditions: GasConditions, limiting_mass: Quantity, reaction: ChemistryConfig
) -> np.ndarray:
    """Conversion yield: gas collected over the gas of a full conversion, 4 mol for each mol of NaBO2.4H2O [-].

    volume [m3] and limiting_mass [kg] broadcast with the conditions (thesis Sec. 2.2.4). Raises ValueError as
    `gas_amount`.
    """
    return gas_amount(volume, conditions) / full_amount(limiting_mass, reaction)


def yield_error(
    errors: dict[str, Quantity],
    volume: Quantity,
    conditions: GasConditions,
    limiting_mass: Quantity,
    reaction: ChemistryConfig,
) -> np.ndarray:
    """Standard deviation of a gas yield Y from independent errors of the readings, to first order [-].

    u2 = (dY/dV u_V)2 + Y2 [(u_m / m)2 + (u_P / P_dry)2 + u_T2 (1 / T + P_water'(T) / P_dry)2]. `errors` holds standard
    deviations of volume [m3], temperature [K], pressure [Pa] and limiting_mass [kg]; a reading without one is exact.
    """
    dry = conditions.dry_pressure
    temperature = np.asarray(conditions.temperature, dtype=float)
    step = 1e-3
    slope = 0.0
    if conditions.saturated:
        slope = (vapour_pressure(temperature + step) - vapour_pressure(temperature)) / step
    for_a_volume = gas_yield(1.0, conditions, limiting_mass, reaction)
    relative = (
        (errors.get("limiting_mass", 0.0) / np.asarray(limiting_mass)) ** 2
        + (errors.get("pressure", 0.0) / dry) ** 2
        + (errors.get("temperature", 0.0) * (1 / temperature + slope / dry)) ** 2
    )
    return for_a_volume * np.sqrt(np.asarray(errors.get("volume", 0.0)) ** 2 + np.asarray(volume) ** 2 * relative)
