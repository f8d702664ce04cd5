"""Claims of thesis chapter 5: yield models on the locked split and outside their domain."""

import pandas as pd

from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    Interval,
    as_printed,
    claim,
    in_words,
    interval_of,
)
from millprint.thesis.yields.metrics import GAINS, LEFT_OUT, NESTED, RANDOM
from millprint.thesis.yields.regressors import regressor

UNITS = {"rmse": " pp", "mae": " pp", "mape": " %", "r2": "", "wmse": " pp2"}
# Rows of yield/choices.tsv of models that differ only in a seed.
SEEDED = ("seed", "search_seed")
# Disjoint parts of the sum of squares of the yields, Table 2.5; the residual is not printed.
PRINTED_SUMS = "2.anova.A.ss 2.anova.B.ss 2.anova.C.ss 2.anova.D.ss 2.anova.AB.ss 2.anova.AC.ss 2.anova.BC.ss"
# Other ways to split the rows, in the order in which an explanation names them.
SCHEMES = {LEFT_OUT: "leave-one-out", NESTED: "nested cross-validation", RANDOM: "other splits of this size"}
OVER_REPEATS = "over {repeats:g} of them {lowest:.3g} to {highest:.3g}, median {median:.3g}"


@claim("5.linear.{metric}", "5.linear.rmse 5.linear.mae 5.linear.mape 5.linear.r2 5.linear.wmse")
@claim(
    "5.{model}.{strategy}.{metric}",
    """
    5.gpr.primary.rmse 5.gpr.primary.mae 5.gpr.primary.mape 5.gpr.primary.r2 5.gpr.primary.wmse
    5.gpr.two_step.rmse 5.gpr.two_step.mae 5.gpr.two_step.mape 5.gpr.two_step.r2 5.gpr.two_step.wmse
    5.rf.primary.rmse 5.rf.primary.mae 5.rf.primary.mape 5.rf.primary.r2 5.rf.primary.wmse
    5.rf.two_step.rmse 5.rf.two_step.mae 5.rf.two_step.mape 5.rf.two_step.r2 5.rf.two_step.wmse
    5.svr.primary.rmse 5.svr.primary.mae 5.svr.primary.mape 5.svr.primary.r2 5.svr.primary.wmse
    5.svr.two_step.rmse 5.svr.two_step.mae 5.svr.two_step.mape 5.svr.two_step.r2 5.svr.two_step.wmse
    5.xgb.primary.rmse 5.xgb.primary.mae 5.xgb.primary.mape 5.xgb.primary.r2 5.xgb.primary.wmse
    5.xgb.two_step.rmse 5.xgb.two_step.mae 5.xgb.two_step.mape 5.xgb.two_step.r2 5.xgb.two_step.wmse
    """,
)
def error_on_the_locked_split(
    evidence: Evidence, metric: str, model: str = "linear", strategy: str = "primary"
) -> Finding:
    """A metric of Table 5.6, with its interval and the values of other schemes."""
    path, unit = "yield/scores_by_scheme.tsv", UNITS[metric]
    own = f"model == '{model}' and strategy == '{strategy}' and metric == '{metric}'"
    absent = f"results/{path} has no {metric} of {model} {strategy}"
    locked = evidence.row(path, "value", f"{own} and scheme == 'locked'", absent)
    rows = int(evidence.table("yield/locked.tsv")["test_rows"].iloc[0])
    told_as, others = "{scheme} {value:.3g} ({lower:.3g} to {upper:.3g})", evidence.table(path, own).set_index("scheme")
    others = others.reindex([scheme for scheme in SCHEMES if scheme in others.index]).rename(index=SCHEMES)
    parts = (
        f"{rows} test rows decide nothing: over resamples of them {locked['lower']:.3g} to {locked['upper']:.3g}{unit}",
        in_words(others[others["repeats"] == 1].reset_index(), f"{told_as}{unit}", "; "),
        in_words(others[others["repeats"] > 1].reset_index(), f"{told_as}{unit}, {OVER_REPEATS}", "; "),
    )
    value, printed = float(locked["value"]), float(evidence.printed[evidence.id])
    gain = value - printed if metric in GAINS else printed - value
    better = f"; better than printed by {abs(gain):.3g}" if gain > 0.1 * abs(printed) else ""
    told = f"{'; '.join(filter(None, parts))}{better}. {regressor(model).settled}"
    return Finding(value, told, interval=_over_seeds(evidence, model, strategy, metric, value))


