"""A chemist's own readings, a row a case, to what they stand for: yields, half-lives, and masses to weigh in."""

from collections.abc import Sequence
from types import MappingProxyType

import pandas as pd
from scipy.constants import g as GRAVITY

from millprint.config.wet_lab import ChemistryConfig, GasConfig
from millprint.doe.bounds import CASE, check_bounds, check_cases
from millprint.doe.gas import full_amount, gas_yield, hydrogen_amount, vapour_pressure, yield_error
from millprint.doe.half_life import half_life, share_lost
from millprint.doe.powder import ball_mass, excess, powder_mass, reactant_masses
from millprint.doe.runs import YIELD
from millprint.errors import ConfigError
from millprint.files import read_table

GRAM = 1e-3
MILLILITRE = 1e-6
MILLIMETRE = 1e-3
HOUR = 3600.0
WATER_DENSITY = 998.0  # at 20 degC [kg/m3]

# Lowest and highest value of each column; one above zero has no lowest.
BOUNDS = MappingProxyType(
    {
        "gas_volume_ml": (0, 1e6),
        "temperature_k": (273.15, 373.0),
        "pressure_pa": (5e4, 2e5),
        "ph": (7, 14),
        "wait_h": (0, 1e5),
        "water_head_mm": (-2000, 2000),
        "gas_volume_error_ml": (0, 1e6),
        "temperature_error_k": (0, 50),
        "pressure_error_pa": (0, 5e4),
        "limiting_mass_error_g": (0, 1e6),
    }
)
POSITIVE = ("limiting_mass_g", "bpr", "molar_ratio", "ball_mass_g", "balls", "ball_diameter_mm", "ball_density_kg_m3")
ERRORS = MappingProxyType(
    {
        "volume": ("gas_volume_error_ml", MILLILITRE),
        "temperature": ("temperature_error_k", 1.0),
        "pressure": ("pressure_error_pa", 1.0),
        "limiting_mass": ("limiting_mass_error_g", GRAM),
    }
)


def read_readings(path: str, required: Sequence[str], optional: Sequence[str] = ()) -> pd.DataFrame:
    """Read a table of readings: column case, the required ones, and those of the optional ones that are there.

    Raises ConfigError, in one line, for a missing column, a text or nothing in a column of numbers, a case that
    appears twice, and a value out of its bounds.
    """
    frame = read_table(path, text=[CASE])
    numeric = [*required, *(column for column in optional if column in frame)]
    frame = read_table(path, numeric=numeric, text=[CASE])
    check_cases(frame, path)
    for column in numeric:
        if column in POSITIVE:
            check_bounds(frame, path, column, 0, above=True)
        else:
            check_bounds(frame, path, column, *BOUNDS[column])
    return frame


def yield_table(path: str, chemistry: ChemistryConfig, gas: GasConfig) -> pd.DataFrame:
    """Yields from gas volumes: hydrogen_mmol, full_mmol, yield_percent, and what the vapour and the errors make of it.

    The table at `path` has gas_volume_ml, temperature_k, pressure_pa and limiting_mass_g. water_head_mm is how much
    higher the water stands inside than outside, so that the gas is at P - rho g h; columns of errors (ERRORS, standard
    deviations) give yield_error_percent. Raises ConfigError as `read_readings`, and for a yield above
    gas.yield_max_percent: that is another mass, another unit or air in the gas.
    """
    optional = ["water_head_mm", *(column for column, _ in ERRORS.values())]
    frame = read_readings(path, ["gas_volume_ml", "temperature_k", "pressure_pa", "limiting_mass_g"], optional)
    volume, temperature = frame["gas_volume_ml"] * MILLILITRE, frame["temperature_k"]
    pressure, mass = frame["pressure_pa"], frame["limiting_mass_g"] * GRAM
    if "water_head_mm" in frame:
        pressure = pressure - WATER_DENSITY * GRAVITY * frame["water_head_mm"] * MILLIMETRE
    _check_vapour(frame, path, temperature, pressure, gas.saturated)
    amount = hydrogen_amount(volume, temperature, pressure, gas.saturated)
    table = frame.assign(hydrogen_mmol=1e3 * amount, full_mmol=1e3 * full_amount(mass, chemistry))
    table[YIELD] = 100 * gas_yield(volume, temperature, pressure, mass, chemistry, gas.saturated)
    table["yield_if_vapour_ignored_percent"] = 100 * gas_yield(volume, temperature, pressure, mass, chemistry, False)
    errors = {name: frame[column] * unit for name, (column, unit) in ERRORS.items() if column in frame}
    if errors:
        conditions = (volume, temperature, pressure, mass, chemistry, gas.saturated)
        table["yield_error_percent"] = 100 * yield_error(errors, *conditions)
    _check_yields(table, path, gas.yield_max_percent)
    return table


