"""Claims in the text of thesis chapter 4, and its gains with our own curves in the place of the printed ones."""

import pandas as pd

from millprint.thesis.claims.chapter2_text import change_percent
from millprint.thesis.claims.chapter3_curves import curves_of
from millprint.thesis.claims.evidence import Contradiction, Evidence, Finding, NotRun, as_printed, claim
from millprint.thesis.claims.tolerances import agrees
from millprint.thesis.curves.regimes import read_regimes

PATH_4_4, PATH_4_5 = "partition/table_4_4.tsv", "partition/table_4_5.tsv"
PUBLISHED = "curves == 'published'"
REGIMES = "config/data/regimes.tsv"
LOW_POWER, EQUAL_POWER, NORMAL = "speed.tangential", "power.tangential", ("speed.normal", "power.normal")
CASES = ("reference", LOW_POWER, EQUAL_POWER, *NORMAL)


def _by_case(evidence: Evidence, path: str, column: str) -> pd.Series:
    """A column of a table of chapter 4 by case, from the published curves; not run without all cases."""
    found = evidence.rows(path, column, PUBLISHED).set_index("case")[column]
    if not set(CASES) <= set(found.index):
        raise NotRun(f"data.regimes has not the cases {', '.join(CASES)}")
    return found


def _specific(evidence: Evidence) -> pd.Series:
    """Specific yields of Table 4.4, at the printed power."""
    return _by_case(evidence, PATH_4_4, "specific_yield_per_W")


@claim(
    "4.mass_gain.{case}",
    "4.mass_gain.speed.tangential 4.mass_gain.speed.normal 4.mass_gain.power.tangential 4.mass_gain.power.normal",
)
def gain_by_mass(evidence: Evidence, case: str) -> Finding:
    """Table 4.4, lower block: from the entries at their three printed digits, as the thesis does."""
    mass = _by_case(evidence, PATH_4_4, "mass_per_watt_g_W")
    exact, rounded = (change_percent(table["reference"], table[case]) for table in (mass, mass.round(3)))
    return Finding(rounded, f"of rounded entries; {exact:.1f} % unrounded")


@claim("4.prior.yield")
def yield_over_prior_work(evidence: Evidence) -> Finding:
    """Table 4.3: in percentage points, where the other entries of the table are relative."""
    row = evidence.row("partition/table_4_3.tsv", "change", f"{PUBLISHED} and metric == 'yield_percent'")
    relative = change_percent(row["prior"], row["this_work"])
    return Finding(float(row["change"]), f"percentage points; {relative:.1f} % of {row['prior']:g} %")


