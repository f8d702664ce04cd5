"""What the atlas says about a simulated condition: rows of a fingerprint sheet, with the verdict on the simulation."""

from dataclasses import replace

import pandas as pd

from millprint.atlas.atlas_model import HITS
from millprint.atlas.estimate_mill import estimate, included_models
from millprint.atlas.kinds import balls_of, recognise
from millprint.config.contact_set import ContactConfig
from millprint.config.errors import ConfigError
from millprint.config.mill import MillConfig
from millprint.dose.spectra_shown import ATLAS
from millprint.estimate.estimates import Estimate, Interval
from millprint.estimate.judge import DIFFERS, Verdict, judge
from millprint.fingerprint.mill_sheet import SHEET, Row
from millprint.observables.definitions import DESCRIPTORS

# A simulation is far from the atlas beyond this ratio, and its inverse.
FAR = 1.3
LARGE = "A LARGE DIFFERENCE"
# What a sheet shows.
BESIDE = ("wall_power_W", "weighted_normal_energy_J", "weighted_tangential_energy_J")


def verdict_on(simulated: Estimate, told: Estimate) -> Verdict:
    """Whether a simulation agrees with what the atlas told, by the bands of one simulation."""
    return judge(replace(simulated, how="simulated"), replace(told, how="atlas"), by=("scatter",))


def is_far(simulated: Estimate, told: Estimate) -> bool:
    """Whether a simulation differs from what the atlas told by more than FAR."""
    return verdict_on(simulated, told).word == DIFFERS and not 1 / FAR < simulated.value / told.value < FAR


def atlas_rows(mill: MillConfig, contact: ContactConfig, sheet: pd.DataFrame) -> pd.DataFrame:
    """Rows of a sheet: what the atlas says at its condition, with the verdict; none where the atlas knows nothing.

    Balls of several sizes are not of the atlas. Where it finds that hardly anything hits, it tells the power only.
    """
    nothing, known = pd.DataFrame(columns=SHEET), recognise(mill)
    told = sheet[sheet["section"] == "condition"].set_index("quantity")["value"]
    if known is None or known[0].name not in included_models() or "charge" in told:
        return nothing
    settings = {"ball_diameter_mm": told["ball diameter"], "number": told["balls"], "speed_hz": told["speed"] / 60}
    try:
        found = estimate(known[0], {**known[1], **settings, **balls_of(contact)})
    except ConfigError:
        return nothing
    described, rows = sheet[sheet["section"] == "descriptors"].set_index("quantity"), []
    for name in BESIDE if found.hits >= HITS else BESIDE[:1]:
        title, atlas = DESCRIPTORS[name].title, found.known[name]
        value, lower, upper = described.loc[title, ["value", "lower", "upper"]].astype(float)
        simulated = Estimate(value, atlas.unit, scatter=Interval(lower, upper) if lower < upper else None)
        said = str(verdict_on(simulated, atlas)) + (f", {LARGE}" if is_far(simulated, atlas) else "")
        rows.append(Row(ATLAS, title, atlas.value, *atlas.ends("scatter"), atlas.unit, said))
    return pd.DataFrame(rows, columns=SHEET)
