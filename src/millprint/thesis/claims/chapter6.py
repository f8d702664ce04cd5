"""Claims of thesis chapter 6 and appendix A: the surrogate."""

from dataclasses import replace

import numpy as np
import pandas as pd

from millprint.estimate.judge import AGREES, DIFFERS, OPEN
from millprint.thesis.claims.chapter3 import CONTACT, MILL
from millprint.thesis.claims.evidence import Evidence, Finding, NotRun, Repeats, claim, yes_no
from millprint.thesis.surrogate.measures import (
    BASELINE,
    DISSIPATION,
    NOTHING,
    PLATEAU,
    SOMETHING,
    plateau,
    relative_error_percent,
)

VARIANT = "thesis"
# The motion of a test, in words.
TRAINED_TEST, TRAINED, UNSEEN = "trained", "the motion of the training", "a motion that was not trained on"
# What an interval is over.
TRAININGS = "trainings"
CORRELATIONS = -1.0, 1.0
# Tables 6.1 and 6.3.
SURROGATE_STEP_S, DEM_STEP_S = 1e-4, 9.5e-7
# Secs 6.2.2 and 6.3.4: the length of a roll-out [s], and the time that the thesis's simulation of it took [s].
STATED_S, DEM_S = 15.0, 22_734
# Figs 6.7 and 6.8: the thesis's simulation ends after this time, so that it compares no more of the roll-out [s].
COMPARED_S = 5.0
# Sec. 6.2.2: epochs of the thesis's training.
STATED_EPOCHS = 2000
# Tables of a roll-out by time: its position error; its dissipation, and that of the simulation.
ERRORS, CUMULATIVE = "errors.tsv", "dissipation.tsv"


@claim("6.timestep")
def time_step(evidence: Evidence) -> Finding:
    """Sec. 6.2.2."""
    evidence.cite("src/millprint/thesis/claims/chapter6.py", "SURROGATE_STEP_S, DEM_STEP_S", time_step)
    return Finding(100 * (SURROGATE_STEP_S / DEM_STEP_S - 1), "1e-4 s over 9.5e-7 s of Tables 6.3 and 6.1, less one")


@claim("6.duration")
def contact_duration(evidence: Evidence) -> Finding:
    """Sec. 6.2.2: of the simulation that the surrogate is trained on.

    Other seeds of this condition are shorter runs for other purposes, such as a smoke run in the same folder.
    """
    run = f"{MILL}/{CONTACT}/d10_f0.10_n300_s0"
    row = evidence.row(f"dem/{run}/summary.json", "median_contact_duration_s")
    return Finding(float(row["median_contact_duration_s"]), "median of the contact lifetimes of 24 balls in one run")


def _measure(evidence: Evidence, test: str, measure: str) -> pd.Series:
    """A measure of the variant of the thesis in a test, which decides a claim, and `told`: of what roll-out it is.

    A shorter roll-out than the stated one decides only if it runs away.
    """
    path = f"surrogate/{VARIANT}/metrics.tsv"
    row = evidence.row(path, "value", f"test == '{test}' and measure == '{measure}'")
    # Draws of trainings have the sizes of what did not run away only.
    runs_away = (evidence.table(path, f"test == '{test}' and measure == 'stable'")["value"] != 1).any()
    ended = ", which runs away" if runs_away else ""
    seeds = f"; two DEM seeds give {row['dem_reference']:.3g}" if np.isfinite(row["dem_reference"]) else ""
    told = f"over {row['length_s']:g} s of {TRAINED if test == TRAINED_TEST else UNSEEN}{ended}{seeds}"
    if row["length_s"] < STATED_S and not runs_away:
        raise NotRun(
            f"{STATED_S:g} s are stated, and this roll-out ends after {row['length_s']:g} s; "
            f"{measure} {row['value']:.3g}, {told}"
        )
    # What ran away has no size.
    value = np.inf if runs_away and measure != "stable" else row["value"]
    return pd.concat([row.drop("value"), pd.Series({"value": value, "told": told})])


