"""The conditions that can be set on a mill, and their descriptors from the master curves."""

from dataclasses import dataclass
from itertools import product

import numpy as np
import pandas as pd

from millprint.config.errors import ConfigError
from millprint.config.next_experiments import RegionConfig
from millprint.config.sweep import ball_count
from millprint.fingerprint.condition import BASIC, Condition, descriptors_of, scaled_quantities

SETTINGS = ("bpr", "molar_ratio", "time_h", "speed_rpm", "fill_ratio", "ball_diameter_mm")
GRAM = 1e-3


@dataclass(frozen=True)
class Mill:
    """What the descriptors need of a mill: ball density [kg/m3], amplitude [m] and volume of the jar [m3]."""

    density: float
    amplitude: float
    volume: float


def curve_point(curves: pd.DataFrame, fill_ratio: float) -> dict[str, float]:
    """The master curves of BASIC at a fill ratio, interpolated between logarithms; NaN outside the curves.

    curves: fill_ratio, Pn, Pt, f; rows of equal fill ratio count once.
    """
    table = curves.drop_duplicates("fill_ratio").sort_values("fill_ratio")
    fills = np.log(table["fill_ratio"].to_numpy(float))
    place = np.log(fill_ratio)
    inside = fills[0] - 1e-9 <= place <= fills[-1] + 1e-9
    found = {name: float(np.exp(np.interp(place, fills, np.log(table[name].to_numpy(float))))) for name in BASIC}
    return found if inside else dict.fromkeys(BASIC, float("nan"))


def check_region(region: RegionConfig, curves: pd.DataFrame, source: str) -> None:
    """Raise ConfigError, in one line, for a fill ratio outside the master curves."""
    low, high = curves["fill_ratio"].min(), curves["fill_ratio"].max()
    for fill in region.fill_ratio:
        if np.isnan(curve_point(curves, fill)["Pn"]):
            raise ConfigError(
                f"{source}: yields.proposals.region.fill_ratio = {fill:g}: the master curves cover {low:g} to {high:g}"
            )


def described_settings(settings: pd.DataFrame, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """Settings with balls, powder and the descriptors of Eqs 3.22, 3.28 and 3.29.

    settings: a row for each condition with the columns SETTINGS, and any others. Columns added: balls, powder_mass_g,
    normal_energy_uJ, tangential_energy_uJ, specific_frequency_hz; NaN for a fill ratio outside the curves.
    """
    scaled = {fill: scaled_quantities(curve_point(curves, fill)) for fill in settings["fill_ratio"].unique()}
    found = []
    for row in settings.itertuples():
        diameter = row.ball_diameter_mm * 1e-3
        condition = Condition(row.fill_ratio, row.speed_rpm / 60, diameter, mill.density, mill.amplitude)
        at = descriptors_of(condition, scaled[row.fill_ratio])
        balls = ball_count(row.fill_ratio, mill.volume, diameter)
        found.append(
            {
                "balls": balls,
                "powder_mass_g": balls * mill.density * np.pi / 6 * diameter**3 / row.bpr / GRAM,
                "normal_energy_uJ": 1e6 * at["normal_energy_J"],
                "tangential_energy_uJ": 1e6 * at["tangential_energy_J"],
                "specific_frequency_hz": at["specific_frequency_hz"],
            }
        )
    return pd.concat([settings, pd.DataFrame(found, index=settings.index)], axis=1)


def region_conditions(region: RegionConfig, curves: pd.DataFrame, mill: Mill) -> pd.DataFrame:
    """Every combination of the settings, with case and the columns of `described_settings`."""
    table = pd.DataFrame(list(product(*(getattr(region, name) for name in SETTINGS))), columns=list(SETTINGS))
    cases = [f"r{number}" for number in range(1, len(table) + 1)]
    return described_settings(table, curves, mill).assign(case=cases)
