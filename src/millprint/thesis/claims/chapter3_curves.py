"""Claims of thesis chapter 3 on the master curves: values, shape and collapse."""

import numpy as np
import pandas as pd

from millprint.thesis.claims.chapter2 import change_percent
from millprint.thesis.claims.chapter3 import AS_BUILT, CONTACT, MILL
from millprint.thesis.claims.evidence import Evidence, Finding, NotRun, claim, in_words, yes_no
from millprint.thesis.curves.scaling import FACTOR, MACHINE


def curves_of(evidence: Evidence, columns: str, where: str, absent: str, contact: str = CONTACT) -> pd.DataFrame:
    """Means over the conditions of a contact set, a row a fill ratio; not run if they are of another mill."""
    found = evidence.rows(f"fingerprint/means_{contact}.tsv", columns, where, absent)
    if evidence.table(f"fingerprint/fingerprint_{contact}.json")["about"].iloc[0].get("mill") != MILL:
        raise NotRun(absent)
    return found


@claim("3.curve.{fill}.{quantity}")
def curve_value(evidence: Evidence, fill: str, quantity: str) -> Finding:
    """Fig. 3.12 and Table 4.2: a value of the calibrated master curves at one fill ratio."""
    absent = f"the sweep has no calibrated case at fill {fill}"
    row = curves_of(evidence, quantity, f"fill_ratio == {fill}", absent).iloc[0]
    spread = 100 * (row[f"{quantity}_upper"] / row[quantity] - 1)
    rules = ""
    if quantity == "f":
        table = evidence.table("fingerprint/counting_rules.tsv", f"{AS_BUILT} and fill_ratio == {fill}")
        means = table.groupby("counting_rule", sort=False)["f"].mean() if len(table) else pd.Series()
        rules = "; by counting rule: " if len(means) else ""
        rules += ", ".join(f"{value:.0f} {name}" for name, value in means.items())
    return Finding(float(row[quantity]), f"mean of {int(row['conditions'])} condition(s), spread {spread:.1f} %{rules}")


@claim("3.curve.ratio.low")
def largest_ratio(evidence: Evidence) -> Finding:
    """Fig. 3.12 d: the largest ratio up to the elbow, at fill 0.10."""
    absent = "the sweep has no calibrated case up to fill 0.10"
    low = curves_of(evidence, "ratio", "fill_ratio <= 0.10", absent)
    top = low.loc[low["ratio"].idxmax()]
    return Finding(float(top["ratio"]), f"at fill {top['fill_ratio']:g}")


@claim("3.curve.ratio.elbow")
def ratio_at_the_elbow(evidence: Evidence) -> Finding:
    """Fig. 3.12 d."""
    absent = "the sweep has no calibrated case at fill 0.10"
    row = curves_of(evidence, "ratio", "fill_ratio == 0.10", absent).iloc[0]
    return Finding(float(row["ratio"]), f"mean of {int(row['conditions'])} condition(s) at fill 0.10")


@claim("3.curve.ratio.high")
def ratio_at_high_fill(evidence: Evidence) -> Finding:
    """Fig. 3.12 d: the mean over zone 3."""
    absent = "the sweep has no calibrated case at fill 0.20 or more"
    high = curves_of(evidence, "ratio", "fill_ratio >= 0.20", absent)
    fills = high["fill_ratio"]
    return Finding(float(high["ratio"].mean()), f"mean over fills {fills.min():g} to {fills.max():g}")


def _whole_curves(evidence: Evidence, columns: str) -> pd.DataFrame:
    """The curves, if they show on which side of fill 0.20 the powers of one ball are largest."""
    absent = "the calibrated cases of the sweep do not span the fills 0.06 to over 0.20"
    curves = curves_of(evidence, columns, "", absent)
    if curves["fill_ratio"].max() <= 0.20 or curves["fill_ratio"].min() > 0.06:
        raise NotRun(absent)
    return curves


@claim("3.curve.normal_max")
def fill_of_largest_normal_power(evidence: Evidence) -> Finding:
    """Fig. 3.12 a."""
    curves = _whole_curves(evidence, "Pn")
    top = curves.loc[curves["Pn"].idxmax(), "fill_ratio"]
    return yes_no(0.10 <= top <= 0.20, f"the mean curve is largest at fill {top:g}")


@claim("3.curve.zone3")
def gain_beyond_zone_2(evidence: Evidence) -> Finding:
    """Fig. 3.12 a and b."""
    curves = _whole_curves(evidence, "Pn, Pt")
    beyond, before = curves[curves["fill_ratio"] > 0.20], curves[curves["fill_ratio"] <= 0.20]
    gains = {name: 100 * (beyond[name].max() / before[name].max() - 1) for name in ("Pn", "Pt")}
    return yes_no(
        max(gains.values()) <= 0,
        f"largest power of a ball beyond fill 0.20 against that up to it: normal {gains['Pn']:+.1f} %, "
        f"tangential {gains['Pt']:+.1f} %",
    )


