"""What other groups reported (thesis Tables 2.1 and 2.2), and what each left out."""

import pandas as pd
from molmass import FormulaError

from millprint.doe.bounds import check_bounds
from millprint.doe.runs import YIELD
from millprint.doe.species import molar_mass
from millprint.errors import ConfigError
from millprint.files import read_table

NUMERIC = [
    "borate_mass_g",
    "reductant_mass_g",
    "powder_mass_g",
    "molar_ratio",
    "speed_rpm",
    "time_h",
    "jar_volume_ml",
    "ball_volume_percent",
    "bpr",
]
# Text, for mixed balls are given as 10/4 mm.
TEXT = ["ball_diameter_mm", "balls", "mill", "vessel"]
PARAMETERS = [*NUMERIC, *TEXT]
REACTANTS = ["borate", "reductant"]


def read_literature(path: str) -> pd.DataFrame:
    """Read the studies, a row each (Table 2.2); an empty cell is a parameter that the study does not report.

    Raises ConfigError for a missing column, a text in a column of numbers, a number that is not above 0, a yield
    outside 0 to 100 %, a study that appears twice, and a reactant that is no formula.
    """
    frame = read_table(path, numeric=["year", YIELD], text=["reference", *REACTANTS, *NUMERIC, *TEXT])
    for column in NUMERIC:
        values = pd.to_numeric(frame[column], errors="coerce")
        bad = (values.isna() & frame[column].notna()) | (values <= 0)
        if bad.any():
            study = frame.loc[bad].iloc[0]
            raise ConfigError(
                f"{path}: column {column}, reference {study['reference']} = {study[column]!r}: "
                "a number above 0 is wanted, or nothing where the study does not say"
            )
        frame[column] = values
    _check_studies(frame, path)
    _check_balls(frame, path)
    if frame["reference"].duplicated().any():
        twice = frame.loc[frame["reference"].duplicated(), "reference"].iloc[0]
        raise ConfigError(f"{path}: column reference = {twice} appears twice: a row for each study is wanted")
    return frame


def read_reported_yields(path: str) -> pd.DataFrame:
    """Read the yields (Table 2.1), a row for each study and its reactants; raises ConfigError as `read_literature`."""
    frame = read_table(path, numeric=["year", YIELD], text=["reference", *REACTANTS])
    _check_studies(frame, path)
    return frame


def _check_studies(frame: pd.DataFrame, path: str) -> None:
    check_bounds(frame, path, YIELD, 0, 100)
    for column in REACTANTS:
        for reference, formula in zip(frame["reference"], frame[column], strict=True):
            try:
                molar_mass(str(formula))
            except FormulaError:
                raise ConfigError(
                    f"{path}: column {column}, reference {reference} = {formula!r}: a formula such as MgH2 is wanted"
                ) from None


def _check_balls(frame: pd.DataFrame, path: str) -> None:
    """Diameters and numbers of balls are numbers, with as many of the one as of the other."""
    for column, pattern in (("ball_diameter_mm", r"\d+(\.\d+)?(/\d+(\.\d+)?)*"), ("balls", r"\d+(/\d+)*")):
        bad = frame[column].notna() & ~frame[column].fillna("").str.fullmatch(pattern)
        if bad.any():
            study = frame.loc[bad].iloc[0]
            raise ConfigError(
                f"{path}: column {column}, reference {study['reference']} = {study[column]!r}: "
                "a number, or several such as 10/4, is wanted"
            )
    both = frame.dropna(subset=["ball_diameter_mm", "balls"])
    for study in both.itertuples():
        if study.ball_diameter_mm.count("/") != study.balls.count("/"):
            raise ConfigError(
                f"{path}: column balls, reference {study.reference} = {study.balls!r}: as many numbers as diameters "
                f"({study.ball_diameter_mm}) are wanted"
            )


def unreported_table(studies: pd.DataFrame) -> pd.DataFrame:
    """For each study how many of the process parameters it leaves out, and which."""
    missing = studies[PARAMETERS].isna()
    return pd.DataFrame(
        {
            "reference": studies["reference"],
            YIELD: studies[YIELD],
            "parameters": len(PARAMETERS),
            "unreported": missing.sum(axis=1),
            "unreported_parameters": [
                ", ".join(name for name in PARAMETERS if missing.loc[row, name]) for row in studies.index
            ],
        }
    )


def missingness_table(studies: pd.DataFrame) -> pd.DataFrame:
    """A row a parameter, a column a study: yes where it is reported, no where not; least reported parameters first."""
    missing = studies.set_index("reference")[PARAMETERS].isna().T
    table = missing.map(lambda left_out: "no" if left_out else "yes")
    table.columns = [f"reference_{name}" for name in table.columns]
    table.insert(0, "parameter", table.index)
    table["studies"] = missing.shape[1]
    table["unreported"] = missing.sum(axis=1)
    table["unreported_percent"] = 100 * missing.mean(axis=1)
    return table.sort_values("unreported", ascending=False, kind="stable", ignore_index=True)
