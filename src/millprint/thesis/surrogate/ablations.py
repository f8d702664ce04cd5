"""Appendix A: every ablation with the same budget, next to the statement of the thesis."""

from dataclasses import dataclass

import pandas as pd

from millprint.statistics.student import apart, once, spread_of

BASELINE = "baseline"
DISSIPATION, PLATEAU = "dissipation_error_percent", "position_mse_plateau_m2"
# A statement that cannot be checked with this budget, because the baseline itself is unstable.
OPEN = "open"
# A dissipation that "grows without bound" must have an error larger than itself [%].
UNBOUNDED_PERCENT = 100.0
# Whether a row differs from the baseline by more than two trainings of the baseline do.
SOMETHING, NOTHING = "something", "nothing"
AGAINST = (
    "trainings",
    "lower_percent",
    "upper_percent",
    "from_baseline_percent",
    "baseline_apart_percent",
    "says",
)
MEASURES = (
    "stable",
    "balls_left",
    "mean_square_speed_ratio",
    PLATEAU,
    DISSIPATION,
    "dissipation_power_W",
    "one_step_dissipation_bias_percent",
)


@dataclass(frozen=True)
class Statement:
    """What the thesis says: its text, what of it can be checked (see `holds`), and the claim on the error [%]."""

    text: str
    checked: str = ""
    claim: str = ""


STATEMENTS = {
    BASELINE: Statement("the settings of Table 6.3", claim="6.energy"),
    "window3": Statement("stable motion, less accurate dissipation (Fig. A.1)", "stable_and_worse"),
    "window9": Statement("unstable motion (Fig. A.2)", "unstable"),
    "layers2": Statement("balls stay inside but chaotic, dissipation grows without bound (Fig. A.3)", "grows"),
    "layers4": Statement("unstable motion (Fig. A.4)", "unstable"),
    "width64": Statement("stable and precise motion, inaccurate dissipation (Fig. A.5)", "stable_and_worse"),
    "mlp2": Statement("highly unstable motion (Fig. A.6)", "unstable"),
    "phi_shallow": Statement("dissipation overshoots (Fig. A.7)", "overshoots", "A.phi.shallow"),
    "phi_deep": Statement("dissipation undershoots (Fig. A.8)", "undershoots", "A.phi.deep"),
    "no_global_loss": Statement("stable motion, dissipation overshoots (Fig. A.9)", "overshoots", "A.global_loss"),
}
OURS = Statement("not in the thesis: another reading of it")


def holds(checked: str, row: pd.Series, baseline: pd.Series) -> bool:
    """Whether a statement of the thesis holds at our budget.

    `worse` is against the baseline of the same budget; to overshoot is to dissipate more power than the simulation.
    """
    stable, error = row["stable"] == 1, row[DISSIPATION]
    return bool(
        {
            "stable_and_worse": stable and error > baseline[DISSIPATION],
            "unstable": not stable,
            "grows": error > UNBOUNDED_PERCENT,
            "overshoots": row["dissipation_power_W"] > row["dem_power_W"],
            "undershoots": row["dissipation_power_W"] < row["dem_power_W"],
        }[checked]
    )


