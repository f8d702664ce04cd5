"""Claims in the text of thesis chapter 2: single cases, trends, interactions, and comparisons with earlier work."""

import pandas as pd

from millprint.run.files import read_table
from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    NotRun,
    as_printed,
    claim,
    in_words,
    yes_no,
)
from millprint.thesis.claims.tolerances import agrees

SCREENING, LITERATURE = "config/data/screening.tsv", "config/data/literature.tsv"
# The study that the best run is compared with, by its number in the thesis.
PRIOR_REFERENCE = 16
BEST_CASE, LEAN_CASE, SHORT_CASES = 24, 15, (23, 14)
ANOVA, INTERACTIONS = "doe/anova_printed.tsv", "doe/interactions.tsv"
SHAPES = {"L": "linear", "Q": "quadratic"}
# A change of a mean yield by less than this is none [percentage points]; twice the repeatability of Sec. 2.2.5.
NO_CHANGE_PP = 5.0


def _case(evidence: Evidence, case: int, columns: str) -> pd.Series:
    """A run of the screening, which becomes the source."""
    evidence.cite(SCREENING, f"{columns} of case {case}", read_table)
    runs = read_table(evidence.data / "screening.tsv", numeric=["case"])
    own = runs[runs["case"] == case]
    if own.empty:
        raise NotRun(f"{SCREENING} has no case {case}")
    return own.iloc[0]


def _prior_speed(evidence: Evidence) -> float:
    evidence.cite(LITERATURE, f"speed_rpm of reference {PRIOR_REFERENCE}", read_table)
    studies = read_table(evidence.data / "literature.tsv", numeric=["reference"], may_be_blank=["speed_rpm"])
    own = studies.loc[studies["reference"] == PRIOR_REFERENCE, "speed_rpm"]
    if own.empty:
        raise NotRun(f"{LITERATURE} has no reference {PRIOR_REFERENCE}")
    return float(own.iloc[0])


def change_percent(before: float, after: float) -> float:
    """By how much a number has changed, over what it was [%]."""
    return 100 * (after / before - 1)


@claim("2.case.{case}.yield", "2.case.15.yield 2.case.23.yield 2.case.14.yield")
def yield_of_a_case(evidence: Evidence, case: str) -> Finding:
    """Sec. 2.3.2."""
    return Finding(float(_case(evidence, int(case), "yield_percent")["yield_percent"]), "measured")


@claim("2.best_speed")
def speed_of_the_best_run(evidence: Evidence) -> Finding:
    """Sec. 2.3.2."""
    return Finding(float(_case(evidence, BEST_CASE, "speed_rpm")["speed_rpm"]), "as run")


@claim("2.prior_speed")
def speed_of_the_earlier_work(evidence: Evidence) -> Finding:
    """Table 2.2."""
    return Finding(_prior_speed(evidence), "as that paper reports it")


@claim("2.slower")
def reduction_of_the_speed(evidence: Evidence) -> Finding:
    """Abstract, Secs 2.3.2, 2.4 and 7.1: how much slower the highest yield is reached."""
    before, after = _prior_speed(evidence), float(_case(evidence, BEST_CASE, "speed_rpm")["speed_rpm"])
    rests = "2.prior_speed 2.best_speed"
    printed = [float(evidence.printed[name]) for name in rests.split()]
    reduced = -change_percent(*printed)
    contradiction = Contradiction(
        "Table 2.2 with Sec. 2.3.2",
        f"from {printed[0]:g} rpm before to {printed[1]:g} rpm here is {reduced:.1f} % slower; the difference is "
        f"{change_percent(printed[1], printed[0]):.0f} % of the new speed",
    )
    stands = not agrees(evidence.printed[evidence.id], "printed", reduced) and as_printed(evidence, rests)
    told = f"from {before:g} to {after:g} rpm"
    return Finding(-change_percent(before, after), told, contradiction=contradiction if stands else None)


@claim("2.lean.{quantity}", "2.lean.bpr 2.lean.speed")
def reduction_in_the_lean_case(evidence: Evidence, quantity: str) -> Finding:
    """Sec. 2.3.2: what case 15 saves against case 24."""
    column = {"bpr": "bpr", "speed": "speed_rpm"}[quantity]
    best, lean = (float(_case(evidence, case, column)[column]) for case in (BEST_CASE, LEAN_CASE))
    return Finding(change_percent(best, lean), f"{lean:g} after {best:g}")


@claim("2.shorter.time")
def reduction_of_the_time(evidence: Evidence) -> Finding:
    """Sec. 2.3.2."""
    best, short = (float(_case(evidence, case, "time_h")["time_h"]) for case in (BEST_CASE, SHORT_CASES[0]))
    return Finding(change_percent(best, short), f"{short:g} h after {best:g} h")


