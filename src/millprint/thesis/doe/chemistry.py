"""The reaction of the wet laboratory: molar masses, reactants, half-life of the product, gas over water, yield.

The literature (thesis Tables 2.1 and 2.2): unreported parameters, and numbers that disagree.
"""

from dataclasses import dataclass
from math import isnan, pi

import numpy as np
import pandas as pd
from molmass import Formula, FormulaError
from scipy.constants import gas_constant

from millprint.config.doe import ChemistryConfig
from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate
from millprint.estimate.judge import Allowed, judge
from millprint.run.tables import Number, Text, read_measured, refuse_rows
from millprint.thesis.doe.factorial_designs import PERCENT_YIELD, YIELD

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


POSITIVE_PARAMETERS = (
    "borate_mass_g",
    "reductant_mass_g",
    "powder_mass_g",
    "molar_ratio",
    "speed_rpm",
    "time_h",
    "jar_volume_ml",
    "ball_volume_percent",
    "bpr",
)
# Diameters and numbers of balls are text, because mixed balls are given as 10/4 mm.
TEXT_PARAMETERS = ("ball_diameter_mm", "balls", "mill", "vessel")
PARAMETERS = [*POSITIVE_PARAMETERS, *TEXT_PARAMETERS]
REACTANTS = ("borate", "reductant")
# Bearing and stainless steels lie within 2 % of it [g/cm3].
STEEL_DENSITY = 7.8
# Masses and ratios have two digits, so numbers that agree differ by no more than this.
TOLERANCE = 0.1


def read_literature(path: str) -> pd.DataFrame:
    """Read the studies, a row each (Table 2.2); an empty cell is a parameter that the study does not report.

    Raises ConfigError for a missing column, a text in a column of numbers, a number that is not above 0, a yield
    outside 0 to 100 %, a study that appears twice, and a reactant without a valid formula.
    """
    positive = [Number(name, 0, above=True, may_be_blank=True) for name in POSITIVE_PARAMETERS]
    frame = _read_studies(path, Text("reference", unique=True), *map(Text, TEXT_PARAMETERS), *positive)
    for column, pattern in (("ball_diameter_mm", r"\d+(\.\d+)?(/\d+(\.\d+)?)*"), ("balls", r"\d+(/\d+)*")):
        bad = frame[column].notna() & ~frame[column].fillna("").str.fullmatch(pattern)
        refuse_rows(frame, path, column, bad, "must be a number, or several such as 10/4")
    refuse_rows(
        frame,
        path,
        "balls",
        frame["ball_diameter_mm"].str.count("/").sub(frame["balls"].str.count("/")).fillna(0) != 0,
        lambda study: f"must be as many numbers as diameters ({study['ball_diameter_mm']})",
    )
    return frame


def read_reported_yields(path: str) -> pd.DataFrame:
    """Read the yields (Table 2.1), a row for each study and its reactants; raises ConfigError as `read_literature`."""
    return _read_studies(path, Text("reference"))


def _read_studies(path: str, *columns: Number | Text) -> pd.DataFrame:
    frame = read_measured(path, [*columns, *map(Text, REACTANTS), Number("year"), PERCENT_YIELD])
    for column in REACTANTS:
        bad = [not _is_formula(str(text)) for text in frame[column]]
        refuse_rows(frame, path, column, bad, "must be a formula such as MgH2")
    return frame


def _is_formula(text: str) -> bool:
    try:
        molar_mass(text)
    except FormulaError:
        return False
    return True


def missingness_table(studies: pd.DataFrame) -> pd.DataFrame:
    """A row a parameter, a column a study: yes where it is reported, no where not; least reported parameters first."""
    missing = studies.set_index("reference")[PARAMETERS].isna().T
    table = missing.map(lambda left_out: "no" if left_out else "yes").add_prefix("reference_")
    table.insert(0, "parameter", table.index)
    table["studies"] = missing.shape[1]
    table["unreported"] = missing.sum(axis=1)
    table["unreported_percent"] = 100 * missing.mean(axis=1)
    return table.sort_values("unreported", ascending=False, kind="stable", ignore_index=True)


