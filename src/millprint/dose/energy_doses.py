"""Dose: the energy that a gram of powder has received, normal and tangential, and how often it was hit.

All of the dissipated energy counts, as if every collision caught powder, since no model gives the share that does.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millprint.run.tables import CASE, Number, Text, read_measured, refuse_rows

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint

# The doses, and the time that they are compared with: title and unit.
NORMAL, TANGENTIAL, TOTAL = "normal_kJ_g", "tangential_kJ_g", "total_kJ_g"
HITS, TIME, YIELD = "hits_per_g", "time_h", "yield_percent"
AXES = {TIME: "time [h]", TOTAL: "dose [kJ/g]", NORMAL: "normal dose [kJ/g]", TANGENTIAL: "tangential dose [kJ/g]",
        HITS: "hits per gram [1/g]"}  # fmt: skip
SECONDS_PER_HOUR = 3600.0
POSITIVE = ("powder_mass_g", TIME, "fill_ratio", "speed_rpm", "ball_diameter_mm")


def doses(
    normal_J: pd.Series, tangential_J: pd.Series, frequency_hz: pd.Series, time_h: pd.Series, powder_g: pd.Series
) -> pd.DataFrame:
    """Doses [kJ/g] and hits per gram [1/g] of powder after the milling time.

    E_n f t / m, E_t f t / m, their sum, and f t / m: energies of a collision E [J], collisions f [1/s] of the balls
    that share the powder m [g], time t. All balls with all powder give the same as one ball with its share of both.
    """
    hits = frequency_hz * time_h * SECONDS_PER_HOUR / powder_g
    normal, tangential = normal_J * hits * 1e-3, tangential_J * hits * 1e-3
    return pd.DataFrame({NORMAL: normal, TANGENTIAL: tangential, TOTAL: normal + tangential, HITS: hits})


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


def own_doses(path: str | Path, fingerprints: Mapping[str, "Fingerprint"]) -> pd.DataFrame:
    """Doses of a user's runs: columns case, mill, powder_mass_g, time_h, fill_ratio, speed_rpm, ball_diameter_mm.

    Adds the doses, power_W, and `outside`, what is outside the simulated ranges; yield_percent is kept. Raises
    ConfigError, in one line, for a bad cell, such as a mass of 0, and for a mill without a fingerprint.
    """
    numbers = [Number(name, 0, above=True) for name in POSITIVE]
    table = read_measured(path, [Text(CASE, unique=True), Text("mill"), *numbers, Number(YIELD, 0, 100, optional=True)])
    known = ", ".join(sorted(fingerprints))
    refuse_rows(table, path, "mill", ~table["mill"].isin(fingerprints), f"unknown mill; fingerprints given: {known}")
    refuse_rows(table, path, "fill_ratio", table["fill_ratio"] >= 1, "must be under 1")
    rows = []
    for run in table.itertuples():
        fingerprint = fingerprints[run.mill]
        condition = fingerprint.condition(
            speed_hz=run.speed_rpm / 60, ball_diameter_m=run.ball_diameter_mm * 1e-3, fill_ratio=run.fill_ratio
        )
        found = fingerprint.predict(condition)
        rows.append(
            {
                "normal_J": found.normal_energy_J.value,
                "tangential_J": found.tangential_energy_J.value,
                "frequency_hz": found.balls * found.specific_frequency_hz.value,
                "power_W": found.power_W.value,
                "outside": ", ".join(found.outside),
            }
        )
    own = pd.DataFrame(rows, index=table.index)
    found = doses(own["normal_J"], own["tangential_J"], own["frequency_hz"], table[TIME], table["powder_mass_g"])
    return pd.concat([table, found, own[["power_W", "outside"]]], axis=1)
