"""Claims of thesis Sec. 3.2.2: the drop test and the oscillating ball, each recovering what was put in."""

import pandas as pd

from millprint.calibration.experiment import SIMULATED
from millprint.calibration.friction_fit import PARAMETERS
from millprint.claims.evidence import Evidence, not_run, rows
from millprint.claims.finding import Finding
from millprint.files import read_table

CONTACT = "calibrated"


def restitution(evidence: Evidence) -> Finding:
    """The mean restitution of the virtual drop tests, as the thesis takes the mean of its 32."""
    drops = rows(evidence.table("calibration/drop_test.tsv"), contact=CONTACT)
    if drops.empty:
        return not_run(f"contact set {CONTACT} is not in the run")
    given, found = drops["restitution_given"].iloc[0], drops["restitution"]
    return Finding(
        float(found.mean()),
        f"mean of {len(drops)} simulated drops with {given:g} put in; from {found.min():.4f} to {found.max():.4f}",
    )


def friction_fit(evidence: Evidence, mill: str) -> Finding:
    """The pair fitted to a simulated track of the calibrated set: the thesis prints no track to fit."""
    paths = sorted(evidence.results.glob("calibration/*/friction_fit.tsv"))
    tables = [read_table(path, text=["experiment", "parameter"]) for path in paths]
    fits = rows(pd.concat(tables), source=SIMULATED, contact=CONTACT, mill=mill) if tables else pd.DataFrame()
    same = rows(fits, track_mill=mill)
    if same.empty:
        return not_run(f"calibration.oscillation has no simulated experiment of contact set {CONTACT} in mill {mill}")
    pair = same[same["experiment"] == same["experiment"].iloc[0]].set_index("parameter").loc[list(PARAMETERS)]
    intervals = " and ".join(f"{row.lower:.4g} to {row.upper:.4g}" for row in pair.itertuples())
    others = fits[fits["track_mill"] != mill]
    told = [
        f"; a track made in {name} gives {'/'.join(f'{value:.3g}' for value in other['estimate'])} here"
        for name, other in others.groupby("track_mill")
    ]
    return Finding(
        "/".join(f"{value:.4g}" for value in pair["estimate"]),
        f"fitted to a simulated track of {pair['frames'].iloc[0]:.0f} frames that misses it by "
        f"{pair['rms_mm'].iloc[0]:.2g} mm; intervals {intervals}; the thesis prints no track{''.join(told)}",
    )
