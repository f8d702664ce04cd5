"""Claims of thesis chapter 2: the screening design, the analysis of variance, half-life and wear; and of its text."""

from collections.abc import Callable

import pandas as pd

from millprint.estimate.quantiles import f_above
from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    NotRun,
    Repeats,
    agrees,
    as_printed,
    change_contradicted,
    change_percent,
    claim,
    datum,
    in_points,
    in_words,
    look_up,
    yes_no,
)

ANOVA, WEAR = "doe/anova_printed.tsv", "doe/wear.tsv"
MAIN_EFFECTS, INTERACTIONS = ("A", "B", "C", "D"), ("A:B", "A:C", "B:C")
SCREENING, LITERATURE = "config/data/screening.tsv", "config/data/literature.tsv"
# The study that the best run is compared with, by its number in the thesis.
PRIOR_REFERENCE = 16
BEST_CASE, LEAN_CASE, SHORT_CASE = 24, 15, 23
SHAPES = {"L": "linear", "Q": "quadratic"}
# Sec. 2.2.5: the level of significance.
SIGNIFICANT = 0.05
# Half of the last printed digit of the wear [g] and of the ball-to-powder ratio.
WEAR_ROUNDING_G, BPR_ROUNDING = 0.0005, 0.5
# A change of a mean yield by less than this is none [percentage points]; twice the repeatability of Sec. 2.2.5.
NO_CHANGE_PP = 5.0

# Eqs 2.8 and 2.7, Table 2.3.
look_up("2.full_factorial", "doe/fraction.json", "full_factorial_runs", told="m^x with three levels and four factors")
look_up("2.screening_runs", "doe/fraction.json", "runs", told="generators {generators}, resolution {resolution}")
look_up("2.half_life", "doe/half_life.tsv", "half_life_h", "note == 'as configured'", "pH {ph:g}, {temperature_k:g} K")
# Table 2.5: factors and interactions, and the contrasts of factors.
FACTORS = {name.replace(":", ""): name for name in (*MAIN_EFFECTS, *INTERACTIONS)}
AS_DESIGNED = "as run; the designed level of D in every run would give {sum_of_squares_as_designed:.4f}"
look_up("2.anova.{term}.ss", ANOVA, "sum_of_squares", "term == '{term}'", AS_DESIGNED, term=FACTORS)
ON_FREEDOM = "F = {F:.3f} on {degrees_of_freedom:.0f} degrees of freedom"
look_up("2.anova.{term}.p", ANOVA, "p_value", "term == '{term}'", ON_FREEDOM, term=FACTORS)
# Table 2.6: iron in the powder, and what the balls lost.
IN_POWDER = "{wear_g:.3f} g of wear in {powder_mass_g:.3f} g of powder charged (balls / BPR)"
look_up("2.wear.{speed}", WEAR, "iron_percent", "speed_rpm == {speed}", IN_POWDER)
look_up("2.wear.{speed}.g", WEAR, "wear_g", "speed_rpm == {speed}", "weighed")


@claim("2.anova.AB.df")
def interaction_degrees_of_freedom(evidence: Evidence) -> Finding:
    """The printed degrees of freedom of an interaction, against those that its printed p-value stands for."""
    evidence.row(ANOVA, "degrees_of_freedom", "term == 'A:B'")
    anova = evidence.table(ANOVA).set_index("term")
    if not {*MAIN_EFFECTS, *INTERACTIONS} <= set(anova.index):
        raise NotRun("the model of this configuration is not that of Table 2.5")
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
    return Finding(pareto["source"].iloc[0], f"F of each term: {in_words(pareto, '{source} {F:.1f}')}")


@claim("2.best_yield")
def best_yield(evidence: Evidence) -> Finding:
    """Table 2.4."""
    runs = evidence.rows("doe/residuals.tsv", "yield_percent")
    best = runs["yield_percent"].idxmax()
    return Finding(runs["yield_percent"][best], f"measured, case {runs['case'][best]}")


@claim("2.wear.{speed}.loss")
def weight_loss(evidence: Evidence, speed: str) -> Finding:
    """Table 2.6: wear over the unused mass, which the printed wear may contradict."""
    row = _weighing(evidence, speed, "weight_loss_percent")
    rests = f"2.wear.{speed}.g"
    printed, wear_g, unused_g = evidence.printed[evidence.id], evidence.printed[rests], row["unused_mass_g"]
    # The wear is printed to 0.001 g, rounded or cut off.
    ends = [100 * (float(wear_g) + end * 0.001) / unused_g for end in (-0.5, 1)]
    holds = any(agrees(printed, "printed", end) for end in ends) or not as_printed(evidence, rests)
    contradiction = Contradiction(
        f"the wear of {wear_g} g in the same row",
        f"it is {ends[0]:.3f} to {ends[1]:.3f} % of {unused_g:.2f} g. {printed} % follows from the two masses, so one "
        "of two printed numbers is off, and which one is not known",
    )
    return Finding(row["weight_loss_percent"], contradiction=None if holds else contradiction)


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
    """Sec. 2.3.3: the contamination is said to be below a bound up to 1000 rpm; the interval is that of rounding."""
    row = _weighing(evidence, "1000", "iron_percent")
    wear, ratio = WEAR_ROUNDING_G / row["wear_g"], BPR_ROUNDING / row["bpr"]
    low, high = (row["iron_percent"] * (1 + sign * wear) * (1 + sign * ratio) for sign in (-1, 1))
    told = f"at 1000 rpm, of {row['powder_mass_g']:.3f} g of powder, which is the balls over a BPR of {row['bpr']:g}"
    return Finding(row["iron_percent"], told, repeats=Repeats(low, high, "rounding of the wear and of the BPR", None))