@claim("4.text.jump")
def gain_of_shear_at_equal_power(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: specific yield of the tangential over the normal case at equal power."""
    specific = _specific(evidence)
    return Finding(change_percent(specific["power.normal"], specific[EQUAL_POWER]), "from Table 4.4")


@claim("4.text.times_reference")
def times_the_reference(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: specific yield of the tangential case at constant speed over that of the reference."""
    specific = _specific(evidence)
    return Finding(float(specific[LOW_POWER] / specific["reference"]), "from Table 4.4")


@claim("4.text.times_normal")
def times_the_normal_cases(evidence: Evidence) -> Finding:
    """Sec. 4.3.3: specific yield of the tangential case at constant speed over the mean of the two normal cases."""
    specific = _specific(evidence)
    ratios = ", ".join(f"{specific[LOW_POWER] / specific[name]:.1f} times {name}" for name in NORMAL)
    return Finding(float(specific[LOW_POWER] / specific[list(NORMAL)].mean()), ratios)


@claim("4.text.diminishing")
def loss_of_specific_yield(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: what the last ten points of yield cost in specific yield."""
    specific = _specific(evidence)
    rests = f"4.specific_yield.{LOW_POWER} 4.specific_yield.{EQUAL_POWER}"
    printed = [float(evidence.printed[name]) for name in rests.split()]
    change = change_percent(*printed)
    stands = not agrees(evidence.printed[evidence.id], "printed", change) and as_printed(evidence, rests)
    contradiction = Contradiction("Table 4.4", f"from {printed[0]:g} to {printed[1]:g} per watt is {change:.1f} %")
    value = change_percent(specific[LOW_POWER], specific[EQUAL_POWER])
    return Finding(value, "from Table 4.4", contradiction=contradiction if stands else None)


def _slopes(evidence: Evidence) -> pd.Series:
    """Slopes of the two lines by series, per percentage point of fill ratio."""
    slopes = -evidence.rows("partition/slopes.tsv", "slope_per_pp").set_index("series")["slope_per_pp"]
    if not {"speed", "power"} <= set(slopes.index):
        raise NotRun("data.regimes has fewer than three cases of a way of running")
    return slopes


@claim("4.text.steeper")
def steeper_line(evidence: Evidence) -> Finding:
    """Sec. 4.3.1."""
    slopes = _slopes(evidence)
    return Finding(change_percent(slopes["speed"], slopes["power"]), "of the slopes before they are rounded")


@claim("4.text.lost")
def yield_lost(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: yield lost from fill 6 to 17 %, at constant speed and at constant power, as fractions."""
    yields = _by_case(evidence, "partition/table_4_2.tsv", "yield_percent")
    lost = [(yields[f"{mode}.tangential"] - yields[f"{mode}.normal"]) / 100 for mode in ("speed", "power")]
    return Finding("/".join(f"{value:.4g}" for value in lost), "at constant speed and at constant power; Table 4.2")


@claim("4.text.{baseline}_over_dH", "4.text.dG_over_dH 4.text.LHV_over_dH")
def over_the_enthalpy(evidence: Evidence, baseline: str) -> Finding:
    """Sec. 4.3.2: how much larger another measure of the chemical energy is than the enthalpy."""
    columns = [f"leverage_{name}_percent" for name in (baseline, "dH")]
    row = evidence.row(PATH_4_5, ", ".join(columns), f"{PUBLISHED} and case == 'reference'")
    return Finding(float(row[columns[0]] / row[columns[1]]), "ratio of two columns of Table 4.5")


@claim("4.range.{baseline}", "4.range.dH 4.range.dG 4.range.LHV")
def range_of_the_leverage(evidence: Evidence, baseline: str) -> Finding:
    """Sec. 4.3.2: the smallest and the largest energy leverage."""
    column = f"leverage_{baseline}_percent"
    values = evidence.rows(PATH_4_5, column, PUBLISHED)[column]
    return Finding(f"{values.min():.6g}/{values.max():.6g}", "over the five cases of Table 4.5")


@claim(
    "4.own.{case}.gain",
    "4.own.speed.tangential.gain 4.own.speed.normal.gain 4.own.power.tangential.gain 4.own.power.normal.gain",
)
def gain_with_our_curves(evidence: Evidence, case: str) -> Finding:
    """Table 4.4 with our own curves: yield over the power that the experiment had, at the speed that it was run at."""
    evidence.cite(REGIMES, "yield_percent, balls, fill_ratio", read_regimes)
    cases = read_regimes(str(evidence.data / "regimes.tsv")).set_index("case")
    if not set(CASES) <= set(cases.index):
        raise NotRun(f"{REGIMES} has not the cases {', '.join(CASES)}")
    powers = {}
    for name in ("reference", case):
        fill = cases.at[name, "fill_ratio"]
        curves = curves_of(
            evidence, "Pn, Pt", f"fill_ratio == {fill}", f"the sweep has no calibrated case at fill {fill}"
        )
        speed = float(evidence.printed[f"4.case.{name}.speed"])
        powers[name] = float((curves["Pn"] + curves["Pt"]).iloc[0] * cases.at[name, "balls"] * speed**3)
    gained = cases.at[case, "yield_percent"] / cases.at["reference", "yield_percent"]
    return Finding(
        100 * (gained * powers["reference"] / powers[case] - 1),
        f"{powers[case] / powers['reference']:.2f} times the power of the reference, by Eq. 3.28 with our Pn + Pt",
    )