@claim("3.curve.tangential")
def larger_channel(evidence: Evidence) -> Finding:
    """Sec. 3.4: that the tangential dissipation is larger than the normal one, at every fill ratio."""
    curves = _whole_curves(evidence, "ratio")
    told = in_words(curves, "{ratio:.2f} at {fill_ratio:g}")
    return yes_no(bool((curves["ratio"] > 1).all()), f"tangential over normal power by fill: {told}")


@claim("3.level.{contact}")
def frequency_in_zone_3(evidence: Evidence, contact: str) -> Finding:
    """Sec. 3.3.2: the change of the specific collision frequency from fill 0.20 to the last of zone 3 [%]."""
    absent = f"the sweep has no fills of 0.20 and more with contact set {contact}"
    curves = curves_of(evidence, "f", "fill_ratio >= 0.20", absent, contact)
    if len(curves) < 2:
        raise NotRun(absent)
    told = in_words(curves, "{f:.1f} at {fill_ratio:g}")
    return Finding(change_percent(curves["f"].iloc[0], curves["f"].iloc[-1]), f"by fill: {told}")


def rank_correlation(first: pd.Series, second: pd.Series) -> float:
    """Spearman's rank correlation: that of the ranks, the mean rank where values are equal.

    scipy.stats gives the same, but to import it takes as long as all claims.
    """
    return float(np.corrcoef(first.rank(), second.rank())[1, 0])


@claim("3.frequency.{contact}")
def trend_of_the_frequency(evidence: Evidence, contact: str) -> Finding:
    """Figs 3.7 d and 3.8 d: falling with fill for calibrated contacts, rising for steel, by rank and by its ends."""
    absent = f"the sweep has fewer than three fill ratios with contact set {contact}"
    curves = curves_of(evidence, "f", "", absent, contact)
    if len(curves) < 3:
        raise NotRun(absent)
    rank = rank_correlation(curves["fill_ratio"], curves["f"])
    first, last = curves.iloc[0], curves.iloc[-1]
    sign = {"calibrated": -1, "steel": 1}[contact]
    return yes_no(
        sign * rank > 0 and sign * (last["f"] - first["f"]) > 0,
        f"{first['f']:.1f} at fill {first['fill_ratio']:g}, {last['f']:.1f} at {last['fill_ratio']:g}, rank "
        f"correlation {rank:+.2f}",
    )


@claim("3.collapse")
def collapse(evidence: Evidence) -> Finding:
    """Fig. 3.12: the spread over the mean at each fill ratio, before and after the normalisation."""
    absent = "no fill ratio of the sweep has two calibrated conditions"
    where = f"scope == '{CONTACT}' and compared == '{MACHINE}' and quantity in ('Pn', 'Pt', 'f')"
    own = evidence.rows("fingerprint/collapse.tsv", "spread_scaled", where, absent)
    if evidence.table(f"fingerprint/fingerprint_{CONTACT}.json")["about"].iloc[0].get("mill") != MILL:
        raise NotRun(absent)
    worst = own.loc[own["spread_scaled"].idxmax()]
    return Finding(
        float(100 * worst["spread_scaled"]),
        f"largest spread in per cent, of {worst['quantity']} at fill {worst['fill_ratio']:g}; the median is "
        f"{100 * own['spread_scaled'].median():.1f} % after and {100 * own['spread_dimensional'].median():.0f} % "
        f"before the normalisation{_exponents(evidence)}",
    )


def _exponents(evidence: Evidence) -> str:
    """The exponents that our runs give the powers of one ball, in words."""
    words = []
    for name in ("normal", "tangential"):
        where = f"contact == '{CONTACT}' and quantity == '{name}_power_per_ball_W' and exponent == exponent"
        fits = evidence.table("fingerprint/exponents.tsv", where)
        if len(fits):
            words.append(f"{name} power {in_words(fits, '{variable} {exponent:.2f} ({lower:.2f} to {upper:.2f})')}")
    return f"; exponents from our runs, of the {'; of the '.join(words)}" if words else ""


@claim("3.universal")
def universal_collapse(evidence: Evidence) -> Finding:
    """Fig. 3.14: both contact sets collapse if the factor narrows the median spread of each quantity."""
    absent = "the sweep has no fill ratio with both contact sets"
    columns, where = "spread_scaled, spread_universal", "scope == 'universal' and quantity in ('Pn', 'Pt', 'f')"
    pooled = evidence.rows("fingerprint/collapse.tsv", columns, where, absent)
    median = 100 * pooled.groupby("quantity")[["spread_scaled", "spread_universal"]].median()
    holds = bool((median["spread_universal"] < median["spread_scaled"]).all())
    words = in_words(median.reset_index(), "{quantity} {spread_scaled:.1f} to {spread_universal:.1f} %", "; ")
    fits = evidence.table("fingerprint/exponents.tsv", f"contact == 'all' and variable == '{FACTOR}'")
    fitted = ", ".join(
        f"{-row.exponent:+.2f} for {row.quantity}" for row in fits.itertuples() if pd.notna(row.exponent)
    )
    best = f"; the power of 1 - eps that joins the sets in our runs, not 1/2: {fitted}" if fitted else ""
    return yes_no(
        holds, f"median spread over both sets without and with (1 - eps)^(1/2): {words}{'' if holds else best}"
    )
