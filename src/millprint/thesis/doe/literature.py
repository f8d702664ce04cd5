"""The literature (thesis Tables 2.1 and 2.2): unreported parameters, and numbers that disagree."""

from math import isnan, pi

import numpy as np
import pandas as pd
from molmass import FormulaError

from millprint.estimate.estimates import Estimate
from millprint.estimate.judge import Allowed, judge
from millprint.run.tables import Number, Text, read_measured, refuse_rows
from millprint.thesis.doe.chemistry import molar_mass
from millprint.thesis.doe.runs import PERCENT_YIELD, YIELD

POSITIVE_PARAMETERS = (
    "borate_mass_g",
    "reductant_mass_g",
    "powder_mass_g",
    "molar_ratio",
    "speed_rpm",
    "time_h",
    "jar_volume_ml",
    "ball_volume_percent",
    "bpr",
)
# Diameters and numbers of balls are text, because mixed balls are given as 10/4 mm.
TEXT_PARAMETERS = ("ball_diameter_mm", "balls", "mill", "vessel")
PARAMETERS = [*POSITIVE_PARAMETERS, *TEXT_PARAMETERS]
REACTANTS = ("borate", "reductant")
# Bearing and stainless steels lie within 2 % of it [g/cm3].
STEEL_DENSITY = 7.8
# Masses and ratios have two digits, so numbers that agree differ by no more than this.
TOLERANCE = 0.1


def read_literature(path: str) -> pd.DataFrame:
    """Read the studies, a row each (Table 2.2); an empty cell is a parameter that the study does not report.

    Raises ConfigError for a missing column, a text in a column of numbers, a number that is not above 0, a yield
    outside 0 to 100 %, a study that appears twice, and a reactant without a valid formula.
    """
    positive = [Number(name, 0, above=True, may_be_blank=True) for name in POSITIVE_PARAMETERS]
    frame = _read_studies(path, Text("reference", unique=True), *map(Text, TEXT_PARAMETERS), *positive)
    for column, pattern in (("ball_diameter_mm", r"\d+(\.\d+)?(/\d+(\.\d+)?)*"), ("balls", r"\d+(/\d+)*")):
        bad = frame[column].notna() & ~frame[column].fillna("").str.fullmatch(pattern)
        refuse_rows(frame, path, column, bad, "must be a number, or several such as 10/4")
    refuse_rows(
        frame,
        path,
        "balls",
        frame["ball_diameter_mm"].str.count("/").sub(frame["balls"].str.count("/")).fillna(0) != 0,
        lambda study: f"must be as many numbers as diameters ({study['ball_diameter_mm']})",
    )
    return frame


def read_reported_yields(path: str) -> pd.DataFrame:
    """Read the yields (Table 2.1), a row for each study and its reactants; raises ConfigError as `read_literature`."""
    return _read_studies(path, Text("reference"))


def _read_studies(path: str, *columns: Number | Text) -> pd.DataFrame:
    frame = read_measured(path, [*columns, *map(Text, REACTANTS), Number("year"), PERCENT_YIELD])
    for column in REACTANTS:
        bad = [not _is_formula(str(text)) for text in frame[column]]
        refuse_rows(frame, path, column, bad, "must be a formula such as MgH2")
    return frame


def _is_formula(text: str) -> bool:
    try:
        molar_mass(text)
    except FormulaError:
        return False
    return True


def missingness_table(studies: pd.DataFrame) -> pd.DataFrame:
    """A row a parameter, a column a study: yes where it is reported, no where not; least reported parameters first."""
    missing = studies.set_index("reference")[PARAMETERS].isna().T
    table = missing.map(lambda left_out: "no" if left_out else "yes").add_prefix("reference_")
    table.insert(0, "parameter", table.index)
    table["studies"] = missing.shape[1]
    table["unreported"] = missing.sum(axis=1)
    table["unreported_percent"] = 100 * missing.mean(axis=1)
    return table.sort_values("unreported", ascending=False, kind="stable", ignore_index=True)


