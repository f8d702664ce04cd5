"""Claims of thesis chapter 2: the screening design, the analysis of variance, half-life and wear; and of its text."""

import pandas as pd

from millprint.estimate.quantiles import f_above
from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    NotRun,
    agrees,
    as_printed,
    claim,
    contradicted,
    datum,
    in_words,
    yes_no,
)

ANOVA, WEAR = "doe/anova_printed.tsv", "doe/wear.tsv"
# What the printed analysis does not say; only for explanations.
CORRECTED, PARTS = "doe/anova_corrected.tsv", "doe/residual_parts.tsv"
DETECTABLE, CONTESTED = "doe/detectable.tsv", "doe/contested.tsv"
MAIN_EFFECTS, INTERACTIONS = ("A", "B", "C", "D"), ("A:B", "A:C", "B:C")


@claim("2.full_factorial")
def full_factorial(evidence: Evidence) -> Finding:
    """Eq. 2.8."""
    row = evidence.row("doe/fraction.json", "full_factorial_runs")
    return Finding(row["full_factorial_runs"], "m^x with three levels and four factors")


@claim("2.screening_runs")
def screening_runs(evidence: Evidence) -> Finding:
    """Table 2.3, with the runs that depart from the design."""
    fraction = evidence.row("doe/fraction.json", "runs")
    departing = evidence.table("doe/audit.tsv", "check.str.startswith('generator') and departs == 'yes'")
    departures = in_words(departing, "{subject} was run at {found}, not {wanted}", "; ")
    return Finding(
        fraction["runs"],
        f"{', '.join(fraction['generators'])} (mod 3), defining relation I = {', '.join(fraction['defining_words'])}, "
        f"resolution {fraction['resolution']}; {departures or 'every run is as designed'}",
    )


@claim("2.half_life")
def half_life(evidence: Evidence) -> Finding:
    """Eq. 2.7, also with the temperature that the thesis has rounded."""
    own = evidence.row("doe/half_life.tsv", "half_life_h", "note == 'as configured'")
    exact = evidence.table("doe/half_life.tsv", "note == '25 degC, not rounded'").iloc[0]
    return Finding(
        own["half_life_h"],
        f"pH {own['ph']:g} and {own['temperature_k']:g} K; {exact['temperature_k']:g} K gives "
        f"{exact['half_life_h']:.1f} h",
    )


@claim("2.anova.{term}.ss")
def sum_of_squares(evidence: Evidence, term: str) -> Finding:
    """Table 2.5, factors and interactions; their linear and quadratic contrasts."""
    if term[-1] in SHAPES:
        row = evidence.row(ANOVA, "sum_of_squares", f"term == '{term}'", f"this configuration has no contrast {term}")
        return Finding(row["sum_of_squares"], "type I, model of the linear and quadratic contrasts only")
    term = ":".join(term)
    absent = f"{term} is not in the model of this configuration"
    row = evidence.row(ANOVA, "sum_of_squares", f"term == '{term}'", absent)
    return Finding(
        row["sum_of_squares"],
        "type I, yield as a fraction, factors as run; the designed level of D in every run would give "
        f"{row['sum_of_squares_as_designed']:.4f}{only_by_a_departure(evidence, term)}",
    )


def only_by_a_departure(evidence: Evidence, term: str) -> str:
    """What a term keeps after a confounded rival only because some runs are not at the levels of the design."""
    where = f"term == '{term}' and degrees_of_freedom_if_rival_first > degrees_of_freedom_if_designed"
    return "".join(
        f"; next to {row.rival} it keeps {row.sum_if_rival_first:.3f} on {row.degrees_of_freedom_if_rival_first:.0f} "
        f"degrees of freedom, of which the design has {row.degrees_of_freedom_if_designed:.0f}: the rest comes "
        "only from the run at another speed"
        for row in evidence.table(CONTESTED, where).itertuples()
    )


def tested_against(evidence: Evidence, term: str) -> str:
    """Explains the residual in a term's F ratio, where it consists only of interactions of that term."""
    parts = evidence.table(PARTS)
    if parts.empty:
        return ""
    parts, everything = parts[parts["effect"] != "together"], parts[parts["effect"] == "together"].iloc[0]
    if round(everything["share"], 6) < 1 or not all(term in effect.split(":") for effect in parts["effect"]):
        return ""
    shares = in_words(parts, "{effect} {share_as_designed:.0%}", " + ")
    return f"; the residual is {shares} (as designed) and nothing else, so {term} is tested against its interactions"


def smallest_seen(evidence: Evidence, term: str) -> str:
    """The smallest effect of a factor that the analysis would have found."""
    rows = evidence.table(DETECTABLE, f"factor == '{term}' and shape == 'steps'")
    return in_words(
        rows,
        "; a range of {smallest_range_percent:.0f} points between its levels would be seen with a probability of "
        "{power:.0%}",
    )


