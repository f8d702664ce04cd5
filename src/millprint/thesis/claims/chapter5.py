"""Claims of thesis chapter 5: yield models on the locked split and outside their domain; and of its text."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pandas as pd

from millprint.config.yields import TrainingConfig
from millprint.thesis.claims.evidence import (
    Contradiction,
    Evidence,
    Finding,
    NotRun,
    Repeats,
    as_printed,
    claim,
    in_words,
    repeats_of,
    yes_no,
)
from millprint.thesis.yields.features import (
    FREQUENCY,
    GAINS,
    LEFT_OUT,
    NESTED,
    NORMAL,
    RANDOM,
    TANGENTIAL,
    YieldWeights,
)
from millprint.thesis.yields.regressors import regressor

UNITS = {"rmse": " pp", "mae": " pp", "mape": " %", "r2": "", "wmse": " pp2"}
# Rows of yield/seeds.tsv of models that differ only in a seed.
SEEDED = ("seed", "search_seed")
# Disjoint parts of the sum of squares of the yields, Table 2.5; the residual is not printed.
PRINTED_SUMS = "2.anova.A.ss 2.anova.B.ss 2.anova.C.ss 2.anova.D.ss 2.anova.AB.ss 2.anova.AC.ss 2.anova.BC.ss"
# Other ways to split the rows, in the order in which an explanation names them.
SCHEMES = {LEFT_OUT: "leave-one-out", NESTED: "nested cross-validation", RANDOM: "other splits of this size"}
OVER_REPEATS = "over {repeats:g} of them {lowest:.3g} to {highest:.3g}, median {median:.3g}"


@claim("5.linear.{metric}")
@claim("5.{model}.{strategy}.{metric}")
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
    return Finding(value, told, repeats=_over_seeds(evidence, model, strategy, metric, value))


def _over_seeds(evidence: Evidence, model: str, strategy: str, column: str, value: float) -> Repeats | None:
    """The interval of one more seed of search and trees, as the printed number is of one; None of a model without."""
    own = f"model == '{model}' and strategy == '{strategy}' and choice in {SEEDED}"
    others = evidence.table("yield/seeds.tsv", own)
    return repeats_of([value, *others[column]], "seeds", one_more=True) if len(others) else None


@claim("5.ood.{case}.{model}")
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
        repeats=_over_seeds(evidence, model, "two_step", f"case_{case}_percent", float(row["predicted_percent"])),
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
        f"the sum of squares of time is {time:g} of at least {total:.3f}, so no function of only the time explains "
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


HONEST, SHAP = "yield/scores_by_scheme.tsv", "yield/shap_ranking.tsv"
# The learned models of the thesis; the linear one is its baseline.
MODELS, BASELINE = ("gpr", "rf", "svr", "xgb"), "linear"
STRATEGIES = ("primary", "two_step")
MECHANICAL = (NORMAL, TANGENTIAL, FREQUENCY)
RANKS = {"second": 1, "third": 2}


def _errors(evidence: Evidence, scheme: str = "locked") -> pd.DataFrame:
    """The weighted error [pp2] of the models of the thesis; rows: model, columns: strategy. The locked ones decide."""
    models = f"model in {[BASELINE, *MODELS]} and strategy in {list(STRATEGIES)}"
    where = f"scheme == '{scheme}' and metric == 'wmse' and {models}"
    absent = "yields has not all models of the thesis, in one step and in two"
    if scheme != "locked":
        rows = evidence.table(HONEST, where)
        return rows.pivot(index="model", columns="strategy", values="value") if len(rows) else pd.DataFrame()
    rows = evidence.rows(HONEST, "value", where, absent)
    errors = rows.pivot(index="model", columns="strategy", values="value")
    if not {BASELINE, *MODELS} <= set(errors.index) or errors.reindex(MODELS).isna().any(axis=None):
        raise NotRun(absent)
    return errors


def _ranked(errors: pd.DataFrame) -> pd.Series:
    """Errors by model and strategy, smallest first."""
    return errors.stack().sort_values() if len(errors) else pd.Series(dtype=float)


def _by_leaving_out(evidence: Evidence) -> str:
    """The order of the models where every run is left out once, in words."""
    ranked = _ranked(_errors(evidence, LEFT_OUT))
    words = ", ".join(f"{model} {strategy} {value:.0f}" for (model, strategy), value in ranked.head(4).items())
    return f"; leave-one-out, over all runs: {words}" if words else ""


# Of the test rows, drawn again with replacement.
DRAWS, ENDS, RESAMPLED = 500, (0.025, 0.975), "resamples of the test rows"


def _resampled(evidence: Evidence, say: Callable[[pd.DataFrame], float | str]) -> Repeats | None:
    """The interval of what the weighted errors say, with the test rows drawn again; None without their predictions."""
    rows = evidence.table("yield/predictions.tsv", "role == 'test'")
    if rows.empty:
        return None
    weights = YieldWeights.of(TrainingConfig())(rows["yield_percent"].to_numpy())
    errors = rows.assign(error=weights * rows["error_pp"] ** 2)
    known = _ranked(_errors(evidence)).dropna().index
    errors = errors.pivot(index="case", columns=["model", "strategy"], values="error")[known]
    draws = np.random.default_rng(0).integers(len(errors), size=(DRAWS, len(errors)))
    values = [say(pd.Series(one, known).unstack()) for one in errors.to_numpy()[draws].mean(axis=1)]
    here = say(errors.mean().unstack())
    if isinstance(here, float):
        return _between(np.array(values, dtype=float))
    other = pd.Series(values).value_counts().drop(here, errors="ignore")
    return Repeats(str(other.index[0]) if other.sum() > ENDS[0] * DRAWS else here, here, RESAMPLED, DRAWS)


def _between(values: np.ndarray) -> Repeats:
    low, high = np.quantile(values, ENDS)
    return Repeats(float(low), float(high), RESAMPLED, len(values))


@claim("5.order.first")
def best_model(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: the model with the smallest weighted error on the locked test set."""
    ranked = _ranked(_errors(evidence))
    words = ", ".join(f"{model} {strategy} {value:.0f}" for (model, strategy), value in ranked.head(4).items())
    told = f"weighted error in pp2, of 6 runs: {words}{_by_leaving_out(evidence)}"
    repeats = _resampled(evidence, lambda errors: " ".join(_ranked(errors).index[0]))
    return Finding(" ".join(ranked.index[0]), told, repeats=repeats)