def literature_checks(studies: pd.DataFrame, yields: pd.DataFrame) -> pd.DataFrame:
    """Every number of a study that follows from its others, and the yields of the two tables against each other.

    Within 10 % they agree. `studies` is Table 2.2, `yields` Table 2.1. Columns reference, check, reported, follows,
    verdict, note.
    """
    borates = list(dict.fromkeys([*studies["borate"], *yields["borate"]]))
    rows = []
    for _, study in studies.iterrows():
        rows += _check_masses(study, borates) + _check_balls(study)
        own = yields[yields["reference"] == study["reference"]]
        same = own[(own["borate"] == study["borate"]) & (own["reductant"] == study["reductant"])]
        match = own.loc[own[YIELD] == study[YIELD], "borate"]
        note = f"Table 2.1 gives this yield for {match.iloc[0]}" if len(match) else "the two tables differ"
        check = "yield in Tables 2.2 and 2.1 [%]"
        rows += [_row(study, check, study[YIELD], other, note, tolerance=0.0) for other in same[YIELD]]
    return pd.DataFrame(rows)


def _row(
    study: pd.Series, check: str, reported: float, follows: float, note: str, tolerance: float = TOLERANCE
) -> dict[str, object]:
    found = judge(Estimate(abs(follows / reported - 1), "-"), Allowed(upper=tolerance))
    return {
        "reference": study["reference"],
        "check": check,
        "reported": reported,
        "follows": follows,
        "verdict": found.word,
        "note": "" if found.agrees else note,
    }


def _molar_ratio(study: pd.Series, borate: str) -> float:
    amounts = study["reductant_mass_g"] / molar_mass(study["reductant"]), study["borate_mass_g"] / molar_mass(borate)
    return amounts[0] / amounts[1]


def _check_masses(study: pd.Series, borates: list[str]) -> list[dict]:
    """Compare the total mass and the molar ratio of a study with its two masses."""
    total, rows = study["borate_mass_g"] + study["reductant_mass_g"], []
    if isnan(total):
        return []
    if not isnan(study["powder_mass_g"]):
        rows.append(_row(study, "total mass [g]", study["powder_mass_g"], total, "the two masses make another sum"))
    if not isnan(study["molar_ratio"]):
        reported = study["molar_ratio"]
        others = [name for name in borates if abs(_molar_ratio(study, name) / reported - 1) <= TOLERANCE]
        note = f"follows from the masses if the borate is {others[0]}" if others else "follows for no hydrate"
        rows.append(_row(study, "molar ratio [-]", reported, _molar_ratio(study, study["borate"]), note))
    return rows


def _check_balls(study: pd.Series) -> list[dict]:
    """The share of the jar and the ball-to-powder ratio of a study against its balls, where it gives enough of them."""
    counted = isinstance(study["ball_diameter_mm"], str) and isinstance(study["balls"], str)
    if counted:
        diameters, numbers = (np.array(study[name].split("/"), float) for name in ("ball_diameter_mm", "balls"))
        volume = sum(numbers * pi / 6 * (diameters / 10) ** 3)
    else:
        volume = study["jar_volume_ml"] * study["ball_volume_percent"] / 100
    if isnan(volume):
        return []
    rows = []
    if counted and not isnan(study["ball_volume_percent"]):
        share = 100 * volume / study["jar_volume_ml"]
        rows.append(_row(study, "ball volume in jar [%]", study["ball_volume_percent"], share, "another fill"))
    if not isnan(study["powder_mass_g"]) and not isnan(study["bpr"]):
        needed = study["bpr"] * study["powder_mass_g"] / volume
        note = f"balls of {needed:.1f} g/cm3 would be needed; steel has {STEEL_DENSITY:g}, tungsten carbide 15.6"
        ratio = STEEL_DENSITY * volume / study["powder_mass_g"]
        rows.append(_row(study, "ball-to-powder ratio with steel balls [-]", study["bpr"], ratio, note))
    return rows