def after_holm(evidence: Evidence, term: str) -> str:
    """The p-value of a term with type II sums, corrected by Holm for the number of terms."""
    rows = evidence.table(CORRECTED, f"sums == 'II' and term == '{term}'")
    return in_words(rows, "; type II after Holm p = {p_holm:.3f}")


@claim("2.anova.{term}.p")
def p_value(evidence: Evidence, term: str) -> Finding:
    """Table 2.5."""
    term = ":".join(term)
    row = evidence.row(ANOVA, "p_value", f"term == '{term}'", f"{term} is not in the model of this configuration")
    residual = evidence.table(ANOVA, "term == 'Residual'").iloc[0]
    return Finding(
        row["p_value"],
        f"F = {row['F']:.3f} on {row['degrees_of_freedom']:.0f} and {residual['degrees_of_freedom']:.0f} degrees of "
        f"freedom{after_holm(evidence, term)}{tested_against(evidence, term)}{smallest_seen(evidence, term)}",
    )


@claim("2.anova.AB.df")
def interaction_degrees_of_freedom(evidence: Evidence) -> Finding:
    """The printed degrees of freedom of an interaction, against those that its printed p-value stands for."""
    absent = "the model of this configuration is not that of Table 2.5"
    evidence.row(ANOVA, "degrees_of_freedom", "term == 'A:B'", absent)
    anova = evidence.table(ANOVA).set_index("term")
    if not {*MAIN_EFFECTS, *INTERACTIONS} <= set(anova.index):
        raise NotRun(absent)
    degrees = anova["degrees_of_freedom"]
    own, residual = int(degrees["A:B"]), int(degrees["Residual"])
    total = int(degrees[[*MAIN_EFFECTS, *INTERACTIONS, "Residual"]].sum())
    left = total - int(degrees[list(MAIN_EFFECTS)].sum()) - len(INTERACTIONS) * int(evidence.printed[evidence.id])
    told = f"contrasts of A:B in the fitted model; p = {anova.loc['A:B', 'p_value']:.4f} on {own} and {residual}"
    return Finding(own, told, contradiction=_too_many_degrees(evidence, anova, left))


def _too_many_degrees(evidence: Evidence, anova: pd.DataFrame, left: int) -> Contradiction | None:
    """The printed degrees of freedom leave none for a residual, and the printed p is not theirs."""
    printed, printed_p = int(evidence.printed[evidence.id]), evidence.printed["2.anova.AB.p"]
    residual, mean_square = anova.loc["Residual", ["degrees_of_freedom", "mean_square"]]
    other = f_above(anova.loc["A:B", "sum_of_squares"] / printed / mean_square, printed, int(residual))
    rests = "2.screening_runs 2.anova.AB.ss 2.anova.AB.p"
    if left > 0 or agrees(printed_p, "printed", other) or not as_printed(evidence, rests):
        return None
    return Contradiction(
        f"its own p of {printed_p}, with the {evidence.printed['2.screening_runs']} runs of Table 2.3",
        f"{printed} for each of the three interactions would leave {left} degrees of freedom for the residual, and "
        f"even with {int(residual)} there p would be {other:.4f}. {printed} is the number for A:B and C:D together, "
        "but the sum of squares is that of A:B",
    )


@claim("2.pareto.first")
def largest_effect(evidence: Evidence) -> Finding:
    """Fig. 2.3; the table is sorted by F."""
    pareto = evidence.rows("doe/pareto.tsv", "source, F")
    stand = pareto[pareto["stands_after_holm"] == "yes"]
    held = f"{in_words(stand, '{source}', ' and ') or 'no term'} {'stands' if len(stand) < 2 else 'stand'}"
    told = f"F of each term, largest first: {in_words(pareto, '{source} {F:.1f}')}; after Holm (type II) {held}"
    return Finding(pareto["source"].iloc[0], told)


@claim("2.best_yield")
def best_yield(evidence: Evidence) -> Finding:
    """Table 2.4."""
    runs = evidence.rows("doe/residuals.tsv", "yield_percent")
    best = runs["yield_percent"].idxmax()
    return Finding(runs["yield_percent"][best], f"measured, case {runs['case'][best]}")


@claim("2.wear.{speed}")
def iron(evidence: Evidence, speed: str) -> Finding:
    """Table 2.6: iron in the powder."""
    row = _weighing(evidence, speed, "iron_percent")
    return Finding(
        row["iron_percent"],
        f"{row['wear_g']:.3f} g of wear in {row['powder_mass_g']:.3f} g of powder charged (balls / BPR); "
        f"{row['iron_of_mixture_percent']:.1f} % of powder and wear together",
    )