def _measured(evidence: Evidence, test: str, measure: str) -> Finding:
    row = _measure(evidence, test, measure)
    told = f"{row['told']}{_over_the_compared(evidence, test, measure)}"
    return Finding(float(row["value"]), told, limits=(0.0, np.inf), smaller=_budget(evidence))


def _budget(evidence: Evidence) -> str:
    """`_smaller` of the training of the variant of the thesis."""
    return _smaller(len(evidence.table(f"surrogate/{VARIANT}/loss.tsv")))


def _smaller(epochs: int) -> str:
    """That a training has fewer epochs than the thesis's, in words; empty of one that has as many."""
    if not 0 < epochs < STATED_EPOCHS:
        return ""
    return f"trained for {epochs} of the thesis's {STATED_EPOCHS:,} epochs, so that a miss says nothing of the thesis"


def _over_the_compared(evidence: Evidence, test: str, measure: str) -> str:
    """The same measure over the first COMPARED_S of a longer roll-out, in words; empty without its tables."""
    name = {PLATEAU: ERRORS, DISSIPATION: CUMULATIVE}.get(measure)
    table = evidence.table(f"surrogate/{VARIANT}/{name}", f"test == '{test}'") if name else pd.DataFrame()
    if table.empty or table["time_s"].max() <= COMPARED_S:
        return ""
    part = table[table["time_s"] <= COMPARED_S * (1 + 1e-9)]
    if measure == PLATEAU:
        value = plateau(part[["surrogate_m2"]].to_numpy())
    else:
        value = relative_error_percent(part[["surrogate_J"]].to_numpy(), part[["dem_J"]].to_numpy())
    return f"; over the first {COMPARED_S:g} s, which the thesis compares, {value:.3g}"


@claim("6.mse")
def position_error(evidence: Evidence) -> Finding:
    """Sec. 6.4: on the trained motion, the roll-out begins after the time of the training."""
    return _measured(evidence, TRAINED_TEST, PLATEAU)


@claim("6.mse.{test}")
def position_error_of_an_unseen_motion(evidence: Evidence, test: str) -> Finding:
    """Sec. 6.3.2: the plateau of an unseen motion over that of the trained one."""
    trained, unseen = (float(_measure(evidence, name, PLATEAU)["value"]) for name in (TRAINED_TEST, test))
    if not np.isfinite(trained):
        raise NotRun("the roll-out on the motion of the training runs away, so that nothing compares with it")
    own = _measured(evidence, test, PLATEAU)
    return replace(own, value=unseen / trained, explanation=f"{unseen:.3g} over {trained:.3g} m2; {own.explanation}")


@claim("6.energy.{test}")
@claim("6.energy")
def dissipation(evidence: Evidence, test: str = TRAINED_TEST) -> Finding:
    """Secs 6.3.1 and 6.3.2: the error of the cumulative dissipation."""
    return _measured(evidence, test, DISSIPATION)


@claim("6.pearson")
def correlation(evidence: Evidence) -> Finding:
    """Sec. 6.3.2: of the cumulative curves."""
    rows = [_measure(evidence, test, "cumulative_pearson_r") for test in ("motion1", "motion2")]
    own, smaller = [row["value"] for row in rows], _budget(evidence)
    if not np.isfinite(own).all():
        told = f"a roll-out is not finite, so that nothing correlates; {rows[0]['told']}"
        return Finding(0.0, told, limits=CORRELATIONS, failed=True, smaller=smaller)
    return Finding(float(min(own)), f"the smaller of two; {rows[0]['told']}", limits=CORRELATIONS, smaller=smaller)


