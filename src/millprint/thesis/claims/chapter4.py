"""Claims of thesis chapter 4, its tables and its text."""

import pandas as pd

from millprint.thesis.claims.chapter2 import NO_CHANGE_PP
from millprint.thesis.claims.chapter3 import curves_of
from millprint.thesis.claims.evidence import (
    Evidence,
    Finding,
    NotRun,
    Repeats,
    change_contradicted,
    change_percent,
    claim,
    in_words,
    look_up,
    yes_no,
)
from millprint.thesis.regimes import read_regimes

PUBLISHED = "curves == 'published'"
OF_CASE = f"{PUBLISHED} and case == '{{case}}'"
PATH_4_2, PATH_4_3, PATH_4_4, PATH_4_5 = (f"partition/table_4_{number}.tsv" for number in (2, 3, 4, 5))
REGIMES = "config/data/regimes.tsv"
LOW_POWER, EQUAL_POWER, NORMAL = "speed.tangential", "power.tangential", ("speed.normal", "power.normal")
CASES = ("reference", LOW_POWER, EQUAL_POWER, *NORMAL)
# Quantity in a claim's id -> column of Table 4.2; energies are in 1e-4 J there.
TABLE_4_2 = {"speed": "speed_hz", "f": "specific_frequency_hz", "P": "power_as_printed_W", "yield": "yield_percent"}
look_up("4.case.{case}.{quantity}", PATH_4_2, "{quantity}", OF_CASE, quantity=TABLE_4_2)
for _name in ("normal", "tangential"):
    look_up(f"4.case.{{case}}.E{_name[0]}", PATH_4_2, f"{_name}_energy_J", OF_CASE, factor=1e4)
TABLE_4_4 = {"specific_yield": "specific_yield_per_W", "mass_per_watt": "mass_per_watt_g_W", "gain": "gain_percent"}
for _name, _column in TABLE_4_4.items():
    look_up(f"4.{_name}.{{case}}", PATH_4_4, _column, OF_CASE, "measured yield over the printed power")
look_up("4.leverage.{case}.{baseline}", PATH_4_5, "leverage_{baseline}_percent", OF_CASE, "Eq. 4.7, printed power")
# Sec. 4.3.1: the yield that a percentage point of fill costs; Table 4.3.
LINE = "least squares over {points:.0f} cases; slopes {slope_lower:.3f} to {slope_upper:.3f}"
look_up("4.slope.{series}", "partition/slopes.tsv", "slope_per_pp", "series == '{series}'", LINE, factor=-1.0)
PRIOR = {"time": "time_h", "bpr": "bpr", "speed": "speed_hz", "yield": "yield_percent"}
AGAINST = "{this_work:.4g} against {prior:g}"
look_up("4.prior.{metric}", PATH_4_3, "change", f"{PUBLISHED} and metric == '{{metric}}'", AGAINST, metric=PRIOR)


