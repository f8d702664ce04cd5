"""Use of the milling energy: yield against fill ratio, specific yield, leverage and cost (thesis Sec. 4.3)."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.run.tables import CASE, Number, Text, read_measured

if TYPE_CHECKING:
    pass


from millprint.dose.energy_doses import TIME, YIELD, doses
from millprint.dose.kinetics import MODELS

WAYS_OF_RUNNING = {"speed": "constant speed", "power": "constant power"}
SLOPE_COLUMNS = [
    *("series", "title", "points", "intercept", "slope_per_pp", "slope_lower", "slope_upper"),
    *("p_value", "r2"),
]

SECONDS_PER_HOUR = 3600.0
JOULES_PER_KWH = 3.6e6
# Of a curve that is drawn.
POINTS = 80


@dataclass(frozen=True)
class Chemistry:
    """The reaction of Eq. 4.2, one mole of borohydride for one of borate: molar masses [kg/mol], energies [J/mol]."""

    borate_molar_mass: float
    borohydride_molar_mass: float
    enthalpy: float
    gibbs: float
    lower_heating_value: float


def specific_yields(runs: pd.DataFrame) -> pd.DataFrame:
    """Yield and converted mass over power, with their gains over the reference (Table 4.4).

    runs: case, mode, fill_ratio, balls, power_W, yield_percent, borate_mass_g. The mass is that of the borate
    converted. Gains are in per cent of the unrounded reference; the printed +64 % of the mass is the ratio of two
    rounded entries (0.185 over 0.113), where the unrounded ones give 63.3 %.
    """
    table = runs[["case", "mode", "fill_ratio", "balls", "power_W"]].copy()
    table["yield_fraction"] = runs["yield_percent"] / 100.0
    table["specific_yield_per_W"] = table["yield_fraction"] / table["power_W"]
    table["borate_mass_g"] = runs["borate_mass_g"]
    table["mass_per_watt_g_W"] = table["borate_mass_g"] * table["yield_fraction"] / table["power_W"]
    reference = table[table["mode"] == "reference"].iloc[0]
    table["gain_percent"] = 100.0 * (table["specific_yield_per_W"] / reference["specific_yield_per_W"] - 1.0)
    table["mass_gain_percent"] = 100.0 * (table["mass_per_watt_g_W"] / reference["mass_per_watt_g_W"] - 1.0)
    return table


def energy_leverage(runs: pd.DataFrame, chemistry: Chemistry, efficiency: float, price: float) -> pd.DataFrame:
    """Share of the milling energy found again as chemical energy (Eq. 4.7, Table 4.5), plug energy and cost.

    runs: as for `specific_yields`, with time_h. Mechanical energy P t [J]; leverage on enthalpy, Gibbs energy and
    lower heating value [%]; energy from the plug E / (eta m) [kWh/kg] (Eq. 4.8) and its cost [EUR/kg] (Eq. 4.9) for
    `efficiency` eta [-] and `price` [EUR/kWh], m the mass of borohydride.

    The printed digits are ours, rounded or truncated: the column dG comes out by rounding if it is 1.23 times the
    unrounded column dH, as the text of Sec. 4.3.2 says, and the column LHV by truncation of 2908 / 1226 times it.
    """
    table = runs[["case", "mode", "fill_ratio", "power_W"]].copy()
    moles = runs["borate_mass_g"] * 1e-3 / chemistry.borate_molar_mass * runs["yield_percent"] / 100.0
    table["mechanical_energy_J"] = runs["power_W"] * runs["time_h"] * SECONDS_PER_HOUR
    table["borohydride_mol"] = moles
    table["borohydride_mass_g"] = moles * chemistry.borohydride_molar_mass * 1e3
    energies = {"dH": chemistry.enthalpy, "dG": chemistry.gibbs, "LHV": chemistry.lower_heating_value}
    for name, energy in energies.items():
        table[f"leverage_{name}_percent"] = 100.0 * moles * energy / table["mechanical_energy_J"]
    mass = table["borohydride_mass_g"] * 1e-3
    table["plug_energy_kWh_kg"] = table["mechanical_energy_J"] / JOULES_PER_KWH / (efficiency * mass)
    table["cost_EUR_kg"] = table["plug_energy_kWh_kg"] * price
    return table


def compare_with_prior(best: dict[str, float], prior: dict[str, float]) -> pd.DataFrame:
    """Comparison of the best case with earlier work (Table 4.3): both hold yield_percent, time_h, bpr and speed_hz.

    The change is relative, in per cent; only the change of the yield is in percentage points.
    """
    rows = []
    for metric, earlier in prior.items():
        change = best[metric] - earlier if metric == "yield_percent" else 100.0 * (best[metric] / earlier - 1.0)
        rows.append({"metric": metric, "prior": earlier, "this_work": best[metric], "change": change})
    return pd.DataFrame(rows)


def fit_slopes(runs: pd.DataFrame, probability: float) -> pd.DataFrame:
    """Ordinary least squares of the yield [-] on the fill ratio [percentage points], for each way of running.

    runs: mode, fill_ratio, yield_percent; the reference belongs to both lines. `slope_per_pp` is what one percentage
    point of fill ratio changes, with its confidence interval; three points leave one degree of freedom, so the
    interval is wide however high R2 is.
    """
    from statsmodels.regression.linear_model import OLS
    from statsmodels.tools import add_constant

    rows = []
    for mode, title in WAYS_OF_RUNNING.items():
        line = runs[runs["mode"].isin(["reference", mode])]
        if line["fill_ratio"].nunique() < 3:
            continue
        yields, fills = (line[name].to_numpy() for name in ("yield_percent", "fill_ratio"))
        fit = OLS(yields / 100.0, add_constant(fills * 100.0)).fit()
        values = (*fit.params, *fit.conf_int(alpha=1.0 - probability)[1], fit.pvalues[1], fit.rsquared)
        rows.append((mode, title, len(line), *values))
    return pd.DataFrame(rows, columns=SLOPE_COLUMNS)


def powder_of_ball(bpr: pd.Series, ball_diameter_m: float, density_kg_m3: float) -> pd.Series:
    """Powder [g] that one ball has at a ball-to-powder mass ratio [-]."""
    return 1e3 * density_kg_m3 * np.pi / 6 * ball_diameter_m**3 / bpr


def screening_doses(path: str | Path, ball_diameter_m: float, density_kg_m3: float) -> pd.DataFrame:
    """Case, bpr, molar_ratio, time_h, doses and yield_percent of the screening runs, from their printed descriptors."""
    energies = ("normal_energy_uJ", "tangential_energy_uJ", "specific_frequency_hz")
    numbers = [Number(name, 0, above=True) for name in ("bpr", "molar_ratio", TIME, *energies)]
    table = read_measured(path, [Text(CASE, unique=True), *numbers, Number(YIELD, 0, 100)])
    powder = powder_of_ball(table["bpr"], ball_diameter_m, density_kg_m3)
    normal, tangential, frequency = (table[name] for name in energies)
    found = doses(1e-6 * normal, 1e-6 * tangential, frequency, table[TIME], powder)
    return pd.concat([table[[CASE, "bpr", "molar_ratio", TIME]], found, table[[YIELD]]], axis=1)


def regime_doses(
    measured: pd.DataFrame, cases: pd.DataFrame, ball_diameter_m: float, density_kg_m3: float
) -> pd.DataFrame:
    """The columns of `screening_doses` for the five cases of chapter 4.

    measured: as of `fingerprint.regimes.read_regimes`; cases: those rows of Table 4.2, with energies and frequency.
    """
    joined = measured[[CASE, "bpr", "molar_ratio", TIME, YIELD]].merge(cases, on=CASE, suffixes=("", "_designed"))
    powder = powder_of_ball(joined["bpr"], ball_diameter_m, density_kg_m3)
    columns = ("normal_energy_J", "tangential_energy_J", "specific_frequency_hz")
    normal, tangential, frequency = (joined[name] for name in columns)
    found = doses(normal, tangential, frequency, joined[TIME], powder)
    return pd.concat([joined[[CASE, "bpr", "molar_ratio", TIME]], found, joined[[YIELD]]], axis=1)


def curve_of(row: pd.Series, largest: float) -> pd.DataFrame:
    """The yield [%] of a fitted law from 0 to the largest x: columns x and yield_percent."""
    x = np.linspace(0.0, largest, POINTS)
    values = {name: row[name] for name in MODELS[row["model"]].names}
    if "x0" in values:
        values["x0"] /= largest
    return pd.DataFrame({"x": x, YIELD: MODELS[row["model"]].law(x, **values)})
