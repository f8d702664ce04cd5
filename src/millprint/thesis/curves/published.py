"""Values that the thesis prints, as marks in figures and as curves to invert."""

from pathlib import Path

import pandas as pd

from millprint.config.errors import ConfigError
from millprint.fingerprint.condition import BASIC
from millprint.run.files import read_table
from millprint.run.tables import read_printed, refuse_rows


def read_published(path: str | Path, claims_path: str | Path) -> pd.DataFrame:
    """The published values: quantity, contact, fill_ratio, ball_diameter_mm, speed_rpm, value, unit, locus.

    path: their table, which may have a column `claim`: the id of a claim whose value is in the table `claims_path`.
    Raises ConfigError for a missing column, for a claim that is unknown, and for a value that is not a number.
    """
    text = ["quantity", "contact", "unit", "locus"]
    table = read_table(path, numeric=["fill_ratio", "value"], text=text, may_be_blank=["value"])
    if "claim" in table:
        claims = read_printed(claims_path)
        refuse_rows(table, path, "claim", table["claim"].notna() & ~table["claim"].isin(claims.index), "no known claim")
        printed = pd.to_numeric(table["claim"].map(claims), errors="coerce")
        table["value"] = table["value"].fillna(printed)
    missing = table["value"].isna()
    refuse_rows(table, path, "value", missing, "must be a number, or that of the row's claim in claims.tsv")
    for column in ("ball_diameter_mm", "speed_rpm"):
        if column not in table.columns:
            raise ConfigError(f"{path}: column {column} is missing; the table has {', '.join(table.columns)}")
    return table


def published_curves(published: pd.DataFrame, contact: str) -> pd.DataFrame:
    """Published master curves of a contact set: fill_ratio and a column for each of Pn, Pt, f and ratio."""
    curves = published[published["quantity"].isin(["Pn", "Pt", "f", "ratio"]) & (published["contact"] == contact)]
    return curves.pivot_table(index="fill_ratio", columns="quantity", values="value").reset_index()


def published_point(published: pd.DataFrame, contact: str, fill_ratio: float) -> dict[str, float] | None:
    """The published Pn, Pt and f at a fill ratio, or None where the thesis gives no values there."""
    curves = published_curves(published, contact)
    row = curves[(curves["fill_ratio"] - fill_ratio).abs() < 1e-9]
    if row.empty:
        return None
    return {name: float(row[name].iloc[0]) for name in BASIC}


def published_cycles(published: pd.DataFrame) -> pd.DataFrame:
    """Table 3.5 with the means that it implies: standard deviation over coefficient of variation [J]."""
    quantities = [f"{channel}_{part}" for channel in ("normal", "tangential") for part in ("sd_J", "cv_percent")]
    rows = published[published["quantity"].isin(quantities)]
    index = ["contact", "fill_ratio", "ball_diameter_mm", "speed_rpm"]
    table = rows.pivot_table(index=index, columns="quantity", values="value").reset_index()
    for channel in ("normal", "tangential"):
        if f"{channel}_sd_J" in table:
            table[f"{channel}_mean_J"] = 100.0 * table[f"{channel}_sd_J"] / table[f"{channel}_cv_percent"]
    return table
