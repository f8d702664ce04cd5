"""Tables of the wet laboratory: your own readings, the screening runs, and the wear of the balls."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
from scipy.constants import g as GRAVITY
from scipy.constants import gram as GRAM
from scipy.constants import hour as HOUR

from millprint.config.doe import ChemistryConfig, GasConfig
from millprint.config.errors import ConfigError
from millprint.config.rows import read_cells
from millprint.dose.wear import FEWEST_HELD, FILL_TOLERANCE, LOADS, VICKERS, archard_mass, worn_load
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_rows
from millprint.thesis.doe import chemistry
from millprint.thesis.doe.factorial_designs import YIELD

MILLILITRE = 1e-6
MILLIMETRE = 1e-3
WATER_DENSITY = 998.0  # at 20 degC [kg/m3]
ROOM_TEMPERATURE_K, GAS_COLLECTION_K = 298.15, 353.15


def _positive(*names: str) -> list[Number]:
    return [Number(name, 0, above=True) for name in names]


# Bounds of the readings: a value outside has the wrong unit or an extra digit.
YIELD_READINGS = (
    Number("gas_volume_ml", 0, 1e6),
    Number("temperature_k", 273.15, 373.0),
    Number("pressure_pa", 5e4, 2e5),
    *_positive("limiting_mass_g"),
)
WATER_HEAD = Number("water_head_mm", -2000, 2000, optional=True)
# Standard deviations of the readings, by the quantity of `yield_error`, with the factor to SI units.
READING_ERRORS = {
    "volume": (Number("gas_volume_error_ml", 0, 1e6, optional=True), MILLILITRE),
    "temperature": (Number("temperature_error_k", 0, 50, optional=True), 1.0),
    "pressure": (Number("pressure_error_pa", 0, 5e4, optional=True), 1.0),
    "limiting_mass": (Number("limiting_mass_error_g", 0, 1e6, optional=True), GRAM),
}
SOLUTION_READINGS = (
    Number("ph", 7, 14),
    Number("temperature_k", 273.15, 373.0),
    Number("wait_h", 0, 1e5, optional=True),
)
CHARGE_READINGS = _positive("bpr", "molar_ratio")
WEIGHINGS = _positive("ball_diameter_mm", "speed_rpm", "time_h", "bpr", "unused_mass_g", "used_mass_g")


def _read_readings(path: str, columns: Sequence[Number]) -> pd.DataFrame:
    return read_measured(path, [Text(CASE, unique=True), *columns])


def yield_table(path: str, reaction: ChemistryConfig, gas: GasConfig) -> pd.DataFrame:
    """Yields from gas volumes: hydrogen_mmol, full_mmol, yield_percent, and the effect of the vapour and of errors.

    The table at `path` has case, gas_volume_ml, temperature_k, pressure_pa and limiting_mass_g. If there is a
    water_head_mm, the water stands that much higher inside than outside, and the gas has P - rho g h. Columns of
    READING_ERRORS give yield_error_percent. Raises ConfigError as `read_measured`, where the vapour pressure exceeds
    the total pressure, and for a yield above gas.yield_max_percent: a wrong mass or unit, or air in the gas.
    """
    frame = _read_readings(path, [*YIELD_READINGS, WATER_HEAD, *(column for column, _ in READING_ERRORS.values())])
    volume, mass = frame["gas_volume_ml"] * MILLILITRE, frame["limiting_mass_g"] * GRAM
    temperature, pressure = frame["temperature_k"], frame["pressure_pa"]
    if WATER_HEAD.name in frame:
        pressure = pressure - WATER_DENSITY * GRAVITY * frame[WATER_HEAD.name] * MILLIMETRE
    vapour = chemistry.vapour_pressure(temperature) if gas.saturated else 0.0 * temperature
    refuse_rows(
        frame.assign(vapour=vapour, gas=pressure),
        path,
        "temperature_k",
        pressure <= vapour,
        lambda row: f"only the vapour of water has {row['vapour']:.0f} Pa, the gas {row['gas']:.0f}; must be cooler",
    )
    conditions = chemistry.GasConditions(temperature, pressure, gas.saturated)
    amount = chemistry.gas_amount(volume, conditions)
    table = frame.assign(hydrogen_mmol=1e3 * amount, full_mmol=1e3 * chemistry.full_amount(mass, reaction))
    table[YIELD] = 100 * chemistry.gas_yield(volume, conditions, mass, reaction)
    dry = replace(conditions, saturated=False)
    table["yield_if_vapour_ignored_percent"] = 100 * chemistry.gas_yield(volume, dry, mass, reaction)
    errors = {name: frame[own.name] * unit for name, (own, unit) in READING_ERRORS.items() if own.name in frame}
    if errors:
        table["yield_error_percent"] = 100 * chemistry.yield_error(errors, volume, conditions, mass, reaction)
    refuse_rows(
        table,
        path,
        "gas_volume_ml",
        table[YIELD] > gas.yield_max_percent,
        lambda row: (
            f"a yield of {row[YIELD]:.0f} % of {row['limiting_mass_g']:g} g; must be at most "
            f"{gas.yield_max_percent:g} %"
        ),
    )
    return table


def solution_table(path: str) -> pd.DataFrame:
    """Half-lives of spent solutions (thesis Eq. 2.7), and the share lost in wait_h if the table has that column.

    The table at `path` has case, ph and temperature_k. Raises ConfigError as `read_measured`.
    """
    frame = _read_readings(path, SOLUTION_READINGS)
    half = chemistry.half_life(frame["ph"], frame["temperature_k"])
    table = frame.assign(half_life_h=half / HOUR, lost_in_an_hour_percent=100 * chemistry.share_lost(HOUR, half))
    if "wait_h" in frame:
        table["lost_percent"] = 100 * chemistry.share_lost(frame["wait_h"] * HOUR, half)
    return table


def _charge(powder: pd.Series, molar_ratio: pd.Series, reaction: ChemistryConfig) -> dict[str, pd.Series]:
    """Columns of a charge of `powder` [kg]: excess, masses of powder and reactants, gas of a full conversion."""
    limiting, reductant = chemistry.reactant_masses(powder, molar_ratio, reaction)
    return {
        "excess_percent": 100 * chemistry.excess(molar_ratio, reaction),
        "powder_mass_g": powder / GRAM,
        "limiting_mass_g": limiting / GRAM,
        "reductant_mass_g": reductant / GRAM,
        "full_gas_mmol": 1e3 * chemistry.full_amount(limiting, reaction),
    }


def charge_table(path: str, reaction: ChemistryConfig) -> pd.DataFrame:
    """Masses to weigh in for a ball-to-powder ratio and a molar ratio.

    The table at `path` has case, bpr, molar_ratio and either ball_mass_g, all balls together, or balls,
    ball_diameter_mm and ball_density_kg_m3. Raises ConfigError as `read_measured`.
    """
    if "ball_mass_g" in read_cells(path).header:
        frame = _read_readings(path, [*CHARGE_READINGS, *_positive("ball_mass_g")])
        media = frame["ball_mass_g"] * GRAM
    else:
        counted = _positive("balls", "ball_diameter_mm", "ball_density_kg_m3")
        frame = _read_readings(path, [*CHARGE_READINGS, *counted])
        media = chemistry.ball_mass(frame["balls"], frame["ball_diameter_mm"] * MILLIMETRE, frame["ball_density_kg_m3"])
        frame = frame.assign(ball_mass_g=media / GRAM)
    return frame.assign(**_charge(chemistry.powder_mass(media, frame["bpr"]), frame["molar_ratio"], reaction))


# The spent solution of NaBH4 (thesis Sec. 2.2.3): pH [-]; temperature [K], which the thesis rounds from 25 degC.
SPENT_PH, SPENT_TEMPERATURE_K = 11.0, 298.0


def half_life_table() -> pd.DataFrame:
    """Half-life of the solution (thesis Eq. 2.7) as configured, one pH lower and higher, at 25 and at 80 degC."""
    ph, kelvin = SPENT_PH, SPENT_TEMPERATURE_K
    conditions = [
        (ph, kelvin, "as configured"),
        (ph, ROOM_TEMPERATURE_K, "25 degC, not rounded"),
        *((ph + step, kelvin, f"pH {step:+g}") for step in (-1, 1) if 7 <= ph + step <= 14),
        (ph, GAS_COLLECTION_K, "80 degC, at which the gas is collected; without catalyst"),
    ]
    table = pd.DataFrame(conditions, columns=["ph", "temperature_k", "note"])
    half = chemistry.half_life(table["ph"], table["temperature_k"])
    table.insert(2, "half_life_h", half / HOUR)
    table.insert(3, "lost_in_an_hour_percent", 100 * chemistry.share_lost(HOUR, half))
    return table


def read_wear(path: str) -> pd.DataFrame:
    """Read the weighings of the balls (WEIGHINGS); an optional column wear_g holds the wear if it was weighed itself.

    Raises ConfigError for a mass that is not positive, balls that gained mass, or a wear that the two masses exclude.
    """
    frame = read_measured(path, [*WEIGHINGS, Number("wear_g", optional=True)])
    lost = frame["unused_mass_g"] - frame["used_mass_g"]
    refuse_rows(
        frame, path, "used_mass_g", lost < 0, lambda row: f"must be at most the unused mass, {row['unused_mass_g']:g} g"
    )
    if "wear_g" in frame:
        refuse_rows(
            frame.assign(lost=lost),
            path,
            "wear_g",
            (frame["wear_g"] - lost).abs() > READING_G * (1 + 1e-9),
            lambda row: f"must be within {READING_G:g} g of the difference of the two masses, {row['lost']:.3g} g",
        )
    return frame


def wear_table(weighings: pd.DataFrame) -> pd.DataFrame:
    """Weight loss of the balls and iron in the powder (thesis Table 2.6), by the wear and by the two masses.

    The iron is referred to the powder charged, m_balls / BPR, as in the thesis; with the iron itself in the
    denominator (column iron_of_mixture_percent) the share is smaller.
    """
    unused = weighings["unused_mass_g"]
    difference = unused - weighings["used_mass_g"]
    wear = weighings.get("wear_g", difference)
    powder = chemistry.powder_mass(unused, weighings["bpr"])
    return weighings[[column.name for column in WEIGHINGS]].assign(
        wear_g=wear,
        mass_difference_g=difference,
        powder_mass_g=powder,
        weight_loss_percent=100 * wear / unused,
        weight_loss_by_difference_percent=100 * difference / unused,
        reading_error_percent=100 * READING_G / unused,
        iron_percent=100 * wear / powder,
        iron_by_difference_percent=100 * difference / powder,
        iron_of_mixture_percent=100 * wear / (powder + wear),
        wear_per_hour_mg=1000 * wear / weighings["time_h"],
    )


# Balls are weighed to 0.01 g, so the difference of two masses is exact to 0.01 g.
READING_G = 0.01


FITTED, HELD = "fitted", "held back"


AS_RUN, BETWEEN, BY_CUBE = "a run", "between runs", "by the cube of the speed"


def loads_at(
    conditions: pd.DataFrame, diameter_mm: float, fill_ratio: float, speed_rpm: float, tolerance: float
) -> tuple[dict[str, float], float, str]:
    """F s per second of each kind [N m/s] at a speed [rpm], its relative error, and where it comes from.

    conditions: of one mill and contact set, as from `mean_conditions`. Uses runs of the ball diameter with a fill ratio
    that differs by at most `tolerance` (a fraction), the nearest first. Between two speeds the powers follow a power
    law; beyond the simulated speeds, the cube of the speed (thesis Eq. 3.28). NaN without such a run.
    """
    near = conditions[np.isclose(conditions["ball_diameter_mm"], diameter_mm)]
    near = near[(near["fill_ratio"] / fill_ratio - 1).abs() <= tolerance]
    if near.empty:
        return dict.fromkeys(LOADS, np.nan), np.nan, f"no run with {diameter_mm:g} mm at fill {fill_ratio:.3g}"
    fill = near["fill_ratio"].iloc[(near["fill_ratio"] / fill_ratio - 1).abs().argmin()]
    runs = near[near["fill_ratio"] == fill].sort_values("speed_rpm")
    speeds = runs["speed_rpm"].to_numpy(float)
    values = {kind: runs[column].to_numpy(float) for kind, column in LOADS.items()}
    errors = runs["relative_error"].to_numpy(float)
    place = int(np.searchsorted(speeds, speed_rpm * (1 - 1e-9)))
    if place < len(speeds) and np.isclose(speeds[place], speed_rpm):
        return {kind: float(own[place]) for kind, own in values.items()}, float(errors[place]), AS_RUN
    if 0 < place < len(speeds):
        ends = slice(place - 1, place + 1)
        weigh = np.log(speeds[ends])
        loads = {
            kind: float(np.exp(np.interp(np.log(speed_rpm), weigh, np.log(own[ends])))) for kind, own in values.items()
        }
        return loads, float(np.nanmax(errors[ends], initial=0.0)), BETWEEN
    near_by = min(place, len(speeds) - 1)
    cube = (speed_rpm / speeds[near_by]) ** 3
    return {kind: float(cube * own[near_by]) for kind, own in values.items()}, float(errors[near_by]), BY_CUBE


def fit_wear(
    weighings: pd.DataFrame, conditions: pd.DataFrame, material: pd.Series, tolerance: float = FILL_TOLERANCE
) -> tuple[pd.DataFrame, dict]:
    """The coefficient from every other weighing, and the others predicted by it; fixed before any result was seen.

    weighings: of `thesis.doe.wet_lab.wear_table`; conditions: of one mill and contact set. The fill ratio of a weighing
    is the volume of its unused balls over that of the jar. The coefficient is the geometric mean over the fitted rows,
    since errors are factors. Returns the table (a row for each weighing: role, loads, measured and predicted wear,
    coefficient from this row) and the result: coefficient, its range over all weighings, miss_log (root mean square of
    ln(measured / predicted) of the held rows), fill_ratio of the fitted rows, and counts. Raises
    ConfigError for a wear of 0, whose coefficient has no logarithm.
    """
    if not (weighings["wear_g"] > 0).all():
        raise ConfigError(f"wear_g = {weighings['wear_g'].min():g}: must be above 0 in every row to fit a coefficient")
    hardness, density = VICKERS * material["hardness_hv"], material["density_kg_m3"]
    jar = float(conditions["volume_m3"].iloc[0])
    rows = []
    for number, row in enumerate(weighings.to_dict("records")):
        fill = row["unused_mass_g"] * GRAM / density / jar
        loads, error, origin = loads_at(conditions, row["ball_diameter_mm"], fill, row["speed_rpm"], tolerance)
        own = worn_load(loads) * row["time_h"] * HOUR
        rows.append(
            {
                "role": HELD if number % 2 else FITTED,
                **{name: row[name] for name in ("ball_diameter_mm", "speed_rpm", "time_h", "bpr")},
                "fill_ratio": fill,
                **{LOADS[kind]: value for kind, value in loads.items()},
                "loads_from": origin,
                "relative_error": error,
                "measured_g": row["wear_g"],
                "reading_error_g": READING_G,
                "coefficient": row["wear_g"] * GRAM / archard_mass(own, 1.0, hardness, density),
            }
        )
    table = pd.DataFrame(rows)
    fitted, held = (table[table["role"] == role].dropna(subset="coefficient") for role in (FITTED, HELD))
    coefficient = float(np.exp(np.log(fitted["coefficient"]).mean())) if len(fitted) else np.nan
    table["predicted_g"] = table["measured_g"] * coefficient / table["coefficient"]
    table["measured_over_predicted"] = table["measured_g"] / table["predicted_g"]
    misses = np.log(held["coefficient"] / coefficient)
    known = pd.concat([fitted, held])["coefficient"]
    result = {
        "coefficient": coefficient,
        "coefficient_lowest": known.min(),
        "coefficient_highest": known.max(),
        "miss_log": float(np.sqrt((misses**2).mean())) if len(misses) else np.nan,
        "weighings_fitted": len(fitted),
        "weighings_held_back": len(held),
        "fill_ratio": float(fitted["fill_ratio"].mean()) if len(fitted) else np.nan,
        "mill": str(conditions["mill"].iloc[0]),
        "contact": str(conditions["contact"].iloc[0]),
        "material": str(material.name),
        "hardness_hv": float(material["hardness_hv"]),
    }
    return table, {name: None if pd.isna(value) else value for name, value in result.items()}


def said_of_wear(result: Mapping) -> str:
    """What the weighings show, in one or two sentences."""
    if result["coefficient"] is None:
        return "no run at the conditions of the fitted weighings: no coefficient"
    if result["miss_log"] is None:
        return "nothing was held back: the law is fitted, not tested"
    factor = np.exp(result["miss_log"])
    missed = f"the weighings held back are missed by a factor of {factor:.2g}"
    if result["weighings_held_back"] < FEWEST_HELD:
        return f"{missed}; held back: {result['weighings_held_back']}, too few to tell how far the law holds"
    return missed