@claim("2.wear.{speed}.g")
def wear(evidence: Evidence, speed: str) -> Finding:
    """Table 2.6: what the balls lost."""
    return Finding(_weighing(evidence, speed, "wear_g")["wear_g"], "weighed; from the table of wear")


@claim("2.wear.{speed}.loss")
def weight_loss(evidence: Evidence, speed: str) -> Finding:
    """Table 2.6: wear over the unused mass, and what the difference of the two masses gives."""
    row = _weighing(evidence, speed, "weight_loss_percent")
    value, rounded = row["weight_loss_percent"], row["weight_loss_by_difference_percent"]
    told = (
        f"wear over the unused mass; the masses differ by {rounded:.3f} +- {row['reading_error_percent']:.3f} %, as "
        "they are printed to 0.01 g"
    )
    return Finding(value, told, contradiction=_loss_of_the_wear(evidence, speed, row["unused_mass_g"]))


def _loss_of_the_wear(evidence: Evidence, speed: str, unused_g: float) -> Contradiction | None:
    """The printed loss and the printed wear are from the same weighing; as rounded numbers, each stands for a range."""
    rests = f"2.wear.{speed}.g"
    printed, wear_g = evidence.printed[evidence.id], evidence.printed[rests]
    ends = [100 * (float(wear_g) + end * 0.001) / unused_g for end in (-0.5, 1)]
    if any(agrees(printed, "printed", end) for end in ends) or not as_printed(evidence, rests):
        return None
    return Contradiction(
        f"the wear of {wear_g} g in the same row",
        f"it is {ends[0]:.3f} to {ends[1]:.3f} % of {unused_g:.2f} g. {printed} % follows from the two masses, so one "
        "of two printed numbers is off, and which one is not known",
    )


@claim("2.slower.wear")
def wear_at_the_lower_speed(evidence: Evidence) -> Finding:
    """Sec. 2.3.1: that the balls wear less at 1000 than at 1200 rpm."""
    slow, fast = (_weighing(evidence, speed, "wear_g")["wear_g"] for speed in ("1000", "1200"))
    return yes_no(bool(slow < fast), f"{slow:.3f} g at 1000 rpm and {fast:.3f} g at 1200 rpm, each weighed once")


@claim("2.slower.energy")
def energy_at_the_lower_speed(evidence: Evidence) -> Finding:
    """Sec. 7.1: that the slower run takes less energy for the same yield."""
    ratio = (_case(evidence, BEST_CASE, "speed_rpm") / _prior_speed(evidence)) ** 3
    ratio *= _case(evidence, BEST_CASE, "time_h") / datum(evidence, LITERATURE, "reference", PRIOR_REFERENCE, "time_h")
    raise NotRun(
        "no table has the power of the mill of the earlier work, which is another one; in one mill, with the power as "
        f"the cube of the speed, the slower and longer run would take {ratio:.2f} times the energy"
    )


@claim("2.wear.below")
def iron_at_the_largest_speed(evidence: Evidence) -> Finding:
    """Sec. 2.3.3: the contamination is said to be below a bound up to 1000 rpm."""
    row = _weighing(evidence, "1000", "iron_percent")
    least = row["iron_percent"] * (1 - 0.0005 / row["wear_g"])
    bound, wear_g = float(evidence.printed[evidence.id]), evidence.printed["2.wear.1000.g"]
    contradiction = Contradiction(
        f"the wear of {wear_g} g in Table 2.6",
        f"it is {row['iron_percent']:.2f} % of {row['powder_mass_g']:.3f} g of powder, and {least:.2f} % at least",
    )
    holds = least <= bound or not as_printed(evidence, "2.wear.1000.g")
    return Finding(row["iron_percent"], "at 1000 rpm", contradiction=None if holds else contradiction)


SCREENING, LITERATURE = "config/data/screening.tsv", "config/data/literature.tsv"
# The study that the best run is compared with, by its number in the thesis.
PRIOR_REFERENCE = 16
BEST_CASE, LEAN_CASE, SHORT_CASES = 24, 15, (23, 14)
MEANS = "doe/interactions.tsv"
SHAPES = {"L": "linear", "Q": "quadratic"}
# A change of a mean yield by less than this is none [percentage points]; twice the repeatability of Sec. 2.2.5.
NO_CHANGE_PP = 5.0


def _case(evidence: Evidence, case: int, column: str) -> float:
    """A number of a run of the screening."""
    return datum(evidence, SCREENING, "case", case, column)


def _prior_speed(evidence: Evidence) -> float:
    return datum(evidence, LITERATURE, "reference", PRIOR_REFERENCE, "speed_rpm")