def ablation_table(
    metrics: pd.DataFrame,
    histories: dict[str, pd.DataFrame],
    changes: dict[str, str],
    length_s: dict[str, float],
    printed: pd.Series,
    trainings: dict[str, list[str]] | None = None,
) -> pd.DataFrame:
    """A row for each ablation: its change, its budget, its measures on the trained motion, and the thesis's statement.

    metrics: rows of metrics.tsv; histories: loss by the variant whose weights are used; changes: texts;
    length_s: of the roll-outs; printed: as `millprint.run.tables.read_printed`; trainings: by ablation, the names in
    metrics of all trainings of its weights, its own first; once if left out. Column `holds` is yes, no, OPEN, or empty
    without a statement or a baseline.

    One training is one draw. lower_percent and upper_percent: interval of the dissipation error, over the row's own
    trainings, or else as those of the baseline scatter; from_baseline_percent: how far the error is from that of the
    baseline, in points; baseline_apart_percent: how far two trainings of the baseline are apart at most; `says` is
    NOTHING where the first is not above the second and the motion is stable or not as that of some training of the
    baseline, or where the trainings of the baseline disagree on whether the statement holds. All empty if the
    baseline was trained once.
    """
    trainings = trainings or {variant: [variant] for variant in changes}
    rows = []
    for variant, change in changes.items():
        part = metrics[metrics["variant"] == variant].set_index("measure")
        row = {"variant": variant, "changed": change, "rollout_s": length_s[variant]}
        row |= {"epochs": len(histories[variant]), "training_s": float(histories[variant]["elapsed_s"].iloc[-1])}
        row |= {name: part["value"].get(name) for name in MEASURES}
        error = part["value"][DISSIPATION]
        row["dem_power_W"] = part["value"]["dem_power_W"]
        said = STATEMENTS.get(variant, OURS)
        error_percent = float(printed[said.claim]) if said.claim else None
        row |= {"dem_seeds_percent": part["dem_reference"][DISSIPATION], "thesis_percent": error_percent}
        rows.append(row | {"thesis_statement": said.text, DISSIPATION: error})
    table = pd.DataFrame(rows)
    repeats = {variant: _repeats(metrics, trainings[variant]) for variant in changes}
    baselines = repeats.get(BASELINE, repeats[next(iter(repeats))].iloc[:0])
    table["holds"] = [_verdict(row, baselines.iloc[0]) if len(baselines) else "" for _, row in table.iterrows()]
    against = [_against(row, repeats[row["variant"]], baselines) for _, row in table.iterrows()]
    return table.join(pd.DataFrame(against, index=table.index))


def scatter_in_words(table: pd.DataFrame) -> str:
    """What the trainings of the baseline leave of the ablations, as a sentence; empty if it was trained once."""
    compared = table[table["says"].isin([SOMETHING, NOTHING])]
    if compared.empty:
        return ""
    silent = compared[compared["says"] == NOTHING]["variant"]
    named = f" ({', '.join(silent)})" if len(silent) else ""
    return (
        f"{len(silent)} of {len(compared)} ablations say nothing{named}: two trainings of the baseline are up to "
        f"{compared['baseline_apart_percent'].iloc[0]:.3g} points of the dissipation error apart."
    )


def _repeats(metrics: pd.DataFrame, names: list[str]) -> pd.DataFrame:
    """A row for each training: its measures on the trained motion, as far as a statement is about them."""
    values = metrics[metrics["variant"].isin(names)].pivot_table("value", "variant", "measure", "first", dropna=False)
    return values.loc[names].reset_index(drop=True)


def _verdict(row: pd.Series, baseline: pd.Series) -> str:
    checked = STATEMENTS.get(row["variant"], OURS).checked
    if not checked:
        return ""
    if baseline["stable"] != 1:
        return OPEN
    return "yes" if holds(checked, row, baseline) else "no"


def _against(row: pd.Series, own: pd.DataFrame, baselines: pd.DataFrame) -> dict:
    """Columns AGAINST of a row: its interval, and whether it says anything against the scatter of the baseline."""
    found: dict[str, float | str | None] = {"trainings": len(own)} | dict.fromkeys(AGAINST[1:])
    if len(baselines) < 2:
        return found | {"says": ""}
    errors, error = baselines[DISSIPATION].tolist(), float(row[DISSIPATION])
    found["lower_percent"], found["upper_percent"] = (
        spread_of(own[DISSIPATION].tolist()) if len(own) > 1 else once(error, errors)
    )
    if row["variant"] == BASELINE:
        return found | {"baseline_apart_percent": apart(errors), "says": ""}
    difference = apart([error, errors[0]])
    alike = difference <= apart(errors) and (baselines["stable"] == row["stable"]).any()
    disagreed = len({_verdict(row, baseline) for _, baseline in baselines.iterrows()}) > 1
    found |= {"from_baseline_percent": difference, "baseline_apart_percent": apart(errors)}
    return found | {"says": NOTHING if alike or disagreed else SOMETHING}
