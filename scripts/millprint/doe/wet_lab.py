"""What a chemist weighs in and reads off for each run: half-lives, powder masses, gas volumes."""

import pandas as pd

from millprint.config.wet_lab import ChemistryConfig, GasConfig, HalfLifeConfig, PowderConfig
from millprint.doe.gas import gas_volume, gas_yield
from millprint.doe.half_life import half_life, share_lost
from millprint.doe.powder import powder_mass
from millprint.doe.readings import GRAM, HOUR, MILLILITRE, weighed_in
from millprint.doe.runs import YIELD


def half_life_table(own: HalfLifeConfig) -> pd.DataFrame:
    """Half-life of the solution (thesis Eq. 2.7) as configured, around it in pH, and at an exact 25 degC."""
    conditions = [
        (own.ph, own.temperature_k, "as configured"),
        (own.ph, 298.15, "25 degC, not rounded"),
        *((own.ph + step, own.temperature_k, f"pH {step:+g}") for step in (-1, 1) if 7 <= own.ph + step <= 14),
        (own.ph, 353.15, "80 degC, at which the gas is collected; without catalyst"),
    ]
    rows = []
    for ph, temperature, note in conditions:
        half = half_life(ph, temperature)
        rows.append((ph, temperature, half / HOUR, 100 * share_lost(HOUR, half), note))
    return pd.DataFrame(rows, columns=["ph", "temperature_k", "half_life_h", "lost_in_an_hour_percent", "note"])


def powder_table(runs: pd.DataFrame, jar: PowderConfig, chemistry: ChemistryConfig, gas: GasConfig) -> pd.DataFrame:
    """Masses weighed in for each run, and the gas volume that its yield stands for at the configured conditions.

    The runs have the columns bpr and molar_ratio. yield_if_vapour_ignored_percent takes the moist gas for pure
    hydrogen. yield_per_ml_percent is the yield that 1 mL of gas is worth: the resolution of the method, finest where
    the ball-to-powder ratio is low and the powder much.
    """
    conditions = (gas.temperature_k, gas.pressure_pa)
    powder = powder_mass(jar.ball_mass_g * GRAM, runs["bpr"])
    charge = weighed_in(powder, runs["molar_ratio"], chemistry)
    limiting = charge["limiting_mass_g"] * GRAM
    full = gas_volume(1.0, *conditions, limiting, chemistry, gas.saturated)
    volume = runs[YIELD] / 100 * full
    return pd.DataFrame(
        {
            "case": runs["case"],
            "bpr": runs["bpr"],
            "molar_ratio": runs["molar_ratio"],
            **charge,
            "gas_volume_full_ml": full / MILLILITRE,
            "gas_volume_ml": volume / MILLILITRE,
            YIELD: runs[YIELD],
            "yield_if_vapour_ignored_percent": 100
            * gas_yield(volume, *conditions, limiting, chemistry, saturated=False),
            "yield_per_ml_percent": 100 * gas_yield(MILLILITRE, *conditions, limiting, chemistry, gas.saturated),
        }
    )
