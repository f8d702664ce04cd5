"""What the explanations of chapter 3's claims say, from tables that say one thing or the other."""

import pandas as pd
import pytest

from millprint.thesis.claims import chapter3_causes as causes


class Tables:
    """Stands for the evidence of a run: its tables by path."""

    def __init__(self, **tables: pd.DataFrame) -> None:
        self.tables = {f"fingerprint/{name}.tsv": table for name, table in tables.items()}

    def table(self, path: str, where: str = "") -> pd.DataFrame:
        """The rows of a table that meet a condition."""
        found = self.tables.get(path, pd.DataFrame())
        return found.query(where) if where and len(found) else found


@pytest.mark.parametrize(("printed", "words"), [(11.0, "chance may explain it"), (30.0, "more than chance")])
def test_chance_explains_a_scatter_only_within_its_interval(printed, words):
    row = {
        "contact": "calibrated", "ball_diameter_mm": 10, "speed_rpm": 600, "normal_cv_percent": 10.0,
        "normal_cv_percent_published": printed, "revolutions": 30,
    }  # fmt: skip
    text = causes.spread_cause(Tables(table_3_5=pd.DataFrame([row])), "10", "600", "n")
    # 10 sqrt(29 / 45.72) and 10 sqrt(29 / 16.05), the quantiles of chi squared with 29 degrees of freedom.
    assert text.startswith(f"95 % interval 8.0 to 13.4 %: {words}")


def fit_table(change: float) -> pd.DataFrame:
    """A power that is 20 % too high, with a step of the jar's height, and another that is 5 % too high."""
    columns = ["record", "name", "quantity", "error_percent", "parameter", "parameter_value", "change_percent"]
    rows = [
        ("value", "Pn_f0.06", "Pn", 20.0, "", float("nan"), float("nan")),
        ("value", "Pt_f0.06", "Pt", 5.0, "", float("nan"), float("nan")),
        ("sensitivity", "Pn_f0.06", "Pn", float("nan"), "height_mm", 36.0, change),
        ("sensitivity", "Pt_f0.06", "Pt", float("nan"), "height_mm", 36.0, 3.0),
    ]
    return pd.DataFrame(rows, columns=columns)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (-8.0, "height_mm 36 brings it nearest, by -8 %, and takes further off Pt_f0.06 by +3 % (off by +5 %)"),
        (8.0, "no step brings it nearer"),
    ],
)
def test_the_shape_of_the_jar_brings_a_power_nearer_or_does_not(change, words):
    descriptors = pd.DataFrame()
    text = causes.curve_cause(Tables(fit=fit_table(change), descriptors=descriptors), "0.06", "Pn")
    assert words in text
    assert causes.curve_cause(Tables(), "0.06", "Pn") == ""
