"""Claims of thesis chapter 4, its tables and its text."""

import pandas as pd

from millprint.thesis.claims.chapter2 import change_percent
from millprint.thesis.claims.chapter3 import curves_of
from millprint.thesis.claims.evidence import Evidence, Finding, NotRun, Repeats, claim, contradicted, in_words, yes_no
from millprint.thesis.curves.regimes import read_regimes

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


@claim("4.case.{case}.{quantity}")
def condition(evidence: Evidence, case: str, quantity: str) -> Finding:
    """An entry of Table 4.2, with the value from our own curves."""
    column, factor = TABLE_4_2[quantity]
    row, ours = _published_and_ours(evidence, "4_2", column, case)
    value = factor * float(row[column])
    if quantity == "yield":
        return Finding(value, "measured; from the table of cases")
    our_column = "power_W" if quantity == "P" else column
    other = f"our curves give {factor * float(ours[our_column]):.4g}"
    if quantity == "P":
        rounded = f"Eq. 4.5 with energies and frequency at the printed digits; {row['power_W']:.4g} W unrounded"
        return Finding(value, f"{rounded}; {other}")
    return Finding(value, f"from the published master-curve values; {other}")


@claim("4.specific_yield.{case}")
@claim("4.mass_per_watt.{case}")
@claim("4.gain.{case}")
def yield_for_power(evidence: Evidence, case: str) -> Finding:
    """An entry of Table 4.4."""
    column = TABLE_4_4[evidence.id.split(".")[1]]
    row, ours = _published_and_ours(evidence, "4_4", column, case)
    told = f"measured yield over the printed power; {ours[column]:.3g} with the power of our curves"
    return Finding(float(row[column]), told)


@claim("4.leverage.{case}.{baseline}")
def leverage(evidence: Evidence, case: str, baseline: str) -> Finding:
    """An entry of Table 4.5."""
    column = f"leverage_{baseline}_percent"
    row, ours = _published_and_ours(evidence, "4_5", column, case)
    return Finding(
        float(row[column]), f"Eq. 4.7 with the printed power; {ours[column]:.3g} with the power of our curves"
    )


@claim("4.slope.{series}")
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


@claim("4.prior.{metric}")
def change_from_prior_work(evidence: Evidence, metric: str) -> Finding:
    """An entry of Table 4.3."""
    row = evidence.row("partition/table_4_3.tsv", "change", f"curves == 'published' and metric == '{PRIOR[metric]}'")
    return Finding(float(row["change"]), f"{row['this_work']:.4g} against {row['prior']:g}")


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


@claim("4.mass_gain.{case}")
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
    first, second = (float(evidence.printed[name]) for name in rests.split())
    change = change_percent(first, second)
    check = f"from {first:g} to {second:g} per watt is {change:.1f} %"
    contradiction = contradicted(evidence, change, rests, "Table 4.4", check)
    value = change_percent(specific[LOW_POWER], specific[EQUAL_POWER])
    return Finding(value, "from Table 4.4", contradiction=contradiction)


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


@claim("4.text.{baseline}_over_dH")
def over_the_enthalpy(evidence: Evidence, baseline: str) -> Finding:
    """Sec. 4.3.2: how much larger another measure of the chemical energy is than the enthalpy."""
    columns = [f"leverage_{name}_percent" for name in (baseline, "dH")]
    row = evidence.row(PATH_4_5, ", ".join(columns), f"{PUBLISHED} and case == 'reference'")
    return Finding(float(row[columns[0]] / row[columns[1]]), "ratio of two columns of Table 4.5")


@claim("4.range.{baseline}")
def range_of_the_leverage(evidence: Evidence, baseline: str) -> Finding:
    """Sec. 4.3.2: the smallest and the largest energy leverage."""
    column = f"leverage_{baseline}_percent"
    values = evidence.rows(PATH_4_5, column, PUBLISHED)[column]
    return Finding(f"{values.min():.6g}/{values.max():.6g}", "over the five cases of Table 4.5")


