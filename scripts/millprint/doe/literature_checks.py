"""Whether the numbers that a study reports agree with each other: masses, molar ratio, balls, ball-to-powder ratio."""

from math import isnan, pi

import pandas as pd

from millprint.doe.runs import YIELD
from millprint.doe.species import molar_mass

# Bearing and stainless steels lie within 2 % of it [g/cm3].
STEEL_DENSITY = 7.8
# Two digits of a mass and two of a ratio: what agrees is this close.
TOLERANCE = 0.1
COLUMNS = ["reference", "check", "reported", "follows", "agrees", "note"]


def _row(study: pd.Series, check: str, reported: float, follows: float, note: str = "") -> tuple:
    agrees = abs(follows / reported - 1) <= TOLERANCE
    return study["reference"], check, reported, follows, "yes" if agrees else "no", "" if agrees else note


def _ball_volume(study: pd.Series) -> float:
    """Volume of the balls, from their diameters and numbers or from their share of the jar [cm3]; NaN if unreported."""
    if isinstance(study["ball_diameter_mm"], str) and isinstance(study["balls"], str):
        diameters = [float(part) / 10 for part in study["ball_diameter_mm"].split("/")]
        numbers = [int(part) for part in study["balls"].split("/")]
        return sum(number * pi / 6 * diameter**3 for number, diameter in zip(numbers, diameters, strict=True))
    return study["jar_volume_ml"] * study["ball_volume_percent"] / 100


def _molar_ratio(study: pd.Series, borate: str) -> float:
    amounts = study["reductant_mass_g"] / molar_mass(study["reductant"]), study["borate_mass_g"] / molar_mass(borate)
    return amounts[0] / amounts[1]


def _masses(study: pd.Series, borates: list[str]) -> list[tuple]:
    if isnan(study["borate_mass_g"]) or isnan(study["reductant_mass_g"]):
        return []
    total = study["borate_mass_g"] + study["reductant_mass_g"]
    rows = []
    if not isnan(study["powder_mass_g"]):
        rows.append(_row(study, "total mass [g]", study["powder_mass_g"], total, "the two masses make another sum"))
    if not isnan(study["molar_ratio"]):
        reported = study["molar_ratio"]
        others = [name for name in borates if abs(_molar_ratio(study, name) / reported - 1) <= TOLERANCE]
        note = f"follows from the masses if the borate is {others[0]}" if others else "follows for no hydrate"
        rows.append(_row(study, "molar ratio [-]", reported, _molar_ratio(study, study["borate"]), note))
    return rows


def _balls(study: pd.Series) -> list[tuple]:
    volume = _ball_volume(study)
    if isnan(volume):
        return []
    rows = []
    counted = isinstance(study["balls"], str)
    if counted and not isnan(study["ball_volume_percent"]):
        share = 100 * volume / study["jar_volume_ml"]
        rows.append(_row(study, "ball volume in jar [%]", study["ball_volume_percent"], share, "another fill"))
    if not isnan(study["powder_mass_g"]) and not isnan(study["bpr"]):
        needed = study["bpr"] * study["powder_mass_g"] / volume
        note = f"balls of {needed:.1f} g/cm3 would be needed; steel has {STEEL_DENSITY:g}, tungsten carbide 15.6"
        ratio = STEEL_DENSITY * volume / study["powder_mass_g"]
        rows.append(_row(study, "ball-to-powder ratio with steel balls [-]", study["bpr"], ratio, note))
    return rows


def literature_checks(studies: pd.DataFrame, yields: pd.DataFrame) -> pd.DataFrame:
    """Every number of a study that follows from its others, and the yields of the two tables against each other.

    Within 10 % they agree. `studies` is Table 2.2, `yields` Table 2.1.
    """
    borates = list(dict.fromkeys([*studies["borate"], *yields["borate"]]))
    rows = []
    for _, study in studies.iterrows():
        rows += _masses(study, borates) + _balls(study)
        own = yields[yields["reference"] == study["reference"]]
        same = own[(own["borate"] == study["borate"]) & (own["reductant"] == study["reductant"])]
        for other in same[YIELD]:
            match = own.loc[own[YIELD] == study[YIELD], "borate"]
            note = f"Table 2.1 gives this yield for {match.iloc[0]}" if len(match) else "the two tables differ"
            agrees = "yes" if other == study[YIELD] else "no"
            row = (study["reference"], "yield in Tables 2.2 and 2.1 [%]", study[YIELD], other, agrees)
            rows.append((*row, "" if agrees == "yes" else note))
    return pd.DataFrame(rows, columns=COLUMNS)