def literature_checks(studies: pd.DataFrame, yields: pd.DataFrame) -> pd.DataFrame:
    """Every number of a study that follows from its others, and the yields of the two tables against each other.

    Within 10 % they agree. `studies` is Table 2.2, `yields` Table 2.1. Columns reference, check, reported, follows,
    verdict, note.
    """
    borates = list(dict.fromkeys([*studies["borate"], *yields["borate"]]))
    rows = []
    for _, study in studies.iterrows():
        rows += _check_masses(study, borates) + _check_balls(study)
        own = yields[yields["reference"] == study["reference"]]
        same = own[(own["borate"] == study["borate"]) & (own["reductant"] == study["reductant"])]
        match = own.loc[own[YIELD] == study[YIELD], "borate"]
        note = f"Table 2.1 gives this yield for {match.iloc[0]}" if len(match) else "the two tables differ"
        check = "yield in Tables 2.2 and 2.1 [%]"
        rows += [_row(study, check, study[YIELD], other, note, tolerance=0.0) for other in same[YIELD]]
    return pd.DataFrame(rows)


def _row(
    study: pd.Series, check: str, reported: float, follows: float, note: str, tolerance: float = TOLERANCE
) -> dict[str, object]:
    found = judge(Estimate(abs(follows / reported - 1), "-"), Allowed(upper=tolerance))
    return {
        "reference": study["reference"],
        "check": check,
        "reported": reported,
        "follows": follows,
        "verdict": found.word,
        "note": "" if found.agrees else note,
    }


def _molar_ratio(study: pd.Series, borate: str) -> float:
    amounts = study["reductant_mass_g"] / molar_mass(study["reductant"]), study["borate_mass_g"] / molar_mass(borate)
    return amounts[0] / amounts[1]


def _check_masses(study: pd.Series, borates: list[str]) -> list[dict]:
    """Compare the total mass and the molar ratio of a study with its two masses."""
    total, rows = study["borate_mass_g"] + study["reductant_mass_g"], []
    if isnan(total):
        return []
    if not isnan(study["powder_mass_g"]):
        rows.append(_row(study, "total mass [g]", study["powder_mass_g"], total, "the two masses make another sum"))
    if not isnan(study["molar_ratio"]):
        reported = study["molar_ratio"]
        others = [name for name in borates if abs(_molar_ratio(study, name) / reported - 1) <= TOLERANCE]
        note = f"follows from the masses if the borate is {others[0]}" if others else "follows for no hydrate"
        rows.append(_row(study, "molar ratio [-]", reported, _molar_ratio(study, study["borate"]), note))
    return rows


def _check_balls(study: pd.Series) -> list[dict]:
    """The share of the jar and the ball-to-powder ratio of a study against its balls, where it gives enough of them."""
    counted = isinstance(study["ball_diameter_mm"], str) and isinstance(study["balls"], str)
    if counted:
        diameters, numbers = (np.array(study[name].split("/"), float) for name in ("ball_diameter_mm", "balls"))
        volume = sum(numbers * pi / 6 * (diameters / 10) ** 3)
    else:
        volume = study["jar_volume_ml"] * study["ball_volume_percent"] / 100
    if isnan(volume):
        return []
    rows = []
    if counted and not isnan(study["ball_volume_percent"]):
        share = 100 * volume / study["jar_volume_ml"]
        rows.append(_row(study, "ball volume in jar [%]", study["ball_volume_percent"], share, "another fill"))
    if not isnan(study["powder_mass_g"]) and not isnan(study["bpr"]):
        needed = study["bpr"] * study["powder_mass_g"] / volume
        note = f"balls of {needed:.1f} g/cm3 would be needed; steel has {STEEL_DENSITY:g}, tungsten carbide 15.6"
        ratio = STEEL_DENSITY * volume / study["powder_mass_g"]
        rows.append(_row(study, "ball-to-powder ratio with steel balls [-]", study["bpr"], ratio, note))
    return rows