def _weighing(evidence: Evidence, speed: str, column: str) -> pd.Series:
    return evidence.row(WEAR, column, f"speed_rpm == {speed}", f"no weighing at {speed} rpm")


def change_percent(before: float, after: float) -> float:
    """By how much a number has changed, over what it was [%]."""
    return 100 * (after / before - 1)


@claim("2.case.{case}.yield")
def yield_of_a_case(evidence: Evidence, case: str) -> Finding:
    """Sec. 2.3.2."""
    return Finding(_case(evidence, int(case), "yield_percent"), "measured")


@claim("2.best_speed")
def speed_of_the_best_run(evidence: Evidence) -> Finding:
    """Sec. 2.3.2."""
    return Finding(_case(evidence, BEST_CASE, "speed_rpm"), "as run")


@claim("2.prior_speed")
def speed_of_the_earlier_work(evidence: Evidence) -> Finding:
    """Table 2.2."""
    return Finding(_prior_speed(evidence), "as that paper reports it")


@claim("2.slower")
def reduction_of_the_speed(evidence: Evidence) -> Finding:
    """Abstract, Secs 2.3.2, 2.4 and 7.1: how much slower the highest yield is reached."""
    before, after = _prior_speed(evidence), _case(evidence, BEST_CASE, "speed_rpm")
    rests = "2.prior_speed 2.best_speed"
    first, second = (float(evidence.printed[name]) for name in rests.split())
    reduced = -change_percent(first, second)
    check = (
        f"from {first:g} rpm before to {second:g} rpm here is {reduced:.1f} % slower; the difference is "
        f"{change_percent(second, first):.0f} % of the new speed"
    )
    contradiction = contradicted(evidence, reduced, rests, "Table 2.2 with Sec. 2.3.2", check)
    return Finding(-change_percent(before, after), f"from {before:g} to {after:g} rpm", contradiction=contradiction)


@claim("2.lean.{quantity}")
def reduction_in_the_lean_case(evidence: Evidence, quantity: str) -> Finding:
    """Sec. 2.3.2: what case 15 saves against case 24."""
    column = {"bpr": "bpr", "speed": "speed_rpm"}[quantity]
    best, lean = (_case(evidence, case, column) for case in (BEST_CASE, LEAN_CASE))
    return Finding(change_percent(best, lean), f"{lean:g} after {best:g}")


@claim("2.shorter.time")
def reduction_of_the_time(evidence: Evidence) -> Finding:
    """Sec. 2.3.2."""
    best, short = (_case(evidence, case, "time_h") for case in (BEST_CASE, SHORT_CASES[0]))
    return Finding(change_percent(best, short), f"{short:g} h after {best:g} h")


@claim("2.shorter.yield")
def loss_of_yield_by_shorter_milling(evidence: Evidence) -> Finding:
    """Sec. 2.3.2: what the shorter time costs."""
    best, short = (_case(evidence, case, "yield_percent") for case in (BEST_CASE, SHORT_CASES[0]))
    rests = "2.best_yield 2.case.23.yield"
    first, second = (float(evidence.printed[name]) for name in rests.split())
    lost = change_percent(first, second)
    check = f"from {first:g} to {second:g} % is {first - second:g} points, and {-lost:.1f} % less"
    contradiction = contradicted(evidence, lost, rests, "the yields in the same paragraph", check)
    return Finding(change_percent(best, short), f"{short:g} % after {best:g} %", contradiction=contradiction)


@claim("2.trend.{factor}")
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
    """Sec. 2.4: the three most significant effects; F ratios of 2 and of 4 degrees of freedom have no common order."""
    pareto = evidence.rows("doe/pareto.tsv", "source, p_value").sort_values("p_value").head(4)
    return Finding(", ".join(pareto["source"].head(3)), f"by p: {in_words(pareto, '{source} {p_value:.4f}')}")


@claim("2.anova.decide")
def deciding_factors(evidence: Evidence) -> Finding:
    """Secs 2.3.1 and 2.4: what decides the yield, by type II sums and with p corrected by Holm for seven tests."""
    terms = evidence.rows(CORRECTED, "p_holm, stands_after_holm", "sums == 'II' and p_holm == p_holm")
    held = terms.loc[terms["stands_after_holm"] == "yes", "source"]
    told = in_words(terms, "{source} {p_value:.4f} ({p_holm:.3f})")
    return Finding(", ".join(sorted(held)), f"p before (and after) the correction: {told}")


def _means(evidence: Evidence, axis: str, curve: str) -> pd.DataFrame:
    """Mean yields [%] by the level of the curve (rows) and of the axis (columns)."""
    rows = evidence.rows(MEANS, "mean_yield_percent", f"axis == '{axis}' and curve == '{curve}'")
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
