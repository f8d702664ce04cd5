"""Claims in the text of thesis chapter 5: which model is best, what two steps do, and what the features say."""

import pandas as pd

from millprint.thesis.claims.evidence import Evidence, Finding, NotRun, claim, in_words, yes_no
from millprint.thesis.yields.features import FREQUENCY, NORMAL, TANGENTIAL
from millprint.thesis.yields.metrics import LEFT_OUT

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


@claim("5.order.first")
def best_model(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: the model with the smallest weighted error on the locked test set."""
    ranked = _ranked(_errors(evidence))
    words = ", ".join(f"{model} {strategy} {value:.0f}" for (model, strategy), value in ranked.head(4).items())
    return Finding(" ".join(ranked.index[0]), f"weighted error in pp2, of 6 runs: {words}{_by_leaving_out(evidence)}")


@claim("5.order.two_step")
def order_of_the_models(evidence: Evidence) -> Finding:
    """Sec. 5.4: the three best of the two-step models by the weighted error on the locked test set."""
    errors = _errors(evidence)["two_step"].dropna().sort_values()
    words = ", ".join(f"{model} {value:.0f}" for model, value in errors.items())
    return Finding(", ".join(errors.index[:3]), f"weighted error in pp2, of 6 runs: {words}{_by_leaving_out(evidence)}")


@claim("5.two_step.{model}", "5.two_step.gpr 5.two_step.rf 5.two_step.xgb")
def gain_of_two_steps(evidence: Evidence, model: str) -> Finding:
    """Sec. 5.3.2: whether a model has a smaller weighted error in two steps."""
    own, all_runs = _errors(evidence).loc[model], _errors(evidence, LEFT_OUT)
    told = f"weighted error {own['primary']:.0f} in one step and {own['two_step']:.0f} in two, of 6 runs"
    if model in all_runs.index and all_runs.loc[model].notna().all():
        other = all_runs.loc[model]
        told += f"; leave-one-out, over all runs: {other['primary']:.0f} and {other['two_step']:.0f}"
    return yes_no(bool(own["two_step"] < own["primary"]), told)


@claim("5.primary.improvement")
def improvement_of_the_primary_models(evidence: Evidence) -> Finding:
    """Sec. 5.3.2: by how much the primary models reduce the weighted error of the linear one, on average [%]."""
    errors = _errors(evidence)["primary"]
    reduced = 100 * (1 - errors[list(MODELS)] / errors[BASELINE])
    return Finding(float(reduced.mean()), ", ".join(f"{model} {value:.0f} %" for model, value in reduced.items()))


@claim(
    "5.ood.error.{case}.{model}",
    "5.ood.error.27.gpr 5.ood.error.28.gpr 5.ood.error.27.xgb 5.ood.error.28.xgb",
)
def error_outside_the_domain(evidence: Evidence, case: str, model: str) -> Finding:
    """Table 5.8: how far a two-step model is from the measured yield [percentage points]."""
    path = "yield/out_of_domain.tsv"
    where = f"case == {case} and model == '{model}' and strategy == 'two_step'"
    row = evidence.row(path, "error_pp", where, f"results/{path} has no case {case} of {model}")
    return Finding(abs(float(row["error_pp"])), f"predicted {row['predicted_percent']:.1f} %")


def _ranking(evidence: Evidence, model: str) -> pd.DataFrame:
    rows = evidence.rows(SHAP, "feature, mean_abs_shap_pp", f"model == '{model}'", f"no SHAP values of {model}")
    return rows.sort_values("mean_abs_shap_pp", ascending=False)


@claim(
    "5.shap.{model}.{rank}",
    "5.shap.xgb.second 5.shap.xgb.third 5.shap.rf.second 5.shap.rf.third",
)
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