@claim("6.geometry")
def modified_geometry(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: a jar with a post."""
    stable = _measure(evidence, "post", "stable")
    return replace(yes_no(stable["value"] == 1, stable["told"]), smaller=_budget(evidence))


@claim("6.geometry.own")
def dissipation_of_its_own_jar(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: the roll-out in the jar with a post against our simulation of that jar, by the error stated there."""
    return _measured(evidence, "post", DISSIPATION)


@claim("6.geometry.dissipation")
def dissipation_of_the_original(evidence: Evidence) -> Finding:
    """Sec. 6.3.3: the roll-out in the jar with a post against the simulation of the jar without one."""
    return _measured(evidence, "post", "dissipation_error_original_percent")


@claim("6.runtime.ratio")
def speed_up(evidence: Evidence) -> Finding:
    """Sec. 6.3.4: of one trajectory of the thesis's Emax case, the one with the fewest balls."""
    where = f"variant == '{VARIANT}' and batch == 1 and balls == balls.min()"
    row = evidence.row("surrogate/runtime.tsv", "dem_seconds_for_15_s, seconds_for_15_s", where)
    return Finding(
        float(row["dem_seconds_for_15_s"] / row["seconds_for_15_s"]),
        f"our DEM over our surrogate in the same job: {int(row['balls'])} balls, {row['basis']}; our DEM takes "
        f"{row['dem_seconds_for_15_s']:.3g} s for what took the thesis's {DEM_S:,} s",
    )


@claim("6.runtime.distance")
def time_of_the_distances(evidence: Evidence) -> Finding:
    """Secs 6.3.4 and 6.4: that the signed distance to the wall takes most of a roll-out's time."""
    evidence.cite("src/millprint/thesis/claims/chapter6.py", "no table", time_of_the_distances)
    raise NotRun("runtime.tsv has whole roll-outs only; no table has the parts of their time")


# What a verdict on a statement is as the value of a claim.
SAID = {AGREES: "yes", DIFFERS: "no"}


def _ablation(evidence: Evidence, variant: str, column: str) -> Finding:
    """A column of an ablation, compared with the baseline of the same budget."""
    path = "surrogate/ablations.tsv"
    row, baseline = (
        evidence.row(path, column, f"variant == '{variant}'"),
        evidence.table(path, f"variant == '{BASELINE}'"),
    )
    if baseline.empty:
        raise NotRun(f"no ablation {BASELINE}")
    told = (
        f"dissipation error {row[DISSIPATION]:.3g} % against {baseline[DISSIPATION].iloc[0]:.3g} % of the baseline; "
        f"{int(row['epochs'])} epochs (the thesis: {STATED_EPOCHS:,}), roll-out of {row['rollout_s']:g} s"
    )
    if row["verdict"] == OPEN:
        told = f"the baseline runs away too at this budget, so nothing follows; {told}"
    # Only where the baseline was trained more than once is its scatter known.
    known = row.get("says") in (SOMETHING, NOTHING)
    interval = _interval(row, column, int(baseline["trainings"].iloc[0])) if known else None
    return Finding(SAID.get(row[column], row[column]), told, repeats=interval, smaller=_smaller(int(row["epochs"])))


def _interval(row: pd.Series, column: str, of_baseline: int) -> Repeats:
    """The interval of a column of an ablation, by its own trainings or by how those of the baseline scatter."""
    own = int(row["trainings"])
    if column == DISSIPATION:
        origin, repeats = (TRAININGS, own) if own > 1 else (f"{TRAININGS} of the baseline", of_baseline)
        return Repeats(float(row["lower_percent"]), float(row["upper_percent"]), origin, repeats)
    open_to_chance = row["says"] == NOTHING or row["verdict"] == OPEN
    lower, upper = ("no", "yes") if open_to_chance else (SAID[row[column]], SAID[row[column]])
    return Repeats(lower, upper, f"{TRAININGS} of the baseline", of_baseline)


@claim("A.{variant}")
def statement_on_an_ablation(evidence: Evidence, variant: str) -> Finding:
    """Whether the statement of appendix A on an ablation holds here."""
    return _ablation(evidence, variant, "verdict")


@claim("A.phi.shallow")
@claim("A.phi.deep")
@claim("A.global_loss")
def error_of_an_ablation(evidence: Evidence) -> Finding:
    """Figs A.7 to A.9: the error of the dissipation, where the thesis prints one."""
    variants = {"A.phi.shallow": "phi_shallow", "A.phi.deep": "phi_deep", "A.global_loss": "no_global_loss"}
    return _ablation(evidence, variants[evidence.id], DISSIPATION)