@claim("2.shorter.yield")
def loss_of_yield_by_shorter_milling(evidence: Evidence) -> Finding:
    """Sec. 2.3.2: what the shorter time costs."""
    best, short = (
        float(_case(evidence, case, "yield_percent")["yield_percent"]) for case in (BEST_CASE, SHORT_CASES[0])
    )
    printed = [float(evidence.printed[name]) for name in ("2.best_yield", "2.case.23.yield")]
    lost = change_percent(*printed)
    off = not agrees(evidence.printed[evidence.id], "printed", lost)
    contradiction = Contradiction(
        "the yields in the same paragraph",
        f"from {printed[0]:g} to {printed[1]:g} % is {printed[0] - printed[1]:g} points, and {-lost:.1f} % less",
    )
    stands = off and as_printed(evidence, "2.best_yield 2.case.23.yield")
    return Finding(
        change_percent(best, short), f"{short:g} % after {best:g} %", contradiction=contradiction if stands else None
    )


@claim("2.trend.{factor}", "2.trend.A 2.trend.B 2.trend.C")
def shape_of_a_trend(evidence: Evidence, factor: str) -> Finding:
    """Sec. 2.3.1: the larger of the two contrasts of a factor."""
    terms = [f"{factor}{shape}" for shape in SHAPES]
    rows = evidence.rows(ANOVA, "sum_of_squares", f"term in {terms}", f"no contrasts of {factor}")
    sums = rows.set_index("term")["sum_of_squares"]
    return Finding(
        SHAPES[sums.idxmax()[-1]],
        f"sums of squares: {', '.join(f'{name} {value:.3f}' for name, value in sums.items())}",
    )


@claim("2.pareto.order")
def order_of_the_effects(evidence: Evidence) -> Finding:
    """Sec. 2.4 with Fig. 2.3: the three largest effects by F, by which the thesis ranks them."""
    pareto = evidence.rows("doe/pareto.tsv", "source, F")
    by_p = evidence.table(ANOVA, "p_value == p_value").sort_values("p_value")
    return Finding(
        ", ".join(pareto["source"].head(3)),
        f"by F: {in_words(pareto.head(4), '{source} {F:.1f}')}; by p: {in_words(by_p.head(4), '{term} {p_value:.4f}')}",
    )


def _means(evidence: Evidence, axis: str, curve: str) -> pd.DataFrame:
    """Mean yields [%] by the level of the curve (rows) and of the axis (columns)."""
    rows = evidence.rows(INTERACTIONS, "mean_yield_percent", f"axis == '{axis}' and curve == '{curve}'")
    means = rows.pivot(index="curve_level", columns="axis_level", values="mean_yield_percent")
    if means.shape != (3, 3):
        raise NotRun(f"{axis} and {curve} have not three levels each")
    return means


def _told(means: pd.Series) -> str:
    return ", ".join(f"{value:.1f} % at {level:g}" for level, value in means.items())


@claim("2.interaction.low_bpr")
def molar_ratio_at_low_bpr(evidence: Evidence) -> Finding:
    """Sec. 2.3.1, Fig. 2.4 a: at the lowest ball-to-powder ratio, more reductant gives more yield."""
    means = _means(evidence, "B", "A").iloc[0]
    return yes_no(bool(means.is_monotonic_increasing), f"mean yields by molar ratio: {_told(means)}")


@claim("2.interaction.short_time")
def molar_ratio_at_short_time(evidence: Evidence) -> Finding:
    """Sec. 2.3.1, Fig. 2.4 b: at the shortest time, more reductant ends in stagnation."""
    means = _means(evidence, "B", "C").iloc[0]
    return yes_no(
        bool(means.iloc[-1] - means.iloc[-2] < NO_CHANGE_PP),
        f"mean yields by molar ratio: {_told(means)}; a gain below {NO_CHANGE_PP:g} points is none",
    )


@claim("2.interaction.short_speed")
def speed_at_short_time(evidence: Evidence) -> Finding:
    """Sec. 2.3.1, Fig. 2.5: at the shortest time, a higher speed gives more yield."""
    means = _means(evidence, "D", "C").iloc[0]
    return yes_no(bool(means.is_monotonic_increasing), f"mean yields by speed: {_told(means)}")


@claim("2.interaction.short_below")
def short_time_below_all(evidence: Evidence) -> Finding:
    """Sec. 2.3.1, Fig. 2.5: the mean yields of the shortest time never reach those of longer ones."""
    means = _means(evidence, "D", "C")
    short, longer = means.iloc[0].max(), means.iloc[1:].min(axis=None)
    return yes_no(bool(short < longer), f"at most {short:.1f} %, and at least {longer:.1f} % with longer times")


@claim("2.interaction.converge")
def yields_at_high_speed(evidence: Evidence) -> Finding:
    """Sec. 2.3.1, Fig. 2.5: at the highest speed, the mean yields of the three times are nearest to each other."""
    means = _means(evidence, "D", "C")
    ranges = means.max() - means.min()
    return yes_no(
        bool(ranges.idxmin() == ranges.index.max()),
        f"range over the times: {', '.join(f'{value:.0f} points at {speed:g} rpm' for speed, value in ranges.items())}",
    )
