"""What the jar holds: powder, the hydrogen that it can give off, and the pressure that this means."""

import numpy as np
import pandas as pd
from scipy.constants import bar, gas_constant

from millprint.config.doe import ChemistryConfig
from millprint.config.next_experiments import RegionConfig
from millprint.thesis.doe.chemistry import hydrogen_released, molar_mass, reactant_masses

POWDER, HYDROGEN, PRESSURE = "powder_mass_g", "hydrogen_mmol", "hydrogen_pressure_bar"
PLACE = "yields.proposals.region"


def with_hydrogen(rows: pd.DataFrame, region: RegionConfig, reaction: ChemistryConfig, volume: float) -> pd.DataFrame:
    """The rows with hydrogen_mmol, what the reaction gives off at full conversion, and hydrogen_pressure_bar.

    rows: molar_ratio, balls, ball_diameter_mm and powder_mass_g; volume: of the jar [m3]. The amount is
    `hydrogen_released` times the limiting reactant in the powder. Its pressure is that of an ideal gas in what balls
    and powder leave of the jar, n R T / (V - V_balls - m / rho), added to the pressure of the gas at closing; NaN where
    they leave nothing. rho and T are keys of the region. Excess hydride, which gives off its hydrogen from about 300
    degC only, is not counted.
    """
    powder = rows[POWDER].to_numpy(float) * 1e-3
    limiting, _ = reactant_masses(powder, rows["molar_ratio"].to_numpy(float), reaction)
    moles = hydrogen_released(reaction) * limiting * reaction.limiting_purity / molar_mass(reaction.limiting)
    balls = rows["balls"] * np.pi / 6 * (rows["ball_diameter_mm"] * 1e-3) ** 3
    free = volume - balls.to_numpy(float) - powder / region.powder_density_kg_m3
    pressure = np.full(len(rows), np.nan)
    np.divide(moles * gas_constant * region.gas_temperature_k, free * bar, out=pressure, where=free > 0)
    return rows.assign(**{HYDROGEN: 1e3 * np.asarray(moles), PRESSURE: pressure})


def safety_warnings(rows: pd.DataFrame, region: RegionConfig) -> list[str]:
    """For each row the limits of the region that it breaks, empty if none; rows as `with_hydrogen` returns them."""
    limits = {
        POWDER: ("powder_max_g", region.powder_max_g),
        HYDROGEN: ("hydrogen_max_mmol", region.hydrogen_max_mmol),
        PRESSURE: ("pressure_max_bar", region.pressure_max_bar),
    }
    texts = []
    for row in rows[list(limits)].to_dict("records"):
        broken = [
            f"{name} = {row[name]:.3g} is above {limit:g} ({PLACE}.{key})"
            for name, (key, limit) in limits.items()
            if limit is not None and row[name] > limit
        ]
        if np.isnan(row[PRESSURE]):
            broken.append(f"{PRESSURE} = nothing: balls and powder fill the jar")
        texts.append("; ".join(broken))
    return texts