def _check_vapour(frame: pd.DataFrame, path: str, temperature: pd.Series, pressure: pd.Series, saturated: bool) -> None:
    vapour = vapour_pressure(temperature)
    bad = pressure <= (vapour if saturated else 0.0)
    if bad.any():
        row = int(bad.to_numpy().argmax())
        raise ConfigError(
            f"{path}: column temperature_k, case {frame[CASE].iloc[row]} = {temperature.iloc[row]:g}: the vapour of "
            f"water alone has {vapour[row]:.0f} Pa, the gas {pressure.iloc[row]:.0f}; cooler gas is wanted"
        )


def _check_yields(table: pd.DataFrame, path: str, most: float) -> None:
    bad = table[YIELD] > most
    if bad.any():
        row = table.loc[bad].iloc[0]
        raise ConfigError(
            f"{path}: column gas_volume_ml, case {row[CASE]} = {row['gas_volume_ml']:g}: that is a yield of "
            f"{row[YIELD]:.0f} %; at most {most:g} % (gas.yield_max_percent) is wanted of {row['limiting_mass_g']:g} g"
        )


def solution_table(path: str) -> pd.DataFrame:
    """Half-lives of spent solutions (thesis Eq. 2.7), and the share lost while they waited if there is a wait_h.

    The table at `path` has ph and temperature_k. Raises ConfigError as `read_readings`.
    """
    frame = read_readings(path, ["ph", "temperature_k"], ["wait_h"])
    half = half_life(frame["ph"], frame["temperature_k"])
    table = frame.assign(half_life_h=half / HOUR, lost_in_an_hour_percent=100 * share_lost(HOUR, half))
    if "wait_h" in frame:
        table["lost_percent"] = 100 * share_lost(frame["wait_h"] * HOUR, half)
    return table


def weighed_in(powder: pd.Series, molar_ratio: pd.Series, chemistry: ChemistryConfig) -> dict[str, pd.Series]:
    """The columns of a charge: powder, both reactants, excess, and the amount of limiting reactant; powder in kg."""
    limiting, reductant = reactant_masses(powder, molar_ratio, chemistry)
    return {
        "excess_percent": 100 * excess(molar_ratio, chemistry),
        "powder_mass_g": powder / GRAM,
        "limiting_mass_g": limiting / GRAM,
        "reductant_mass_g": reductant / GRAM,
        "full_gas_mmol": 1e3 * full_amount(limiting, chemistry),
    }


def charge_table(path: str, chemistry: ChemistryConfig) -> pd.DataFrame:
    """Masses to weigh in for a ball-to-powder ratio and a molar ratio.

    The table at `path` has bpr, molar_ratio and either ball_mass_g, all balls together, or balls, ball_diameter_mm
    and ball_density_kg_m3. Raises ConfigError as `read_readings`.
    """
    if "ball_mass_g" in read_table(path, text=[CASE]):
        frame = read_readings(path, ["bpr", "molar_ratio", "ball_mass_g"])
        media = frame["ball_mass_g"] * GRAM
    else:
        frame = read_readings(path, ["bpr", "molar_ratio", "balls", "ball_diameter_mm", "ball_density_kg_m3"])
        media = ball_mass(frame["balls"], frame["ball_diameter_mm"] * MILLIMETRE, frame["ball_density_kg_m3"])
        frame = frame.assign(ball_mass_g=media / GRAM)
    return frame.assign(**weighed_in(powder_mass(media, frame["bpr"]), frame["molar_ratio"], chemistry))
