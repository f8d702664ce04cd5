"""What a chemist weighs in and reads off for each run: half-lives, powder masses, gas volumes."""

import pandas as pd

from millprint.config.doe import DoeConfig
from millprint.doe.gas import gas_volume, gas_yield, vapour_pressure
from millprint.doe.half_life import half_life
from millprint.doe.powder import excess, powder_mass, reactant_masses
from millprint.doe.runs import YIELD

GRAM = 1e-3
MILLILITRE = 1e-6
HOUR = 3600.0


def half_life_table(config: DoeConfig) -> pd.DataFrame:
    """Half-life of the solution (thesis Eq. 2.7) as configured, around it in pH, and at an exact 25 degC."""
    own = config.half_life
    conditions = [
        (own.ph, own.temperature_k, "as configured"),
        (own.ph, 298.15, "25 degC, not rounded"),
        *((own.ph + step, own.temperature_k, f"pH {step:+g}") for step in (-1, 1) if 7 <= own.ph + step <= 14),
        (own.ph, 353.15, "80 degC, at which the gas is collected; without catalyst"),
    ]
    rows = [(ph, temperature, half_life(ph, temperature) / HOUR, note) for ph, temperature, note in conditions]
    return pd.DataFrame(rows, columns=["ph", "temperature_k", "half_life_h", "note"])


def powder_table(config: DoeConfig, runs: pd.DataFrame) -> pd.DataFrame:
    """Masses weighed in for each run, and the gas volume that its yield stands for at the configured conditions.

    The runs have the columns bpr and molar_ratio. yield_if_vapour_ignored_percent takes the moist gas for pure
    hydrogen. yield_per_ml_percent is the yield that 1 mL of gas is worth: the resolution of the method, finest where
    the ball-to-powder ratio is low and the powder much.
    """
    temperature, pressure = config.gas.temperature_k, config.gas.pressure_pa
    powder = powder_mass(config.powder.ball_mass_g * GRAM, runs["bpr"])
    borate, hydride = reactant_masses(powder, runs["molar_ratio"])
    full = gas_volume(1.0, temperature, pressure, borate)
    conversion = runs[YIELD] / 100
    moist = pressure / (pressure - vapour_pressure(temperature))
    return pd.DataFrame(
        {
            "case": runs["case"],
            "bpr": runs["bpr"],
            "molar_ratio": runs["molar_ratio"],
            "excess_percent": 100 * excess(runs["molar_ratio"]),
            "powder_mass_g": powder / GRAM,
            "borate_mass_g": borate / GRAM,
            "hydride_mass_g": hydride / GRAM,
            "gas_volume_full_ml": full / MILLILITRE,
            "gas_volume_ml": conversion * full / MILLILITRE,
            YIELD: runs[YIELD],
            "yield_if_vapour_ignored_percent": moist * runs[YIELD],
            "yield_per_ml_percent": 100 * gas_yield(MILLILITRE, temperature, pressure, borate),
        }
    )
