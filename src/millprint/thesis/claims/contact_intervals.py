"""Printed values that the DEM decides, each with ours and its interval by contact parameters only."""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millprint.fingerprint.bands import Factors
from millprint.run.files import read_table
from millprint.thesis.claims.tabulate import collect_findings, read_claims

# Ids of claims on the master curves, on the dissipation in one revolution and on the reference case.
CURVE = re.compile(r"3\.curve\.(?P<fill>0\.\d+)\.(?P<quantity>Pn|Pt|f|ratio)")
CYCLE = re.compile(r"3\.cycle\.\d+mm\.\d+\.(?P<channel>n|t)")
REFERENCE = re.compile(r"3\.reference\.(?P<quantity>En|Et|f)")
# Ids of Table 4.2, but for the cases of equal power, whose speed follows from the curves.
CASE = re.compile(r"4\.case\.(?P<case>reference|speed\.\w+)\.(?P<quantity>f|P|En|Et|ratio)")
CHANNELS = {"n": "Pn", "t": "Pt"}
# Quantity of Table 4.2: column of partition/table_4_2.tsv, and the unit that it is printed in.
COLUMNS = {
    "f": ("specific_frequency_hz", 1.0),
    "P": ("power_W", 1.0),
    "En": ("normal_energy_J", 1e-4),
    "Et": ("tangential_energy_J", 1e-4),
    "ratio": ("ratio", 1.0),
}
REFERENCE_FILL = 0.10
COLUMNS_OF_TABLE = [
    "id", "locus", "quantity", "unit", "fill_ratio", "factor_of", "published", "ours", "deviation_percent",
    "lower", "upper", "inside",
]  # fmt: skip


@dataclass(frozen=True)
class Place:
    """The quantity of CURVES that a printed value goes with, and its fill ratio."""

    quantity: str
    fill_ratio: float


def place_of(claim: str, cycle_fill_ratio: float, cases: dict[str, float]) -> Place | None:
    """The place of a claim; None for one that no factor applies to. cases: fill ratios of Table 4.2 by name."""
    if found := CURVE.fullmatch(claim):
        return Place(found["quantity"], float(found["fill"]))
    if found := CYCLE.fullmatch(claim):
        return Place(CHANNELS[found["channel"]], cycle_fill_ratio)
    if found := REFERENCE.fullmatch(claim):
        return Place(found["quantity"], REFERENCE_FILL)
    if (found := CASE.fullmatch(claim)) and found["case"] in cases:
        return Place(found["quantity"], cases[found["case"]])
    return None


def tabulate_contact_intervals(
    results: str | Path, claims_path: str | Path, factors: Factors, cycle_fill_ratio: float
) -> pd.DataFrame:
    """A row for each printed value that comes from the DEM, with COLUMNS_OF_TABLE.

    published: as printed; ours: what the run in the folder `results` computed, of chapter 4 with our own curves; lower,
    upper: ours times the factors of the contact parameters; inside: whether the printed value lies between them. The
    factors are those of one ball size and speed, which the scaling carries to the others. Values that the run has not
    computed, and fill ratios beyond those of the factors, have no interval.
    """
    claims = read_claims(claims_path)
    findings = collect_findings(results, claims_path, "3.c") | collect_findings(results, claims_path, "3.reference")
    regimes = read_table(Path(results) / "partition/table_4_2.tsv", text=["curves", "case"])
    regimes = regimes[regimes["curves"] == "ours"].set_index("case")
    cases = regimes["fill_ratio"].astype(float).to_dict()
    rows = []
    for claim in claims.itertuples():
        place = place_of(claim.id, cycle_fill_ratio, cases)
        if place is None:
            continue
        if found := CASE.fullmatch(claim.id):
            column, unit = COLUMNS[found["quantity"]]
            ours = float(regimes.at[found["case"], column]) / unit
        else:
            value = findings[claim.id].value
            ours = np.nan if value is None else float(value)
        published = float(claim.value)
        lower, upper = ours * factors.at(np.array([place.fill_ratio]))[place.quantity][:, 0]
        rows.append(
            {
                **{name: getattr(claim, name) for name in ("id", "locus", "quantity", "unit")},
                "fill_ratio": place.fill_ratio,
                "factor_of": place.quantity,
                "published": published,
                "ours": ours,
                "deviation_percent": 100 * (ours / published - 1),
                "lower": lower,
                "upper": upper,
                "inside": "" if np.isnan(lower) else "yes" if lower <= published <= upper else "no",
            }
        )
    return pd.DataFrame(rows, columns=COLUMNS_OF_TABLE)