def _over_seeds(evidence: Evidence, model: str, strategy: str, column: str, value: float) -> Interval | None:
    """The interval of a value with those of other seeds of search and trees; None of a model without any."""
    own = f"model == '{model}' and strategy == '{strategy}' and choice in {SEEDED}"
    others = evidence.table("yield/choices.tsv", own)
    return interval_of([value, *others[column]], "seeds") if len(others) else None


@claim("5.ood.{case}.{model}", "5.ood.27.gpr 5.ood.28.gpr 5.ood.27.xgb 5.ood.28.xgb")
def prediction_outside_the_domain(evidence: Evidence, case: str, model: str) -> Finding:
    """Table 5.8."""
    path = "yield/out_of_domain.tsv"
    where = f"case == {case} and model == '{model}' and strategy == 'two_step'"
    row = evidence.row(path, "predicted_percent", where, f"results/{path} has no case {case} of {model}")
    interval = ""
    if pd.notna(row["deviation_pp"]):
        interval = f"; interval {row['lower_percent']:.0f} to {row['upper_percent']:.0f} %"
    return Finding(
        float(row["predicted_percent"]),
        f"measured {row['yield_percent']:g} %, error {row['error_pp']:+.1f} points{interval}; not fitted again",
        interval=_over_seeds(evidence, model, "two_step", f"case_{case}_percent", float(row["predicted_percent"])),
    )


@claim("5.time_variance")
def variance_between_times(evidence: Evidence) -> Finding:
    """Sec. 5.2.5: an erratum where no function of time explains as much as is printed."""
    row = evidence.row("yield/time_variance.tsv", "share", "measure == 'levels'")
    line = evidence.table("yield/time_variance.tsv", "measure == 'line'").iloc[0]
    return Finding(
        100 * row["share"],
        "sum of squares between the times over the total, all runs: the most that any function of time explains; a "
        f"straight line explains {100 * line['share']:.1f} %",
        contradiction=_share_in_the_analysis(evidence),
    )


def _share_in_the_analysis(evidence: Evidence) -> Contradiction | None:
    """Table 2.5 prints the sum of squares between the times, and sums that are parts of the total."""
    sums = {name: float(evidence.printed[name]) for name in PRINTED_SUMS.split()}
    time, total, printed = sums["2.anova.C.ss"], sum(sums.values()), float(evidence.printed[evidence.id])
    if 100 * time / total >= printed or not as_printed(evidence, PRINTED_SUMS):
        return None
    return Contradiction(
        "Table 2.5",
        f"the sum of squares of time is {time:g} of at least {total:.3f}, so that no function of time alone explains "
        f"more than {100 * time / total:.0f} % of these yields",
    )


@claim("5.shap.first")
def first_feature(evidence: Evidence) -> Finding:
    """Fig. 5.4: the feature that moves the predictions of both tree models most."""
    table = evidence.rows("yield/shap_ranking.tsv", "feature, mean_abs_shap_pp")
    first, words = [], []
    for model, rows in table.groupby("model", sort=False):
        ranked = rows.sort_values("mean_abs_shap_pp", ascending=False)
        first.append(ranked["feature"].iloc[0].removesuffix("_h"))
        words.append(f"{model}: {in_words(ranked.head(3), '{feature} {mean_abs_shap_pp:.1f}')}")
    return Finding(" / ".join(dict.fromkeys(first)), f"mean |SHAP| in points over all runs; {'; '.join(words)}")
