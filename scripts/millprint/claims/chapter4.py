"""Claims of thesis chapter 4 against the tables of the partition stage."""

from pathlib import Path

import pandas as pd

from millprint.claims.evidence import Evidence, not_run, parts, rows
from millprint.claims.finding import Finding
from millprint.files import read_table

# Quantity in a claim's id -> column of Table 4.2 and the factor to the claim's unit.
TABLE_4_2 = {
    "speed": ("speed_hz", 1.0),
    "f": ("frequency_per_ball_hz", 1.0),
    "P": ("power_as_printed_W", 1.0),
    "En": ("normal_energy_J", 1e4),
    "Et": ("tangential_energy_J", 1e4),
    "ratio": ("ratio", 1.0),
    "yield": ("yield_percent", 1.0),
}
TABLE_4_4 = {
    "specific_yield": "specific_yield_per_W",
    "mass_per_watt": "mass_per_watt_g_W",
    "gain": "gain_percent",
}
PRIOR = {"time": "time_h", "bpr": "bpr", "speed": "speed_hz"}


def _row(table: pd.DataFrame, **wanted: str) -> pd.Series:
    """The one row wanted; raises LookupError where the run's own table of cases has none."""
    found = rows(table, **wanted)
    if found.empty:
        raise LookupError(f"the tables of the run have no row with {', '.join(f'{k} {v}' for k, v in wanted.items())}")
    return found.iloc[0]


def _both(evidence: Evidence, number: str) -> tuple[pd.DataFrame, pd.DataFrame]:
    """A table of chapter 4 from the published curves and from ours."""
    table = evidence.table(f"partition/table_{number}.tsv")
    return rows(table, curves="published"), rows(table, curves="ours")


def _value(table: pd.DataFrame, case: str, column: str) -> float:
    return float(_row(table, case=case)[column])


def _case(evidence: Evidence, name: str) -> Finding:
    """An entry of Table 4.2, with that of our own curves beside it."""
    case, quantity = parts(r"4\.case\.(.+)\.(\w+)", name)
    column, factor = TABLE_4_2[quantity]
    table, ours = _both(evidence, "4_2")
    value = factor * _value(table, case, column)
    if quantity == "yield":
        return Finding(value, "measured; from the table of cases")
    our_column = "power_W" if quantity == "P" else column
    beside = f"our curves give {factor * _value(ours, case, our_column):.4g}"
    if quantity == "P":
        exact = _value(table, case, "power_W")
        return Finding(
            value, f"Eq. 4.5 with energies and frequency at the printed digits; {exact:.4g} W unrounded; {beside}"
        )
    return Finding(value, f"from the published master-curve values; {beside}")


def _table_4_4(evidence: Evidence, name: str) -> Finding:
    quantity, case = parts(r"4\.(specific_yield|mass_per_watt|gain)\.(.+)", name)
    column = TABLE_4_4[quantity]
    value, ours = (_value(table, case, column) for table in _both(evidence, "4_4"))
    return Finding(value, f"measured yield over the printed power; {ours:.3g} with the power of our curves")


def _table_4_5(evidence: Evidence, name: str) -> Finding:
    case, baseline = parts(r"4\.leverage\.(.+)\.(dH|dG|LHV)", name)
    column = f"leverage_{baseline}_percent"
    value, ours = (_value(table, case, column) for table in _both(evidence, "4_5"))
    return Finding(value, f"Eq. 4.7 with the printed power; {ours:.3g} with the power of our curves")


def _slope(evidence: Evidence, name: str) -> Finding:
    slopes = evidence.table("partition/slopes.tsv")
    if name == "4.slope.r2":
        words = ", ".join(f"{row.r2:.4f} at {row.title}" for row in slopes.itertuples())
        return Finding(float(slopes["r2"].min()), f"the smaller of {words}; three points each")
    row = _row(slopes, series=name.rsplit(".", 1)[1])
    interval = f"{-row['slope_upper']:.3f} to {-row['slope_lower']:.3f}"
    return Finding(-float(row["slope_per_pp"]), f"least squares over {int(row['points'])} cases; interval {interval}")


def _prior(evidence: Evidence, name: str) -> Finding:
    row = _row(_both(evidence, "4_3")[0], metric=PRIOR[name.rsplit(".", 1)[1]])
    return Finding(float(row["change"]), f"{row['this_work']:.4g} against {row['prior']:g}")


FINDERS = {
    "4.case.": _case,
    "4.specific_yield.": _table_4_4,
    "4.mass_per_watt.": _table_4_4,
    "4.gain.": _table_4_4,
    "4.leverage.": _table_4_5,
    "4.slope.": _slope,
    "4.prior.": _prior,
}


def _find(evidence: Evidence, name: str) -> Finding:
    finder = next(finder for beginning, finder in FINDERS.items() if name.startswith(beginning))
    try:
        return finder(evidence, name)
    except LookupError as error:
        return not_run(str(error))


def findings(results: Path, data: Path) -> dict[str, Finding]:
    """A finding for every claim of chapter 4; `results` is the run's folder, `data` that of claims.tsv."""
    evidence = Evidence(Path(results))
    names = read_table(Path(data) / "claims.tsv", text=["id"])["id"]
    return {name: _find(evidence, name) for name in names if name.startswith("4.")}