@claim("5.order.two_step")
def order_of_the_models(evidence: Evidence) -> Finding:
    """Sec. 5.4: the three best of the two-step models by the weighted error on the locked test set."""
    errors = _errors(evidence)["two_step"].dropna().sort_values()
    words = ", ".join(f"{model} {value:.0f}" for model, value in errors.items())
    told = f"weighted error in pp2, of 6 runs: {words}{_by_leaving_out(evidence)}"
    repeats = _resampled(evidence, lambda errors: ", ".join(errors["two_step"].dropna().sort_values().index[:3]))
    return Finding(", ".join(errors.index[:3]), told, repeats=repeats)


@claim("5.two_step.{model}")
def gain_of_two_steps(evidence: Evidence, model: str) -> Finding:
    """Sec. 5.3.2: whether a model has a smaller weighted error in two steps."""
    own, all_runs = _errors(evidence).loc[model], _errors(evidence, LEFT_OUT)
    told = f"weighted error {own['primary']:.0f} in one step and {own['two_step']:.0f} in two, of 6 runs"
    if model in all_runs.index and all_runs.loc[model].notna().all():
        other = all_runs.loc[model]
        told += f"; leave-one-out, over all runs: {other['primary']:.0f} and {other['two_step']:.0f}"
    repeats = _resampled(evidence, lambda errors: "yes" if errors.loc[model].diff().iloc[-1] < 0 else "no")
    return replace(yes_no(bool(own["two_step"] < own["primary"]), told), repeats=repeats)


@claim("5.primary.improvement")
def improvement_of_the_primary_models(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: by how much the primary models reduce the weighted error of the linear one, on average [%]."""

    def reduced(errors: pd.DataFrame) -> pd.Series:
        return 100 * (1 - errors.loc[list(MODELS), "primary"] / errors.at[BASELINE, "primary"])

    own = reduced(_errors(evidence))
    told = ", ".join(f"{model} {value:.0f} %" for model, value in own.items())
    repeats = _resampled(evidence, lambda errors: float(reduced(errors).mean()))
    return Finding(float(own.mean()), told, repeats=repeats)


@claim("5.high_yields")
def errors_at_high_yields(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: the error of the two-step GPR above a yield of 70 % over that below, each run left out once."""
    path = "yield/held_out/gpr_two_step.tsv"
    rows = evidence.rows(path, "yield_percent, predicted_percent", f"scheme == '{LEFT_OUT}'", f"{path}: no {LEFT_OUT}")
    # A run in every order of the rows is one run.
    rows = rows.assign(error=(rows["predicted_percent"] - rows["yield_percent"]).abs())
    rows = rows.groupby("case", as_index=False)[["yield_percent", "error"]].mean()
    error = rows["error"]
    high = rows["yield_percent"] > 70
    ratio = float(error[high].mean() / error[~high].mean())
    draws = np.random.default_rng(0).integers(len(rows), size=(DRAWS, len(rows)))
    drawn = [error.to_numpy()[own] for own in draws], [high.to_numpy()[own] for own in draws]
    found = [
        one[above].mean() / one[~above].mean() for one, above in zip(*drawn, strict=True) if 0 < above.sum() < len(one)
    ]
    told = f"{error[high].mean():.1f} points in {high.sum()} runs, and {error[~high].mean():.1f} in the others"
    return Finding(ratio, told, repeats=_between(np.array(found)))


def _ranking(evidence: Evidence, model: str) -> pd.DataFrame:
    rows = evidence.rows(SHAP, "feature, mean_abs_shap_pp", f"model == '{model}'", f"no SHAP values of {model}")
    return rows.sort_values("mean_abs_shap_pp", ascending=False)


@claim("5.shap.{model}.{rank}")
def later_feature(evidence: Evidence, model: str, rank: str) -> Finding:
    """Fig. 5.4: the feature of the second or third largest mean |SHAP|."""
    ranked = _ranking(evidence, model)
    return Finding(
        ranked["feature"].iloc[RANKS[rank]],
        f"mean |SHAP| in points: {in_words(ranked.head(4), '{feature} {mean_abs_shap_pp:.1f}')}",
    )


@claim("5.shap.mechanics")
def mechanical_features(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: whether energies and collisions move the predictions of both tree models less than three others."""
    holds, words = True, []
    for model in ("xgb", "rf"):
        ranked = _ranking(evidence, model).set_index("feature")["mean_abs_shap_pp"]
        largest = ranked.reindex(MECHANICAL).max()
        holds &= bool(largest < ranked.iloc[2])
        words.append(f"{model}: at most {largest:.1f}, the third feature has {ranked.iloc[2]:.1f}")
    return yes_no(holds, f"mean |SHAP| in points; {'; '.join(words)}; all runs have one fill ratio")