def _our_powers(evidence: Evidence, names: tuple[str, ...]) -> tuple[pd.DataFrame, pd.Series]:
    """The cases, and the powers of some of them by Eq. 3.28 with our curves, at the speeds that they were run at."""
    evidence.cite(REGIMES, "yield_percent, balls, fill_ratio", read_regimes)
    cases = read_regimes(str(evidence.data / "regimes.tsv")).set_index("case")
    if not set(CASES) <= set(cases.index):
        raise NotRun(f"{REGIMES} has not the cases {', '.join(CASES)}")
    powers = {}
    for name in names:
        curves = _our_curves(evidence, "Pn, Pt", cases.at[name, "fill_ratio"])
        speed = float(evidence.printed[f"4.case.{name}.speed"])
        powers[name] = float((curves["Pn"] + curves["Pt"]) * cases.at[name, "balls"] * speed**3)
    return cases, pd.Series(powers)


def _our_curves(evidence: Evidence, columns: str, fill: float) -> pd.Series:
    absent = f"the sweep has no calibrated case at fill {fill}"
    return curves_of(evidence, columns, f"fill_ratio == {fill}", absent).iloc[0]


@claim("4.own.{case}.gain")
def gain_with_our_curves(evidence: Evidence, case: str) -> Finding:
    """Table 4.4 with our own curves: yield over the power that the experiment had, at the speed that it was run at."""
    cases, powers = _our_powers(evidence, ("reference", case))
    gained, ratio = (
        cases.at[case, "yield_percent"] / cases.at["reference", "yield_percent"],
        powers[case] / powers.iloc[0],
    )
    told = f"{ratio:.2f} times the power of the reference, by Eq. 3.28 with our Pn + Pt"
    return Finding(100 * (gained / ratio - 1), told)


@claim("4.own.equal_power.gain")
def gain_at_our_equal_power(evidence: Evidence) -> Finding:
    """Sec. 4.3.1 at a power that is constant by our curves: the yield there, between those of the two shear cases.

    The thesis's setting of equal power is one of a larger power with our curves. Yields are interpolated in the speed;
    both ends are those of the measured yields.
    """
    cases, powers = _our_powers(evidence, ("reference", LOW_POWER, EQUAL_POWER))
    speeds = [float(evidence.printed[f"4.case.{name}.speed"]) for name in (LOW_POWER, EQUAL_POWER)]
    speed = speeds[0] * (powers["reference"] / powers[LOW_POWER]) ** (1 / 3)
    if not speeds[0] <= speed <= speeds[1]:
        raise NotRun(
            f"with our curves the power is that of the reference at {60 * speed:.0f} rpm, where nothing was measured"
        )
    yields = cases["yield_percent"] / cases.at["reference", "yield_percent"]
    low, high = (100 * (float(yields[name]) - 1) for name in (LOW_POWER, EQUAL_POWER))
    value = low + (high - low) * (speed - speeds[0]) / (speeds[1] - speeds[0])
    told = (
        f"the power is that of the reference at {60 * speed:.0f} rpm; the gain is {low:.0f} % with the yield at "
        f"{60 * speeds[0]:.0f} rpm and {high:.0f} % with that at {60 * speeds[1]:.0f} rpm"
    )
    return Finding(value, told, repeats=Repeats(low, high, "the measured yields on both sides", len(speeds)))


@claim("4.text.monotone")
@claim("4.own.monotone")
def yield_by_the_share_of_shear(evidence: Evidence) -> Finding:
    """Sec. 7.1: that the yield rises with tangential over normal power, at constant speed and at constant power."""
    table = evidence.rows("partition/table_4_2.tsv", "ratio, yield_percent", PUBLISHED).set_index("case")
    if not set(CASES) <= set(table.index):
        raise NotRun(f"data.regimes has not the cases {', '.join(CASES)}")
    if evidence.id.startswith("4.own"):
        table["ratio"] = [_our_curves(evidence, "ratio", fill)["ratio"] for fill in table["fill_ratio"]]
    holds, told = True, []
    for mode in ("speed", "power"):
        own = table.loc[[f"{mode}.normal", "reference", f"{mode}.tangential"]].sort_values("ratio")
        holds &= bool((own["yield_percent"].diff().dropna() > 0).all())
        told.append(f"at constant {mode} {in_words(own, '{yield_percent:g} % at {ratio:.2f}')}")
    return yes_no(holds, "; ".join(told))
