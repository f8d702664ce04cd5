"""Which spectra a figure shows; and spectra and temperatures at the condition of a fingerprint sheet."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from millprint.fingerprint.descriptors import CHARGE, NOTHING, ONE_SIZE
from millprint.fingerprint.mill_sheet import SHEET, Row, sheet_condition
from millprint.observables.counted_collisions import BOTH, CHANNELS
from millprint.observables.definitions import DESCRIPTORS

if TYPE_CHECKING:
    from millprint.fingerprint.model import Fingerprint


SECTION = "spectra"
# Numbers of a sheet: column of the table of numbers read off a spectrum -> name in the sheet.
READ = {
    "mean_J": "mean energy",
    "median_J": "median energy",
    "half_power_J": "half of the power in collisions of at least",
}
FILL, NOTE = "simulated fill ratio", "no spectra"
OF_BIN = ["energy_low_J", "energy_high_J"]


def of_settings(
    table: pd.DataFrame, rule: str, charge: str, diameter_mm: float, speed_rpm: float
) -> pd.DataFrame:  # fmt: skip
    """The rows of the mill as built with one charge at one speed, by one rule."""
    own = table[(table["counting_rule"] == rule) & (table["varied"] == NOTHING) & (table[CHARGE] == charge)]
    # A table has fewer digits than a fingerprint.
    near = np.isclose(own["ball_diameter_mm"], diameter_mm, rtol=1e-5) & np.isclose(
        own["speed_rpm"], speed_rpm, rtol=1e-5
    )
    return own[near]


def shown(
    spectra: pd.DataFrame, rule_name: str, speed_rpm: float | None = None, ball_diameter_mm: float | None = None,
    fill_ratios: list[float] | None = None,
) -> pd.DataFrame:  # fmt: skip
    """The spectra that a figure shows: by one rule, of the mill as built, one charge at one speed, up to four fills.

    Defaults: the first charge and the lowest speed of the table, and four fill ratios spread over it.
    """
    table = spectra[(spectra["counting_rule"] == rule_name) & (spectra["varied"] == NOTHING)]
    for name, value in (("ball_diameter_mm", ball_diameter_mm), (CHARGE, None), ("speed_rpm", speed_rpm)):
        if len(table):
            table = table[table[name] == (table[name].iloc[0] if value is None else value)]
    fills = np.unique(table["fill_ratio"])
    if fill_ratios is None and len(fills):
        fill_ratios = fills[np.unique(np.linspace(0, len(fills) - 1, 4).round().astype(int))].tolist()
    return table[table["fill_ratio"].isin(fill_ratios or [])]


def sheet_rows(summary: pd.DataFrame, fingerprint: "Fingerprint") -> pd.DataFrame:
    """Rows of a sheet: the numbers read off the spectra of its condition.

    summary: of `spectra.tabulate_spectra` for the mill's sweep. A condition without spectra has a row that says why.
    """
    condition, charge = sheet_condition(fingerprint, summary[summary["varied"] == NOTHING])
    rule, fill = fingerprint.about["counting_rule"], condition.fill_ratio
    own = of_settings(summary, rule, charge, 1e3 * condition.ball_diameter_m, 60 * condition.speed_hz)
    own = own[own["fill_ratio"] == fill]
    rows = [Row(SECTION, FILL, fill, unit="-", text=charge)]
    if own["channel"].isna().all():
        rows.append(Row(SECTION, NOTE, text=own["note"].iloc[0]))
        return pd.DataFrame(rows, columns=SHEET)
    both = own[own["pair"] == BOTH].set_index("channel")
    rows.append(Row(SECTION, "collisions of all balls", both["collisions_hz"].iloc[0], unit="1/s"))
    for channel in CHANNELS:
        for column, title in READ.items():
            name = f"{DESCRIPTORS[f'{channel}_energy_J'].title}: {title}"
            rows.append(Row(SECTION, name, both.at[channel, column], unit="J"))
    return pd.DataFrame(rows, columns=SHEET)


def with_rows(sheet: pd.DataFrame, rows: pd.DataFrame) -> pd.DataFrame:
    """A sheet with the rows of `sheet_rows` at its end."""
    return pd.concat([sheet, rows], ignore_index=True)


def _cell(sheet: pd.DataFrame, section: str, quantity: str, column: str) -> Any:
    """A cell of a sheet."""
    return sheet.loc[(sheet["section"] == section) & (sheet["quantity"] == quantity), column].iloc[0]


def of_sheet(table: pd.DataFrame, sheet: pd.DataFrame, rules: Sequence[str] = ()) -> pd.DataFrame:
    """Rows of a table of spectra, or of numbers read off them, at the simulated condition of a sheet.

    By the rule of the sheet, or by `rules` in their order.
    """
    diameter, speed = (float(_cell(sheet, "condition", name, "value")) for name in ("ball diameter", "speed"))
    fill, charge = float(_cell(sheet, SECTION, FILL, "value")), _cell(sheet, SECTION, FILL, "text")
    # pandas reads an empty text as NaN.
    charge = charge if isinstance(charge, str) else ONE_SIZE
    rules = rules or [_cell(sheet, "mill", "collisions counted by", "text")]
    found = [of_settings(table, rule, charge, diameter, speed) for rule in rules]
    own = pd.concat(found)
    return own[np.isclose(own["fill_ratio"], fill, rtol=1e-5)]


def over_pairs(spectra: pd.DataFrame) -> pd.DataFrame:
    """Collisions per second and power in each bin, both pairs together, by counting rule and channel."""
    bins = spectra.dropna(subset=OF_BIN)
    groups = bins.groupby(["counting_rule", "channel", *OF_BIN], sort=True)
    return groups[["collisions_hz", "power_W"]].sum().reset_index()


def rules_apart(summary: pd.DataFrame) -> str:
    """A sentence on the differences between counting rules at one condition; summary: `of_sheet` by several rules."""
    both = summary[summary["pair"] == BOTH]
    if both.empty:
        return str(summary["note"].iloc[0]) if len(summary) else "no spectra"
    own = [both[both["channel"] == channel] for channel in CHANNELS]
    power, half = (
        " and ".join(f"{_spread(one[name]):.3g} ({channel})" for channel, one in zip(CHANNELS, own, strict=True))
        for name in ("power_W", "half_power_J")
    )
    rules, collisions = both["counting_rule"].nunique(), _spread(own[0]["collisions_hz"])
    words = f"{rules} counting rules differ by a factor of {collisions:.3g} in collisions a second, of {power} in power"
    return f"{words}, and of {half} in the energy above which half of the power falls"


def _spread(values: pd.Series) -> float:
    """The largest over the smallest value."""
    return float(values.max() / values.min())


# Further sections of a sheet; the second one is of `atlas.beside_simulation`.
TEMPERATURE, ATLAS = "temperature", "atlas"
BODIES = ("powder", "balls", "jar")


def temperature_rows(limits: pd.DataFrame, sheet: pd.DataFrame) -> pd.DataFrame:
    """Rows of a sheet: temperatures after long milling without a pause, at the sheet's condition.

    limits: of `heat_table.heat_tables`. A condition without a heat balance has a row that says so.
    """
    told = sheet[sheet["section"] == "condition"].set_index("quantity")["value"]
    columns = {"ball_diameter_mm": "ball diameter", "speed_rpm": "speed", "fill_ratio": "fill ratio"}
    same = np.ones(len(limits), dtype=bool)
    for column, quantity in columns.items():
        same &= np.isclose(limits[column], float(told[quantity]), rtol=1e-5)
    if not same.any():
        return pd.DataFrame([Row(TEMPERATURE, "temperatures", text="not calculated here")], columns=SHEET)
    own = limits[same].iloc[0]
    rows = []
    for body in BODIES:
        median, lower, upper = (float(own[f"{body}_steady_degC_{end}"]) for end in ("median", "lower", "upper"))
        rows.append(Row(TEMPERATURE, body, median, lower, upper, "°C"))
    return pd.DataFrame(rows, columns=SHEET)