@claim("4.slope.r2")
def fit_of_the_slopes(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: the smaller R2 of the two lines."""
    slopes = evidence.rows("partition/slopes.tsv", "r2")
    words = in_words(slopes, "{r2:.4f} at {title}")
    return Finding(float(slopes["r2"].min()), f"the smaller of {words}; three points each")


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


@claim("4.text.jump")
def gain_of_shear_at_equal_power(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: specific yield of the tangential over the normal case at equal power."""
    specific = _specific(evidence)
    tables = specific, specific.round(3)
    exact, rounded = (change_percent(table["power.normal"], table[EQUAL_POWER]) for table in tables)
    return Finding(rounded, f"of rounded entries; {exact:.1f} % unrounded")


@claim("4.text.times_reference")
def times_the_reference(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: specific yield of the tangential case at constant speed over that of the reference."""
    specific = _specific(evidence)
    return Finding(float(specific[LOW_POWER] / specific["reference"]), "from Table 4.4")


@claim("4.text.times_normal")
def times_the_normal_cases(evidence: Evidence) -> Finding:
    """Sec. 4.3.3: specific yield of the tangential case at constant speed over the mean of the two normal cases."""
    specific = _specific(evidence)
    return Finding(float(specific[LOW_POWER] / specific[list(NORMAL)].mean()), "from Table 4.4")


@claim("4.text.diminishing")
def loss_of_specific_yield(evidence: Evidence) -> Finding:
    """Sec. 4.3.1: what the last ten points of yield cost in specific yield."""
    specific = _specific(evidence)
    rests = f"4.specific_yield.{LOW_POWER} 4.specific_yield.{EQUAL_POWER}"
    contradiction = change_contradicted(evidence, rests, "Table 4.4")
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
    yields = _by_case(evidence, PATH_4_2, "yield_percent")
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
    return curves_of(evidence, columns, f"fill_ratio == {fill}").iloc[0]


@claim("4.own.{case}.gain")
def gain_with_our_curves(evidence: Evidence, case: str) -> Finding:
    """Table 4.4 with our own curves: yield over the power that the experiment had, at the speed that it was run at."""
    cases, powers = _our_powers(evidence, ("reference", case))
    yields, ratio = cases["yield_percent"], powers[case] / powers.iloc[0]
    gained = yields[case] / yields["reference"]
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
    told = f"the power is that of the reference at {60 * speed:.0f} rpm"
    return Finding(value, told, repeats=Repeats(low, high, "the measured yields on both sides", None))


def _over_our_power(evidence: Evidence, path: str, column: str) -> pd.Series:
    """A column of chapter 4 that is over the power, by case: with the power of our curves in place of the thesis's."""
    evidence.cite(REGIMES, "normal_curve, tangential_curve", read_regimes)
    printed = read_regimes(str(evidence.data / "regimes.tsv")).set_index("case")
    theirs = printed["Pn"] + printed["Pt"]
    curves = {name: _our_curves(evidence, "Pn, Pt", printed.at[name, "fill_ratio"]) for name in CASES}
    ours = pd.Series({name: curve["Pn"] + curve["Pt"] for name, curve in curves.items()})
    return (_by_case(evidence, path, column) * theirs / ours)[list(CASES)]


@claim("4.own.leverage.least")
@claim("4.own.leverage.most")
def leverage_with_our_curves(evidence: Evidence) -> Finding:
    """Sec. 4.3.2: the smallest and the largest energy leverage on the enthalpy, over the power by our curves."""
    values = _over_our_power(evidence, PATH_4_5, "leverage_dH_percent")
    case = values.idxmin() if evidence.id.endswith("least") else values.idxmax()
    return Finding(float(values[case]), f"of {case}")


@claim("4.own.mass")
def mass_with_our_curves(evidence: Evidence) -> Finding:
    """Sec. 4.3.3: whether the reference converts more mass for a watt of our curves than both cases of equal power.

    Yields are within NO_CHANGE_PP of each other by chance; where that would turn the order, it is open.
    """
    mass = _over_our_power(evidence, PATH_4_4, "mass_per_watt_g_W")
    yields = _by_case(evidence, PATH_4_2, "yield_percent")
    others = [EQUAL_POWER, NORMAL[1]]
    more = mass[others] * (1 + NO_CHANGE_PP / yields[others])
    surely, holds = ("yes" if mass["reference"] > each.max() else "no" for each in (more, mass[others]))
    told = ", ".join(f"{mass[name]:.3f} g/W of {name}" for name in ("reference", *others))
    return Finding(holds, told, repeats=Repeats(surely, holds, "yields that were measured twice", None))


@claim("4.text.monotone")
@claim("4.own.monotone")
def yield_by_the_share_of_shear(evidence: Evidence) -> Finding:
    """Sec. 7.1: that the yield rises with tangential over normal power, at constant speed and at constant power."""
    table = evidence.rows(PATH_4_2, "ratio, yield_percent", PUBLISHED).set_index("case")
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
