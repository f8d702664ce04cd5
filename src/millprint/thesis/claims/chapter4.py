"""Claims of thesis chapter 4: the five cases, their use of energy, the two lines, and earlier work."""

import pandas as pd

from millprint.thesis.claims.evidence import Evidence, Finding, claim, in_words

# Quantity in a claim's id -> column of Table 4.2 and the factor to the claim's unit.
TABLE_4_2 = {
    "speed": ("speed_hz", 1.0),
    "f": ("specific_frequency_hz", 1.0),
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


def _published_and_ours(evidence: Evidence, number: str, column: str, case: str) -> tuple[pd.Series, pd.Series]:
    """The row of a case in a table of chapter 4, from the published curves, which decides, and from ours."""
    path = f"partition/table_{number}.tsv"
    published = evidence.row(path, column, f"curves == 'published' and case == '{case}'")
    return published, evidence.table(path, f"curves == 'ours' and case == '{case}'").iloc[0]


@claim(
    "4.case.{case}.{quantity}",
    """
    4.case.reference.speed 4.case.reference.f 4.case.reference.P 4.case.reference.En 4.case.reference.Et
    4.case.reference.ratio 4.case.reference.yield
    4.case.speed.tangential.speed 4.case.speed.tangential.f 4.case.speed.tangential.P 4.case.speed.tangential.En
    4.case.speed.tangential.Et 4.case.speed.tangential.ratio 4.case.speed.tangential.yield
    4.case.speed.normal.speed 4.case.speed.normal.f 4.case.speed.normal.P 4.case.speed.normal.En
    4.case.speed.normal.Et 4.case.speed.normal.ratio 4.case.speed.normal.yield
    4.case.power.tangential.speed 4.case.power.tangential.f 4.case.power.tangential.P 4.case.power.tangential.En
    4.case.power.tangential.Et 4.case.power.tangential.ratio 4.case.power.tangential.yield
    4.case.power.normal.speed 4.case.power.normal.f 4.case.power.normal.P 4.case.power.normal.En
    4.case.power.normal.Et 4.case.power.normal.ratio 4.case.power.normal.yield
    """,
)
def condition(evidence: Evidence, case: str, quantity: str) -> Finding:
    """An entry of Table 4.2, with the value from our own curves."""
    column, factor = TABLE_4_2[quantity]
    row, ours = _published_and_ours(evidence, "4_2", column, case)
    value = factor * float(row[column])
    if quantity == "yield":
        return Finding(value, "measured; from the table of cases")
    our_column = "power_W" if quantity == "P" else column
    beside = f"our curves give {factor * float(ours[our_column]):.4g}"
    if quantity == "P":
        rounded = f"Eq. 4.5 with energies and frequency at the printed digits; {row['power_W']:.4g} W unrounded"
        return Finding(value, f"{rounded}; {beside}")
    return Finding(value, f"from the published master-curve values; {beside}")


@claim(
    "4.specific_yield.{case}",
    """
    4.specific_yield.reference 4.specific_yield.speed.tangential 4.specific_yield.speed.normal
    4.specific_yield.power.tangential 4.specific_yield.power.normal
    """,
)
@claim(
    "4.mass_per_watt.{case}",
    """
    4.mass_per_watt.reference 4.mass_per_watt.speed.tangential 4.mass_per_watt.speed.normal
    4.mass_per_watt.power.tangential 4.mass_per_watt.power.normal
    """,
)
@claim(
    "4.gain.{case}",
    "4.gain.reference 4.gain.speed.tangential 4.gain.speed.normal 4.gain.power.tangential 4.gain.power.normal",
)
def yield_for_power(evidence: Evidence, case: str) -> Finding:
    """An entry of Table 4.4."""
    column = TABLE_4_4[evidence.id.split(".")[1]]
    row, ours = _published_and_ours(evidence, "4_4", column, case)
    told = f"measured yield over the printed power; {ours[column]:.3g} with the power of our curves"
    return Finding(float(row[column]), told)


@claim(
    "4.leverage.{case}.{baseline}",
    """
    4.leverage.reference.dH 4.leverage.reference.dG 4.leverage.reference.LHV
    4.leverage.speed.tangential.dH 4.leverage.speed.tangential.dG 4.leverage.speed.tangential.LHV
    4.leverage.speed.normal.dH 4.leverage.speed.normal.dG 4.leverage.speed.normal.LHV
    4.leverage.power.tangential.dH 4.leverage.power.tangential.dG 4.leverage.power.tangential.LHV
    4.leverage.power.normal.dH 4.leverage.power.normal.dG 4.leverage.power.normal.LHV
    """,
)
def leverage(evidence: Evidence, case: str, baseline: str) -> Finding:
    """An entry of Table 4.5."""
    column = f"leverage_{baseline}_percent"
    row, ours = _published_and_ours(evidence, "4_5", column, case)
    return Finding(
        float(row[column]), f"Eq. 4.7 with the printed power; {ours[column]:.3g} with the power of our curves"
    )


@claim("4.slope.{series}", "4.slope.speed 4.slope.power")
def slope(evidence: Evidence, series: str) -> Finding:
    """Sec. 4.3.1: the yield that a percentage point of fill costs."""
    row = evidence.row("partition/slopes.tsv", "slope_per_pp", f"series == '{series}'")
    interval = f"{-row['slope_upper']:.3f} to {-row['slope_lower']:.3f}"
    return Finding(-float(row["slope_per_pp"]), f"least squares over {int(row['points'])} cases; interval {interval}")


@claim("4.slope.r2")
def fit_of_the_slopes(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: the smaller R2 of the two lines."""
    slopes = evidence.rows("partition/slopes.tsv", "r2")
    words = in_words(slopes, "{r2:.4f} at {title}")
    return Finding(float(slopes["r2"].min()), f"the smaller of {words}; three points each")


@claim("4.prior.{metric}", "4.prior.time 4.prior.bpr 4.prior.speed")
def change_from_prior_work(evidence: Evidence, metric: str) -> Finding:
    """An entry of Table 4.3."""
    row = evidence.row("partition/table_4_3.tsv", "change", f"curves == 'published' and metric == '{PRIOR[metric]}'")
    return Finding(float(row["change"]), f"{row['this_work']:.4g} against {row['prior']:g}")
