"""Energy spectra and temperatures of the simulated conditions of a mill, from their tables, as plain values."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from millprint.config.dose import HeatConfig
from millprint.config.errors import ConfigError
from millprint.config.mixture import ONE_SIZE, balls_in_words
from millprint.dose.heat_balance import BODIES
from millprint.dose.heat_table import BAND
from millprint.dose.spectra import BIN_EDGES, BOTH, CHANNELS, PAIRS
from millprint.fingerprint.condition import VARIABLES
from millprint.fingerprint.descriptors import CHARGE, CONDITION, CONDITION_TEXT, NOTHING
from millprint.run.files import read_table

# Digits of a spectrum on the page, and decimals of a temperature [degC].
DIGITS, DECIMALS = 8, 2
SHOWN = ("collisions_hz", "power_W", "mean_J", "median_J", "half_power_J")
OF_LIMIT = ("total_W", "limit_degC", "over_limit_share", "milling_min")
BANDS_OF_LIMIT = ("time_to_limit_h", "pause_needed_min")


class Spectra(NamedTuple):
    """Tables of energy spectra: pairs of spectra...tsv and spectra_summary...tsv, and the rule to show."""

    tables: Sequence[tuple[str | Path, str | Path]]
    rule: str


class Heat(NamedTuple):
    """Tables of temperatures: temperatures.tsv and limits.tsv, and the settings that they were made with."""

    temperatures: str | Path
    limits: str | Path
    settings: HeatConfig


def _number(value: float, digits: int = DIGITS) -> float | None:
    """A number with a few digits; None if it is not finite."""
    return float(f"{value:.{digits}g}") if np.isfinite(value) else None


def condition_words(contact: str, ball_diameter_mm: float, fill_ratio: float, charge: str = ONE_SIZE) -> str:
    """A simulated condition in words, without the speed, because its unit is chosen on the page."""
    return f"{contact}, {balls_in_words(round(ball_diameter_mm, 3), charge)}, fill {fill_ratio:g}"


def _condition(row: dict) -> dict:
    """A row of a table of spectra: its condition in SI, and its name in addresses and in words."""
    varied = "" if row["varied"] == NOTHING else row["varied"]
    named = [row["contact"], row[CHARGE] or f"d{row['ball_diameter_mm']:g}", f"f{row['fill_ratio']:g}"]
    named += [f"n{row['speed_rpm']:g}"]
    words = condition_words(row["contact"], row["ball_diameter_mm"], row["fill_ratio"], row[CHARGE])
    if "density" in varied:
        named.append(f"rho{row['density_kg_m3']:g}")
        words += f", {row['density_kg_m3']:g} kg/m³"
    if "amplitude" in varied:
        named.append(f"a{1e3 * row['amplitude_m']:g}")
        words += f", amplitude {1e3 * row['amplitude_m']:g} mm"
    settings = {
        "fill_ratio": row["fill_ratio"],
        "speed_hz": row["speed_rpm"] / 60,
        "ball_diameter_m": row["ball_diameter_mm"] * 1e-3,
        "density_kg_m3": row["density_kg_m3"],
        "amplitude_m": row["amplitude_m"],
    }
    known = {name: float(settings[name]) for name in VARIABLES}
    return {"id": "-".join(named), "words": words, "contact": row["contact"], "charge": row[CHARGE], **known}


def spectra_content(spectra: Spectra) -> dict:
    """Bins and spectra of every condition whose contacts were recorded; the spectra of `rule`, from their first bin.

    The place of a bin is 0 below the lowest edge, and one more for each edge. Raises ConfigError for a table with other
    bins than BIN_EDGES.
    """
    found: list[dict] = []
    for path, summary_path in spectra.tables:
        text = [*CONDITION_TEXT, "counting_rule", "channel", "pair"]
        table, summary = (
            read.fillna({CHARGE: ONE_SIZE})[read["counting_rule"] == spectra.rule]
            for read in (read_table(path, text=text), read_table(summary_path, text=text))
        )
        grouped = dict(list(table.groupby([*CONDITION, "channel", "pair"], sort=False)))
        for key, rows in summary[summary["channel"].isin(CHANNELS)].groupby(CONDITION, sort=False):
            own = _condition(dict(zip(CONDITION, key, strict=True)))
            own["bins"] = {
                channel: {pair: _bins(grouped.get((*key, channel, pair)), path) for pair in PAIRS}
                for channel in CHANNELS
            }
            own["read_off"] = {channel: {} for channel in CHANNELS}
            for row in rows.to_dict("records"):
                own["read_off"][row["channel"]][row["pair"]] = {name: _number(row[name]) for name in SHOWN}
            found.append(own)
    return {"edges": BIN_EDGES.tolist(), "rule": spectra.rule, "pairs": [*PAIRS, BOTH], "conditions": found}


def _bins(rows: pd.DataFrame | None, path: str | Path) -> dict:
    """The bins of one spectrum: place of the first, collisions per second and power [W] of each."""
    if rows is None or not len(rows):
        return {"first": 0, "collisions_hz": [], "power_W": []}
    low = rows["energy_low_J"].to_numpy(float)
    places = np.where(np.isnan(low), 0, np.searchsorted(BIN_EDGES, low * (1 + 1e-6)))
    expected = np.concatenate([[np.nan], BIN_EDGES])[places]
    if not np.allclose(low, expected, rtol=1e-6, equal_nan=True) or (np.diff(places) != 1).any():
        raise ConfigError(f"{path}: its bins are not those of this version; delete the file and run again")
    numbers = {name: [_number(value) for value in rows[name]] for name in ("collisions_hz", "power_W")}
    return {"first": int(places[0]), **numbers}


def heat_content(heat: Heat) -> dict:
    """Temperatures of every condition over the programme, each with its band, and the pauses that its limit needs."""
    temperatures = read_table(heat.temperatures, text=["condition", "body"])
    limits = read_table(heat.limits, text=["condition", "contact", "limit_body"])
    grouped = dict(list(temperatures.groupby(["condition", "body"], sort=False)))
    times = next(iter(grouped.values()))["time_h"].tolist()
    found = []
    for row in limits.to_dict("records"):
        courses = {
            body: {end: grouped[row["condition"], body][f"{end}_degC"].round(DECIMALS).tolist() for end in BAND}
            for body in BODIES
        }
        found.append(
            {
                "id": row["condition"],
                "words": condition_words(row["contact"], row["ball_diameter_mm"], row["fill_ratio"]),
                "contact": row["contact"],
                "ball_diameter_m": row["ball_diameter_mm"] * 1e-3,
                "fill_ratio": row["fill_ratio"],
                "speed_hz": row["speed_rpm"] / 60,
                "courses": courses,
                **{name: _number(row[name]) for name in OF_LIMIT},
                # An infinite time has no number in JSON.
                **{name: [_number(row[f"{name}_{end}"]) for end in BAND] for name in BANDS_OF_LIMIT},
            }
        )
    settings = heat.settings
    return {
        "times_h": [_number(time) for time in times],
        "probability": settings.probability,
        "programme": settings.programme.model_dump(mode="json"),
        "limit_body": settings.limit.body,
        "conditions": found,
    }
