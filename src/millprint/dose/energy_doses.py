"""Dose: the energy that a gram of powder has received, by compression, shear and rolling, and how often it was hit.

All of the dissipated energy counts, as if every collision caught powder, since no model gives the share that does.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.estimate.estimates import Estimate
from millprint.fingerprint.plausible import check_near
from millprint.observables.definitions import POWER
from millprint.run.tables import CASE, Number, Text, read_measured, refuse_copies, refuse_rows

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint

# The doses, and the time that they are compared with: title and unit.
NORMAL, TANGENTIAL, ROLLING, TOTAL = "normal_kJ_g", "tangential_kJ_g", "rolling_kJ_g", "total_kJ_g"
HITS, TIME, YIELD = "hits_per_g", "time_h", "yield_percent"
AXES = {TIME: "time [h]", TOTAL: "dose [kJ/g]", NORMAL: "normal dose [kJ/g]", TANGENTIAL: "tangential dose [kJ/g]",
        HITS: "hits per gram [1/g]"}  # fmt: skip
SECONDS_PER_HOUR = 3600.0
POSITIVE = ("powder_mass_g", TIME, "fill_ratio", "speed_rpm", "ball_diameter_mm")


def doses(
    normal_J: pd.Series, tangential_J: pd.Series, frequency_hz: pd.Series, time_h: pd.Series, powder_g: pd.Series
) -> pd.DataFrame:
    """The doses of the thesis [kJ/g], without rolling, and hits per gram [1/g] of powder after the milling time.

    E_n f t / m, E_t f t / m, their sum, and f t / m: energies of a collision E [J], collisions f [1/s] of the balls
    that share the powder m [g], time t. All balls with all powder give the same as one ball with its share of both.
    """
    hits = frequency_hz * time_h * SECONDS_PER_HOUR / powder_g
    normal, tangential = normal_J * hits * 1e-3, tangential_J * hits * 1e-3
    return pd.DataFrame({NORMAL: normal, TANGENTIAL: tangential, TOTAL: normal + tangential, HITS: hits})


# Dose -> the power that gives it.
DOSE_OF = {NORMAL: "normal_power_W", TANGENTIAL: "tangential_power_W", ROLLING: "rolling_power_W", TOTAL: POWER}


def doses_of(found: Any, balls: int, time_h: float, powder_g: float) -> dict[str, Estimate]:
    """The doses of a prediction or a card, P t / m of the power and of each of its parts [kJ/g], and hits [1/g]."""
    time_s = time_h * SECONDS_PER_HOUR
    known = {name: getattr(found, power) * (1e-3 * time_s / powder_g) for name, power in DOSE_OF.items()}
    known = {name: replace(own, unit="kJ/g") for name, own in known.items()}
    return known | {HITS: replace(found.specific_frequency_hz * (balls * time_s / powder_g), unit="1/g")}


def share_of_one(run: pd.Series) -> str:
    """What is wrong with a fill ratio of 1 or more."""
    fill = run["fill_ratio"]
    return "must be under 1" + (f"; write {fill / 100:g} for {fill:g} %" if 1 < fill < 100 else "")


def own_doses(path: str | Path, fingerprints: Mapping[str, "Fingerprint"]) -> pd.DataFrame:
    """Doses of a user's runs: columns case, mill, powder_mass_g, time_h, fill_ratio, speed_rpm, ball_diameter_mm.

    Adds the doses, wall_power_W, and `outside`, what is outside the simulated ranges; yield_percent is kept. Raises
    ConfigError, in one line, for a bad cell, such as a mass of 0, and for a mill without a fingerprint.
    """
    numbers = [Number(name, 0, above=True) for name in POSITIVE]
    table = read_measured(path, [Text(CASE, unique=True), Text("mill"), *numbers, Number(YIELD, 0, 100, optional=True)])
    if YIELD in table:
        refuse_copies(table, path, ["mill", *POSITIVE], YIELD)
    known = ", ".join(sorted(fingerprints))
    refuse_rows(table, path, "mill", ~table["mill"].isin(fingerprints), f"unknown mill; fingerprints given: {known}")
    refuse_rows(table, path, "fill_ratio", table["fill_ratio"] >= 1, share_of_one)
    rows = []
    for run in table.itertuples():
        fingerprint = fingerprints[run.mill]
        try:
            check_near(fingerprint.about, speed_rpm=run.speed_rpm, ball_diameter_mm=run.ball_diameter_mm)
        except ConfigError as error:
            raise ConfigError(f"{path}: case {run.case}: {error}") from None
        condition = fingerprint.condition(
            speed_hz=run.speed_rpm / 60, ball_diameter_m=run.ball_diameter_mm * 1e-3, fill_ratio=run.fill_ratio
        )
        found = fingerprint.predict(condition)
        told = doses_of(found, found.balls, getattr(run, TIME), run.powder_mass_g)
        own = {name: each.value for name, each in told.items()}
        rows.append(own | {POWER: found.wall_power_W.value, "outside": ", ".join(found.outside)})
    return pd.concat([table, pd.DataFrame(rows, index=table.index)], axis=1)