def _case(evidence: Evidence, case: int, column: str) -> float:
    """A number of a run of the screening."""
    return datum(evidence, SCREENING, "case", case, column)


def _prior_speed(evidence: Evidence) -> float:
    return datum(evidence, LITERATURE, "reference", PRIOR_REFERENCE, "speed_rpm")


def _weighing(evidence: Evidence, speed: str, column: str) -> pd.Series:
    return evidence.row(WEAR, column, f"speed_rpm == {speed}")


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
    contradiction = change_contradicted(evidence, "2.prior_speed 2.best_speed", "Table 2.2 with Sec. 2.3.2", -1)
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
    best, short = (_case(evidence, case, "time_h") for case in (BEST_CASE, SHORT_CASE))
    return Finding(change_percent(best, short), f"{short:g} h after {best:g} h")


@claim("2.shorter.yield")
def loss_of_yield_by_shorter_milling(evidence: Evidence) -> Finding:
    """Sec. 2.3.2: what the shorter time costs; a difference of yields is one in points, as in Table 4.3."""
    best, short = (_case(evidence, case, "yield_percent") for case in (BEST_CASE, SHORT_CASE))
    return Finding(short - best, in_points(best, short))


@claim("2.trend.{factor}")
def shape_of_a_trend(evidence: Evidence, factor: str) -> Finding:
    """Sec. 2.3.1: the larger of the two contrasts of a factor."""
    rows = evidence.rows(ANOVA, "sum_of_squares", f"term in {[f'{factor}{shape}' for shape in SHAPES]}")
    sums = rows.set_index("term")["sum_of_squares"]
    return Finding(SHAPES[sums.idxmax()[-1]], f"sums of squares: {in_words(rows, '{term} {sum_of_squares:.3f}')}")


@claim("2.pareto.order")
def order_of_the_effects(evidence: Evidence) -> Finding:
    """Sec. 2.4: the three most significant effects; F ratios of 2 and of 4 degrees of freedom have no common order."""
    pareto = evidence.rows("doe/pareto.tsv", "source, p_value").sort_values("p_value").head(4)
    return Finding(", ".join(pareto["source"].head(3)), f"by p: {in_words(pareto, '{source} {p_value:.4f}')}")


@claim("2.anova.decide")
@claim("2.anova.decide.corrected")
def deciding_factors(evidence: Evidence) -> Finding:
    """Secs 2.3.1 and 2.4: what decides the yield, by type II sums and p < 0.05, as it is or by Holm."""
    where = "sums == 'II' and p_holm == p_holm"
    column = "p_holm" if evidence.id.endswith("corrected") else "p_value"
    terms = evidence.rows("doe/anova_corrected.tsv", column, where)
    held = terms.loc[terms[column] < SIGNIFICANT, "source"]
    told = in_words(terms, "{source} {p_value:.4f} ({p_holm:.3f})")
    return Finding(", ".join(sorted(held)), f"p before (and after) the correction: {told}")


# Sec. 2.3.1, Figs 2.4 and 2.5: axis and curve of an interaction, and whether its mean yields [%], by the level of the
# curve (rows) and of the axis (columns), are what is said.
INTERACTION_CLAIMS: dict[str, tuple[str, str, Callable[[pd.DataFrame], bool]]] = {
    # At the lowest ball-to-powder ratio, more reductant gives more yield; at the shortest time it ends in stagnation.
    "low_bpr": ("B", "A", lambda means: means.iloc[0].is_monotonic_increasing),
    "short_time": ("B", "C", lambda means: means.iloc[0, -1] - means.iloc[0, -2] < NO_CHANGE_PP),
    # At the shortest time, a higher speed gives more yield, which never reaches that of longer times.
    "short_speed": ("D", "C", lambda means: means.iloc[0].is_monotonic_increasing),
    "short_below": ("D", "C", lambda means: means.iloc[0].max() < means.iloc[1:].min(axis=None)),
    # For longer times, the curves intersect.
    "long_speed": ("D", "C", lambda means: (means.iloc[1] > means.iloc[2]).nunique() == 2),
    # At the highest speed, the yields of the three times are nearest to each other.
    "converge": ("D", "C", lambda means: (means.max() - means.min()).idxmin() == means.columns.max()),
}


@claim("2.interaction.{name}")
def interaction(evidence: Evidence, name: str) -> Finding:
    """What Sec. 2.3.1 reads off the mean yields of two factors."""
    axis, curve, holds = INTERACTION_CLAIMS[name]
    rows = evidence.rows("doe/interactions.tsv", "mean_yield_percent", f"axis == '{axis}' and curve == '{curve}'")
    means = rows.pivot(index="curve_level", columns="axis_level", values="mean_yield_percent")
    if means.shape != (3, 3):
        raise NotRun(f"{axis} and {curve} have not three levels each")
    told = in_words(rows, f"{{mean_yield_percent:.1f}} % at {curve} {{curve_level}}, {axis} {{axis_level}}")
    return yes_no(bool(holds(means)), f"mean yields: {told}")
