"""Appendix A: every ablation with the same budget, next to the statement of the thesis."""

from dataclasses import dataclass

import pandas as pd

BASELINE = "baseline"
DISSIPATION, PLATEAU = "dissipation_error_percent", "position_mse_plateau_m2"
# A statement that cannot be checked with this budget, because the baseline itself is unstable.
OPEN = "open"
# A dissipation that "grows without bound" must have an error larger than itself [%].
UNBOUNDED_PERCENT = 100.0
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
) -> pd.DataFrame:
    """A row for each ablation: its change, its budget, its measures on the trained motion, and the thesis's statement.

    metrics: rows of metrics.tsv; histories: loss by the variant whose weights are used; changes: texts;
    length_s: of the roll-outs; printed: as `millprint.tables.read_printed`. Column `holds` is yes, no, OPEN, or empty
    without a statement or a baseline.
    """
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
    known = table.set_index("variant")
    table["holds"] = [_verdict(row, known) for _, row in table.iterrows()]
    return table


def _verdict(row: pd.Series, known: pd.DataFrame) -> str:
    checked = STATEMENTS.get(row["variant"], OURS).checked
    if not checked or BASELINE not in known.index:
        return ""
    baseline = known.loc[BASELINE]
    if baseline["stable"] != 1:
        return OPEN
    return "yes" if holds(checked, row, baseline) else "no"
