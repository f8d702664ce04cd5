"""Wear of the balls and the iron that it leaves in the powder (thesis Table 2.6)."""

import pandas as pd

from millprint.doe.bounds import check_bounds
from millprint.doe.powder import powder_mass
from millprint.errors import ConfigError
from millprint.files import read_table

COLUMNS = ["ball_diameter_mm", "speed_rpm", "time_h", "bpr", "unused_mass_g", "used_mass_g"]

# The masses of the balls are read to 0.01 g, so that their difference is known to twice half of that.
READING_G = 0.01


def read_wear(path: str) -> pd.DataFrame:
    """Read the weighings of the balls; a column wear_g, weighed by itself, goes before the difference of the masses.

    Raises ConfigError for a mass that is not positive, balls that gained mass, or a wear beyond what the two masses
    leave open.
    """
    frame = read_table(path, numeric=COLUMNS)
    if "wear_g" in frame:
        frame = read_table(path, numeric=[*COLUMNS, "wear_g"])
    for column in COLUMNS:
        check_bounds(frame, path, column, 0, above=True)
    lost = frame["unused_mass_g"] - frame["used_mass_g"]
    if (lost < 0).any():
        row = (lost < 0).idxmax()
        raise ConfigError(
            f"{path}: column used_mass_g, row {row + 1} = {frame['used_mass_g'][row]:g}: at most the unused mass, "
            f"{frame['unused_mass_g'][row]:g} g, is wanted"
        )
    if "wear_g" in frame:
        far = (frame["wear_g"] - lost).abs() > READING_G * (1 + 1e-9)
        if far.any():
            row = far.idxmax()
            raise ConfigError(
                f"{path}: column wear_g, row {row + 1} = {frame['wear_g'][row]:g}: within {READING_G:g} g of the "
                f"difference of the two masses, {lost[row]:.3g} g, is wanted"
            )
    return frame


def wear_table(weighings: pd.DataFrame) -> pd.DataFrame:
    """Weight loss and iron in the powder, by the wear and by the difference of the two masses.

    The iron is referred to the powder charged, m_balls / BPR, as in the thesis; with the iron itself in the
    denominator (column iron_of_mixture_percent) the share is smaller.
    """
    unused = weighings["unused_mass_g"]
    difference = unused - weighings["used_mass_g"]
    wear = weighings.get("wear_g", difference)
    powder = powder_mass(unused, weighings["bpr"])
    return weighings[["ball_diameter_mm", "speed_rpm", "time_h", "bpr", "unused_mass_g", "used_mass_g"]].assign(
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
